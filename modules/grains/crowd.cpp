// A grid of lists over a box: each sphere is in the lists of all cells that it reaches.
#include "modules/grains/crowd.h"

#include <algorithm>

#include "modules/grains/bodies.h"

namespace scree::grains {

void Crowd::reset(vec3 low, vec3 high, float largest) {
  low_ = low;
  high_ = high;
  largest_ = largest;
  size_t cells = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = high[axis] - low[axis];
    const float wanted = std::clamp(extent / (2 * largest), 1.0f, static_cast<float>(kMostCells));
    cells_[axis] = static_cast<int>(wanted);
    inverse_cell_[axis] = extent > 0 ? static_cast<float>(cells_[axis]) / extent : 0.0f;
    cells *= static_cast<size_t>(cells_[axis]);
  }
  first_.assign(cells, kNoSlot);
  node_.clear();
}

// Rises with x: what lies between two places is in the cells between theirs.
int Crowd::cellAlong(int axis, float x) const {
  const float cell = (x - low_[axis]) * inverse_cell_[axis];
  return static_cast<int>(std::clamp(cell, 0.0f, static_cast<float>(cells_[axis] - 1)));
}

void Crowd::add(vec3 position, float radius) {
  // A little more than it is, so that rounding hides none.
  const float reach = 1.0001f * (radius + largest_);
  int from[3], to[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float low = position[axis] - reach, high = position[axis] + reach;
    if (!(high >= low_[axis] && low <= high_[axis])) return;
    from[axis] = cellAlong(axis, low);
    to[axis] = cellAlong(axis, high);
  }
  for (int z = from[2]; z <= to[2]; ++z)
    for (int y = from[1]; y <= to[1]; ++y)
      for (int x = from[0]; x <= to[0]; ++x) {
        uint32_t& first = first_[static_cast<size_t>(x + cells_[0] * (y + cells_[1] * z))];
        node_.push_back({position, radius, first});
        first = static_cast<uint32_t>(node_.size() - 1);
      }
}

bool Crowd::free(vec3 position, float radius) const {
  const int x = cellAlong(0, position.x), y = cellAlong(1, position.y), z = cellAlong(2, position.z);
  uint32_t at = first_[static_cast<size_t>(x + cells_[0] * (y + cells_[1] * z))];
  for (; at != kNoSlot; at = node_[at].next) {
    const Node& other = node_[at];
    const dvec3 d = dvec3(position) - dvec3(other.position);
    const double sum = static_cast<double>(radius) + static_cast<double>(other.radius);
    if (d.x * d.x + d.y * d.y + d.z * d.z < sum * sum) return false;
  }
  return true;
}

}  // namespace scree::grains
