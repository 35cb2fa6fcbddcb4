// A grain as the sun sees it: the disc through its centre, which casts its outer sphere's shadow, less what the
// shape leaves of it, on all that does not overlap the grain.
//
// In each cell of the sun's map one disc casts for all of about its size, the nearest to the sun. Class k is of
// discs with a radius of 2^-k of the largest, to the nearest k; its cells are as much smaller than those of class 0.
#include "shared/shadow.h"

const uint kCellClasses = 12u;  // the last one's cells are a texel, if the first one's are a whole map

layout(location = 0) uniform uint last_class;       // that of the smallest disc
layout(location = 1) uniform float per_largest;     // 1 / radius of the largest disc, in texels
layout(location = 2) uniform float shape_share;     // radius of the disc / outer radius
layout(location = 5) uniform vec4 cell_classes[kCellClasses];  // cells a texel; cells across; before the first

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

uint sunCell(Caster caster) {
  float share = caster.radius * per_largest;
  // The exponent of share^2 / 2: 126 for the largest, one less for each 1 / sqrt(2).
  int halves = 126 - int(floatBitsToUint(0.5 * share * share) >> 23u);
  vec4 cells_of = cell_classes[min(uint(max(halves, 0)) >> 1u, last_class)];
  vec2 cell = floor(clamp(caster.texel, vec2(0.0), shadow_view.size_px - 0.5) * cells_of.x);
  return uint(cell.y * cells_of.y + cell.x + cells_of.z);
}
