// The grid's search: each pair of neighbours once, in an order that only positions decide.
#include <algorithm>

#include "modules/grains/grid.h"

namespace scree::grains {

void Grid::read(const Bodies& bodies) {
  const uint32_t n = bodies.count;
  x_.resize(n + kMostLanes);
  y_.resize(n + kMostLanes);
  z_.resize(n + kMostLanes);
  for (uint32_t k = 0; k < n; ++k) {
    const vec3 p = bodies.body[k].position;
    x_[k] = p.x;
    y_[k] = p.y;
    z_[k] = p.z;
  }
  for (uint32_t k = n; k < n + kMostLanes; ++k) {  // read by the last group, then masked out
    x_[k] = y_[k] = z_[k] = 0;
    reach_[k] = 0;
  }
}

// Appends the slots in [begin, end) within reach of `slot`.
void Grid::scan(uint32_t slot, uint32_t begin, uint32_t end, std::vector<uint32_t>& found) const {
  constexpr uint32_t kMost = 120;  // candidates a call
  uint32_t hits[kMost + kMostLanes];
  const Reaches grains{x_.data(), y_.data(), z_.data(), reach_.data()};
  for (; begin < end; begin += kMost) {
    const uint32_t n = kernels_->scan(grains, slot, begin, std::min(end, begin + kMost), hits);
    found.insert(found.end(), hits, hits + n);
  }
}

// Scans the cells x0 to x1 of a row, which may wrap around; skips slots below `from`.
void Grid::rowRanges(const Level& level, int32_t x0, int32_t x1, int32_t y, int32_t z,
                     std::vector<uint32_t>& found, uint32_t slot, uint32_t from) const {
  const uint32_t row = bucketRow(level, y, z);
  const uint32_t first = static_cast<uint32_t>(x0) & level.mask_x;
  const uint32_t last = static_cast<uint32_t>(x1) & level.mask_x;
  if (first <= last) {
    scan(slot, std::max(from, bucket_begin_[row + first]), bucket_begin_[row + last + 1], found);
  } else {
    scan(slot, std::max(from, bucket_begin_[row]), bucket_begin_[row + last + 1], found);
    scan(slot, std::max(from, bucket_begin_[row + first]), bucket_begin_[row + level.mask_x + 1],
         found);
  }
}

void Grid::neighbours(uint32_t slot, std::vector<uint32_t>& found) const {
  const Level& own = level_[level_of_[slot]];
  const int32_t x = cellOf(x_[slot], own.inverse_cell), y = cellOf(y_[slot], own.inverse_cell),
                z = cellOf(z_[slot], own.inverse_cell);
  const size_t before = found.size();
  // The grain's own cell from the grain on, and the 13 of 26 cells around that come later.
  const uint32_t row = bucketRow(own, y, z);
  const uint32_t column = static_cast<uint32_t>(x) & own.mask_x;
  if (column < own.mask_x) {
    scan(slot, slot + 1, bucket_begin_[row + column + 2], found);
  } else {
    scan(slot, slot + 1, bucket_begin_[row + column + 1], found);
    scan(slot, bucket_begin_[row], bucket_begin_[row + 1], found);
  }
  rowRanges(own, x - 1, x + 1, y + 1, z, found, slot, 0);
  for (int32_t dy = -1; dy <= 1; ++dy) rowRanges(own, x - 1, x + 1, y + dy, z + 1, found, slot, 0);
  if (found.size() - before > kMostLevelNeighbours) found.resize(before + kMostLevelNeighbours);

  for (int a = 0; a < own.ask_count; ++a) {
    const Level& other = level_[own.asks[static_cast<size_t>(a)]];
    const double reach = static_cast<double>(reach_[slot]) + 0.5 * static_cast<double>(other.cell);
    int32_t low[3], high[3];
    const float p[3] = {x_[slot], y_[slot], z_[slot]};
    const uint32_t mask[3] = {other.mask_x, other.mask_y, other.mask_z};
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = [&](double at) {
        constexpr double kLimit = 1 << 30;
        const double c = std::clamp(at * other.inverse_cell, -kLimit, kLimit);
        const int32_t whole = static_cast<int32_t>(c);
        return whole - (c < whole);
      };
      low[axis] = cell(p[axis] - reach);
      high[axis] = cell(p[axis] + reach);
      // More cells than the table has along this axis: all of them, once.
      if (static_cast<uint32_t>(high[axis] - low[axis]) >= mask[axis]) {
        low[axis] = 0;
        high[axis] = static_cast<int32_t>(mask[axis]);
      }
    }
    for (int32_t cz = low[2]; cz <= high[2]; ++cz)
      for (int32_t cy = low[1]; cy <= high[1]; ++cy)
        rowRanges(other, low[0], high[0], cy, cz, found, slot, 0);
  }
}

}  // namespace scree::grains
