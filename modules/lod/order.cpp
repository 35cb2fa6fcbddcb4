// Morton codes, sorted.
#include "modules/lod/order.h"

#include <algorithm>

#include <glm/common.hpp>

namespace scree::lod {
namespace {

constexpr float kSteps = 1024;

// Bit k of ten to bit 3 k.
uint32_t spread(uint32_t v) {
  v = (v | v << 16) & 0x030000ffu;
  v = (v | v << 8) & 0x0300f00fu;
  v = (v | v << 4) & 0x030c30c3u;
  return (v | v << 2) & 0x09249249u;
}

}  // namespace

std::vector<uint32_t> orderInSpace(std::span<const vec3> positions) {
  vec3 low(0), high(0);
  for (size_t k = 0; k < positions.size(); ++k) {
    low = k == 0 ? positions[k] : glm::min(low, positions[k]);
    high = k == 0 ? positions[k] : glm::max(high, positions[k]);
  }
  // Halves, as the box may be larger than a float. Cells are cubes.
  const vec3 half = 0.5f * high - 0.5f * low;
  const float side = std::max({half.x, half.y, half.z});
  std::vector<uint64_t> keys(positions.size());
  for (size_t k = 0; k < positions.size(); ++k) {
    const vec3 at = side > 0 ? (0.5f * positions[k] - 0.5f * low) / side : vec3(0);
    const glm::uvec3 step = glm::min(glm::uvec3(at * kSteps), glm::uvec3(static_cast<uint32_t>(kSteps) - 1));
    keys[k] = uint64_t{spread(step.x) | spread(step.y) << 1 | spread(step.z) << 2} << 32 | k;
  }
  std::sort(keys.begin(), keys.end());
  std::vector<uint32_t> order(positions.size());
  for (size_t k = 0; k < keys.size(); ++k) order[k] = static_cast<uint32_t>(keys[k]);
  return order;
}

}  // namespace scree::lod
