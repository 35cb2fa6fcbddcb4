// Outlines of a grain's mesh and of its impostor from an eye at any distance: how far apart they are.
#pragma once

#include <functional>

#include <cstdint>
#include <vector>

#include "modules/impostors/atlas.h"
#include "modules/impostors/unit_grain.h"

namespace scree::impostors {

// From where a grain is seen. Lengths are outer radii.
struct OutlineView {
  vec3 axis{0, 0, 1};  // unit, to the eye; right x up = axis
  vec3 right{1, 0, 0}, up{0, 1, 0};
  float nearness = 0;  // 1 / distance of the eye, below 1; 0: at infinity
};
OutlineView outlineView(const vec3& axis, float nearness);

// A square picture of which samples are covered, on the plane through the grain's centre that faces the eye.
struct OutlineMask {
  int side = 0;
  float samples_a_radius = 0;
  std::vector<uint8_t> covered;
};

OutlineMask meshOutline(const UnitGrain& grain, const OutlineView& view, float samples_a_radius);
// As programs draw it: with three views, or with the nearest alone (`small`), at a mip level of its coverage.
OutlineMask impostorOutline(const ImpostorAtlas& atlas, const OutlineView& view, int level, bool small,
                            float samples_a_radius);
// Of a disc around the centre.
OutlineMask discOutline(float radius, const OutlineView& view, float samples_a_radius);

// Area of what two masks do not share over the length of the second's outline, in outer radii: how far the outline is
// off, on the average along it.
double outlineOff(const OutlineMask& mask, const OutlineMask& truth);

// Searches for the worst views of an atlas: from many directions, then around the worst of them; what is found is
// raised by kOutlineMargin for those that were not. The same for every number of threads.
inline constexpr float kOutlineMargin = 1.1f;
ImpostorOutlines outlineBounds(const UnitGrain& grain, const ImpostorAtlas& atlas,
                               const std::function<void(double)>& progress = {});

}  // namespace scree::impostors
