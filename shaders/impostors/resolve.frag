// The surface of the grain that each pixel shows, into the G-buffer, with its depth. MOTION: somebody reads it.
#include "lib/gbuffer.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"

layout(binding = kPassTextureUnit) uniform usampler2D visible_grains;
layout(binding = kImpostorColorUnit) uniform sampler2DArray atlas_color;
layout(binding = kImpostorNormalUnit) uniform sampler2DArray atlas_normal;

in vec3 ray;

// By how much rasterised and computed depths of the disc may differ.
const float kDiscMargin = 1e-5;

void main() {
  uint number = texelFetch(visible_grains, ivec2(gl_FragCoord.xy), 0).r;
  uint grain = number - 1u - swarm.first;
  if (number == 0u || grain >= swarm.count) discard;
  uint route = representations[grain / 8u] >> 4u * (grain & 7u) & (kFirst - 1u);
  if (route != kImpostor && route != kSmallImpostor) discard;
  SwarmRecord record = records[grain];
  vec3 center = centerOf(record);
  float radius = radiusOf(record), scale = 1.0 / radius;
  vec4 rotation = unpackRotation(record.rotation);
  float inverse = 1.0 / dot(ray, ray);
  // The point of the ray that is nearest to the centre.
  ImpostorRay local;
  local.foot = toGrain(rotation, ray * (dot(center, ray) * inverse) - center) * scale;
  local.direction = toGrain(rotation, ray * sqrt(inverse));
  vec3 seen = impostorOnProxy(local, atlas.proxy);
  ImpostorViews views = impostorViews(toGrain(rotation, -center), atlas.edge);
  float diameter_px = 2.0 * sizePx(radius, length(center), view.pixels_at_1m);
  float level = float(impostorLevel(atlas.texels, diameter_px, kImpostorColorBias));
  float shape_level = float(impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias));

  uvec3 layer = uvec3(views.layer0, views.layer1, views.layer2);
  vec3 axis[3] = vec3[3](views.axis0, views.axis1, views.axis2);
  vec4 color = vec4(0.0), normal = vec4(0.0);
  float sum = 0.0, step = 0.0;
  for (int k = 0; k < 3; ++k) {
    vec3 at = vec3(impostorUv(seen, axis[k], atlas.extent), float(layer[k]));
    vec2 shape = textureLod(atlas_shape, at, shape_level).rg;
    float w = max(views.weight[k] * shape.r, 1e-6);
    vec4 c = textureLod(atlas_color, at, level);
    color += w * vec4(albedoFromCode(c.rgb), c.a);
    vec4 n = textureLod(atlas_normal, at, level);
    normal += w * vec4(impostorNormalFromCode(n.xyz), n.w);
    vec3 there = impostorStep(local, seen, axis[k], impostorHeightFromCode(shape.g));
    step += w * dot(there - seen, local.direction);
    sum += w;
  }
  float share = 1.0 / sum;
  // On the ray, in units of it: at the surface, and where visibility was decided, behind which nothing is put.
  vec3 surface = seen + local.direction * (step * share);
  float along = dot(center, ray) * inverse + dot(surface - local.foot, local.direction) * radius * sqrt(inverse);
  float distance2 = dot(center, center);
  float disc = route == kSmallImpostor ? (view.clip_from_relative * vec4(center, 1.0)).w
                                       : (distance2 - radius * radius) / dot(ray, center);
  along = clamp(along, view.near_m, disc * (1.0 - kDiscMargin));
  gl_FragDepth = view.near_m / along;

  Surface s;
  s.albedo = color.rgb * share * tintOf(record.look);
  s.metallic = color.a * share;
  s.normal_ws = rotateBy(rotation, normal.xyz);
  s.spread = 1.0 - length(normal.xyz) * share;
  s.roughness = normal.w * share * roughnessOf(record.look);
#ifdef MOTION
  vec3 previous = ray * along - swarm.origin.xyz + swarm.previous_origin.xyz;
  s.motion_px = motionFromPrevious((view.previous_clip_from_relative * vec4(previous, 1.0)).xyw, gl_FragDepth);
#else
  s.motion_px = vec2(0.0);
#endif
  s.id = idOf(grain);
  writeGbuffer(s);
}
