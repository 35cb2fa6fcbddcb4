// The surface of the grain that each pixel shows, into the G-buffer, with its depth. MOTION: somebody reads it.
#include "lib/gbuffer.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"
#include "impostors/surface.glsl"

layout(binding = kPassTextureUnit) uniform usampler2D visible_grains;

in vec3 ray;
// Of resolve.vert.
flat in vec4 swarm_origin;
flat in uvec4 swarm_numbers;
flat in vec3 proxy_center, proxy_diagonal, proxy_upper;
flat in ivec2 edge_texels;
flat in vec3 half_pixels_near;
flat in vec3 forward;

// By how much rasterised and computed depths of the disc may differ.
const float kDiscMargin = 1e-5;

// What the views say, weighted and summed up.
struct Seen {
  vec4 color, normal;
  float step, sum;
};
Seen seenBy(ImpostorRay local, vec3 seen, vec3 axis, uint layer, float weight, int shape_level, int level) {
  ImpostorBasis basis = impostorBasis(axis);
  vec2 uv = vec2(dot(seen, basis.right), dot(seen, basis.up)) * half_pixels_near.x + 0.5;
  float steps = coverageSteps(edge_texels.y, shape_level);
  vec2 shape = shapeAt(uv * steps, steps, coverageFrom(edge_texels.y, int(layer), shape_level));
  steps = coverageSteps(edge_texels.y, level);
  AtlasSurface surface = surfaceAt(uv * steps, steps, coverageFrom(edge_texels.y, int(layer), level));
  vec4 c = surface.color, n = surface.normal;
  float w = max(weight * shape.r, 1e-6);
  vec3 there = impostorStep(local, seen, axis, impostorHeightFromCode(shape.g));
  return Seen(w * vec4(albedoFromCode(c.rgb), c.a), w * vec4(impostorNormalFromCode(n.xyz), n.w),
              w * dot(there - seen, local.direction), w);
}

void main() {
  uint number = texelFetch(visible_grains, ivec2(gl_FragCoord.xy), 0).r;
  uint grain = number - 1u - swarm_numbers.x;
  if (number == 0u || grain >= swarm_numbers.y) discard;
  uint route = representations[grain / 8u] >> 4u * (grain & 7u) & (kFirst - 1u);
  if (route != kImpostor && route != kSmallImpostor) discard;
  SwarmRecord record = records[grain];
  vec3 center = swarm_origin.xyz + vec3(record.x, record.y, record.z);
  float radius = radiusOf(record.size, swarm_origin.w), scale = 1.0 / radius;
  vec4 rotation = unpackRotation(record.rotation);
  float inverse = 1.0 / dot(ray, ray);
  // The point of the ray that is nearest to the centre.
  ImpostorRay local;
  local.foot = toGrain(rotation, ray * (dot(center, ray) * inverse) - center) * scale;
  local.direction = toGrain(rotation, ray * sqrt(inverse));
  vec3 seen = impostorOnProxy(local, ImpostorProxy(vec4(proxy_center, 0.0), vec4(proxy_diagonal, 0.0), vec4(proxy_upper, 0.0)));
  ImpostorViews views = impostorViews(toGrain(rotation, -center), edge_texels.x);
  float diameter_px = 2.0 * sizePx(radius, length(center), half_pixels_near.y);
  int level = impostorLevel(edge_texels.y, diameter_px, kImpostorColorBias);
  int shape_level = impostorLevel(edge_texels.y, diameter_px, kImpostorShapeBias);

  // The nearest, then the others, if the grain is drawn by three. Of a loop that is tested at its end llvmpipe runs no
  // more turns than some pixel of a group needs.
  int nearest = views.weight.x >= max(views.weight.y, views.weight.z) ? 0 : views.weight.y >= views.weight.z ? 1 : 2;
  int turns = route == kSmallImpostor ? 1 : 3, turn = 0;
  vec4 color = vec4(0.0), normal = vec4(0.0);
  float sum = 0.0, step = 0.0;
  do {
    int k = (nearest + turn) % 3;
    vec3 axis = k == 0 ? views.axis0 : k == 1 ? views.axis1 : views.axis2;
    uint layer = k == 0 ? views.layer0 : k == 1 ? views.layer1 : views.layer2;
    float weight = k == 0 ? views.weight.x : k == 1 ? views.weight.y : views.weight.z;
    Seen one = seenBy(local, seen, axis, layer, weight, shape_level, level);
    color += one.color;
    normal += one.normal;
    step += one.step;
    sum += one.sum;
  } while (++turn < turns);
  float share = 1.0 / sum;
  // On the ray, in units of it: at the surface, and where visibility was decided, behind which nothing is put.
  vec3 surface = seen + local.direction * (step * share);
  float along = dot(center, ray) * inverse + dot(surface - local.foot, local.direction) * radius * sqrt(inverse);
  float distance2 = dot(center, center);
  float disc = route == kSmallImpostor ? dot(forward, center)
                                       : (distance2 - radius * radius) / dot(ray, center);
  along = clamp(along, half_pixels_near.z, disc * (1.0 - kDiscMargin));
  gl_FragDepth = half_pixels_near.z / along;

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
  s.id = swarm_numbers.z + grain * swarm_numbers.w;
  writeGbuffer(s);
}
