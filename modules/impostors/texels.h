// Sums of samples under a texel, their mip levels, and the bytes that are stored of them.
#pragma once

#include <span>
#include <vector>

#include "engine/core/math.h"

namespace scree::impostors {

// Everything but coverage is multiplied by it: sums of a texel add up to its parent's.
struct TexelSum {
  float coverage = 0;  // 0 to 1
  vec3 albedo{0};      // linear
  float metallic = 0;
  vec3 normal{0};
  float alpha2 = 0;  // squared GGX width, roughness^4
  float height = 0;
};

// What a texel shows where it is covered.
struct Texel {
  vec3 albedo{0.5f};
  float metallic = 0;
  vec3 normal{0, 0, 1};  // mean of unit ones, of a length of 1 - kMostSpread or more
  float roughness = 1;   // without the spread of the normals
  float height = 0;
  bool known = false;  // something was seen there, or near
};

// Half the side: means of two by two.
std::vector<TexelSum> halved(std::span<const TexelSum> sums, int side);

// Means of what was seen; normals that cancel give way to `axis`, with the most spread.
Texel meanOf(const TexelSum& sum, const vec3& axis);

// Continues known texels outwards: two rings from the neighbours, the rest from `coarser`, the
// level of half the side, all of which is known (empty: the coarsest level, which takes
// `fallback`).
void spreadOut(std::span<Texel> texels, int side, std::span<const Texel> coarser,
               const Texel& fallback);

struct StoredTexel {
  uint8_t shape[2], color[4], normal[4];
};
StoredTexel stored(float coverage, const Texel& texel);

}  // namespace scree::impostors
