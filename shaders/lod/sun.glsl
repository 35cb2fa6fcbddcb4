// A grain as the sun sees it: the disc through its centre, which casts its outer sphere's shadow, less what the
// shape leaves of it, on all that does not overlap the grain.
//
// In each cell of the sun's map one disc casts for all of about its size, the nearest to the sun. Class k is of
// discs with a radius of 2^-k of the largest, to the nearest k; its cells are as much smaller than those of class 0.
#include "shared/shadow.h"

layout(location = 0) uniform uint cell_texels;      // side of a cell of class 0
layout(location = 1) uniform uint last_class;       // that of the smallest disc
layout(location = 2) uniform float largest_texels;  // radius of the largest disc
layout(location = 3) uniform float shape_share;     // radius of the disc / outer radius

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

uint cellSide(uint size_class) { return max(cell_texels >> size_class, 1u); }
uint cellsAcross(uint size_class) {
  uint side = cellSide(size_class);
  return (uint(shadow_view.size_px.x) + side - 1u) / side;
}

// A grain of the class of the largest, as all are in a swarm of equals, pays for no other.
uint sunCell(Caster caster) {
  float ratio = clamp(largest_texels / caster.radius, 1.0, 4096.0);  // 4096: texels of a map are fewer
  uint size_class = min(uint(findMSB(uint(2.0 * ratio * ratio))) >> 1u, last_class);
  uint first = 0u;
  for (uint k = 0u; k < size_class; ++k) first += cellsAcross(k) * cellsAcross(k);
  uvec2 cell = uvec2(clamp(caster.texel, vec2(0.0), shadow_view.size_px - 0.5)) / cellSide(size_class);
  return first + cell.y * cellsAcross(size_class) + cell.x;
}
