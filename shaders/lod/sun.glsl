// A grain as the sun sees it: the disc through its centre, which casts its outer sphere's shadow, less what the
// shape leaves of it, on all that does not overlap the grain.
#include "shared/shadow.h"

layout(location = 0) uniform float cell_texels;
layout(location = 1) uniform float shape_share;  // radius of the disc / outer radius

struct Caster {
  vec2 texel;
  float radius;  // texels
  uint key;      // nearer to the sun is greater; 0: it casts none
};

Caster casterOf(SwarmRecord grain) {
  Caster caster;
  vec3 p = vec3(shadow_view.shadow_from_relative * vec4(centerOf(grain), 1.0));
  caster.texel = p.xy;
  caster.radius = radiusOf(grain) * shape_share / shadow_view.texel_m;
  bool inside = all(greaterThan(p.xy, vec2(-caster.radius))) && all(lessThan(p.xy, shadow_view.size_px + caster.radius));
  caster.key = inside ? floatBitsToUint(clamp(p.z, 1e-9, 1.0)) : 0u;
  return caster;
}

uint sunCell(vec2 texel) {
  vec2 p = clamp(texel, vec2(0.0), shadow_view.size_px - 0.5);
  uvec2 cell = uvec2(p / cell_texels);
  return cell.y * uint(ceil(shadow_view.size_px.x / cell_texels)) + cell.x;
}
