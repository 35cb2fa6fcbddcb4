// All attributes of the views around the grain's direction, into the G-buffer.
#include "lib/gbuffer.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"

layout(binding = kImpostorColorUnit) uniform sampler2DArray atlas_color;
layout(binding = kImpostorNormalUnit) uniform sampler2DArray atlas_normal;

flat in vec3 center;
flat in vec4 rotation;
flat in vec3 weight;
flat in uvec3 layer;
flat in vec3 axis[3];
flat in vec2 levels;
flat in float radius;
flat in uint look;

void main() {
  vec3 ray = rayFromNdc(view.relative_from_clip, ndcFromPixel(view.size_px, gl_FragCoord.xy));
  ImpostorRay local;
  float inverse = 1.0 / dot(ray, ray);
  local.foot = toGrain(rotation, ray * (dot(center, ray) * inverse) - center) / radius;
  local.direction = toGrain(rotation, ray * sqrt(inverse));
  if (dot(local.foot, local.foot) > 1.0) discard;
  vec3 seen = impostorOnProxy(local, atlas.proxy);
  vec4 color = vec4(0.0), normal = vec4(0.0);
  float coverage = 0.0;
  for (int k = 0; k < 3; ++k) {
    vec3 at = vec3(impostorUv(seen, axis[k], atlas.extent), float(layer[k]));
    float w = weight[k] * textureLod(atlas_shape, at, levels.x).r;
    vec4 c = textureLod(atlas_color, at, levels.y);
    color += w * vec4(albedoFromCode(c.rgb), c.a);
    vec4 n = textureLod(atlas_normal, at, levels.y);
    normal += w * vec4(impostorNormalFromCode(n.xyz), n.w);
    coverage += w;
  }
  if (coverage < 0.5) discard;
  Surface s;
  s.albedo = color.rgb / coverage * tintOf(look);
  s.metallic = color.a / coverage;
  s.spread = 1.0 - length(normal.xyz) / coverage;
  s.normal_ws = rotateBy(rotation, normal.xyz);
  s.roughness = normal.w / coverage * roughnessOf(look);
  s.motion_px = vec2(0.0);
  s.id = 1u;
  writeGbuffer(s);
}
