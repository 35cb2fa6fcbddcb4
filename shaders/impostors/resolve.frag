// The surface of the grain that each pixel shows, into the G-buffer, with its depth. MOTION: somebody reads it.
#include "lib/gbuffer.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"
#include "impostors/surface.glsl"

layout(binding = kPassTextureUnit) uniform usampler2D visible_grains;

in vec3 ray;

// By how much rasterised and computed depths of the disc may differ.
const float kDiscMargin = 1e-5;

// What the views say, weighted and summed up.
struct Seen {
  vec4 color, normal;
  float step, sum;
};
Seen seenBy(ImpostorRay local, vec3 seen, vec3 axis, uint layer, float weight, int shape_level, int level) {
  vec2 uv = impostorUv(seen, axis, atlas.extent);
  float steps = coverageSteps(atlas.texels, shape_level);
  vec2 shape = shapeAt(uv * steps, steps, coverageFrom(atlas.texels, int(layer), shape_level));
  steps = coverageSteps(atlas.texels, level);
  AtlasSurface surface = surfaceAt(uv * steps, steps, coverageFrom(atlas.texels, int(layer), level));
  vec4 c = surface.color, n = surface.normal;
  float w = max(weight * shape.r, 1e-6);
  vec3 there = impostorStep(local, seen, axis, impostorHeightFromCode(shape.g));
  return Seen(w * vec4(albedoFromCode(c.rgb), c.a), w * vec4(impostorNormalFromCode(n.xyz), n.w),
              w * dot(there - seen, local.direction), w);
}

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
  int level = impostorLevel(atlas.texels, diameter_px, kImpostorColorBias);
  int shape_level = impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias);

  // In a loop their axes would be read from memory, by llvmpipe.
  Seen seen0 = seenBy(local, seen, views.axis0, views.layer0, views.weight.x, shape_level, level);
  Seen seen1 = seenBy(local, seen, views.axis1, views.layer1, views.weight.y, shape_level, level);
  Seen seen2 = seenBy(local, seen, views.axis2, views.layer2, views.weight.z, shape_level, level);
  vec4 color = seen0.color + seen1.color + seen2.color, normal = seen0.normal + seen1.normal + seen2.normal;
  float sum = seen0.sum + seen1.sum + seen2.sum, step = seen0.step + seen1.step + seen2.step;
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
