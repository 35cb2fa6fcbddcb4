// The grid's search: each pair of neighbours once, in an order that only positions decide.
#include <algorithm>

#include "modules/grains/grid.h"

namespace scree::grains {

void Grid::read(const Bodies& bodies) {
  const uint32_t n = bodies.count, padded = n + kMostLanes;
  const size_t smaller = need_.shrinks(padded, x_.capacity());
  for (std::vector<float>* column : {&x_, &y_, &z_, &radius_, &reach_}) {
    column->clear();
    if (smaller > 0) shrinkTo(*column, smaller);
    remake(*column, padded);
  }
  listed_ = n;
  for (uint32_t k = 0; k < n; ++k) {
    const vec3 p = bodies.body[k].position;
    x_[k] = p.x;
    y_[k] = p.y;
    z_[k] = p.z;
  }
  fillReaches(bodies);
}

void Grid::fillReaches(const Bodies& bodies) {
  for (uint32_t k = 0; k < listed_; ++k) {
    radius_[k] = bodies.body[k].radius;
    reach_[k] = radius_[k] + bodies.margin[k];
  }
  for (uint32_t k = listed_; k < listed_ + kMostLanes; ++k) {  // read by the last group, then masked out
    x_[k] = y_[k] = z_[k] = 0;
    radius_[k] = reach_[k] = 0;
  }
}

void Grid::restore(uint32_t slot, vec3 listed_at) {
  for (std::vector<float>* column : {&x_, &y_, &z_}) {
    makeRoomFor(*column, slot + 1);
    column->resize(slot + 1);
  }
  x_[slot] = listed_at.x;
  y_[slot] = listed_at.y;
  z_[slot] = listed_at.z;
}

void Grid::restore(std::span<const uint32_t> slab_begin, const Bodies& bodies) {
  slabs_ = static_cast<uint32_t>(slab_begin.size() - 1);
  slab_begin_.assign(slab_begin.begin(), slab_begin.end());
  level_count_ = 0;
  listed_ = slab_begin.back();
  for (std::vector<float>* column : {&x_, &y_, &z_, &radius_, &reach_}) {
    makeRoomFor(*column, listed_ + kMostLanes);
    column->resize(listed_ + kMostLanes);
  }
  fillReaches(bodies);
}

// Collects the ranges to look at, so that the kernel is called for many at once.
class Grid::Finder {
 public:
  Finder(const Grid& grid, uint32_t slot, std::vector<uint32_t>& found)
      : kernels_(*grid.kernels_),
        grains_(grid.reachesFrom(0)),
        slot_(slot),
        found_(found) {}

  void look(uint32_t begin, uint32_t end) {
    while (begin < end) {
      const uint32_t stop = begin + std::min(end - begin, kMostGrains - grains_in_ranges_);
      range_[ranges_++] = {begin, stop};
      grains_in_ranges_ += stop - begin;
      begin = stop;
      if (ranges_ == kMostRanges || grains_in_ranges_ == kMostGrains) finish();
    }
  }
  // Appends what is found in the ranges since the last call.
  void finish() {
    uint32_t hits[kMostGrains + kMostLanes];
    const uint32_t n = kernels_.scan(grains_, slot_, range_, ranges_, hits);
    makeRoomFor(found_, found_.size() + n);
    found_.insert(found_.end(), hits, hits + n);
    ranges_ = grains_in_ranges_ = 0;
  }

 private:
  static constexpr uint32_t kMostRanges = 16, kMostGrains = 248;  // a call

  const Kernels& kernels_;
  const Reaches grains_;
  const uint32_t slot_;
  std::vector<uint32_t>& found_;
  SlotRange range_[kMostRanges];
  uint32_t ranges_ = 0, grains_in_ranges_ = 0;
};

// The cells x0 to x1 of a row, which may wrap around.
void Grid::lookInRow(const Level& level, int32_t x0, int32_t x1, int32_t y, int32_t z,
                     Finder& finder) const {
  const uint32_t row = bucketRow(level, y, z);
  const uint32_t first = static_cast<uint32_t>(x0) & level.mask_x;
  const uint32_t last = static_cast<uint32_t>(x1) & level.mask_x;
  if (first <= last) {
    finder.look(bucket_begin_[row + first], bucket_begin_[row + last + 1]);
  } else {
    finder.look(bucket_begin_[row], bucket_begin_[row + last + 1]);
    finder.look(bucket_begin_[row + first], bucket_begin_[row + level.mask_x + 1]);
  }
}

void Grid::neighbours(uint32_t slot, std::vector<uint32_t>& found) const {
  const Level& own = level_[level_of_[slot]];
  const int32_t x = cellOf(x_[slot], own.inverse_cell), y = cellOf(y_[slot], own.inverse_cell),
                z = cellOf(z_[slot], own.inverse_cell);
  const size_t before = found.size();
  Finder finder(*this, slot, found);
  // The grain's own cell from the grain on, and the 13 of 26 cells around that come later.
  const uint32_t row = bucketRow(own, y, z);
  const uint32_t column = static_cast<uint32_t>(x) & own.mask_x;
  if (column < own.mask_x) {
    finder.look(slot + 1, bucket_begin_[row + column + 2]);
  } else {
    finder.look(slot + 1, bucket_begin_[row + column + 1]);
    finder.look(bucket_begin_[row], bucket_begin_[row + 1]);
  }
  lookInRow(own, x - 1, x + 1, y + 1, z, finder);
  for (int32_t dy = -1; dy <= 1; ++dy) lookInRow(own, x - 1, x + 1, y + dy, z + 1, finder);
  finder.finish();
  if (found.size() - before > kMostLevelNeighbours) found.resize(before + kMostLevelNeighbours);

  for (int a = 0; a < own.ask_count; ++a) {
    const Level& other = level_[own.asks[static_cast<size_t>(a)]];
    const double reach = static_cast<double>(reach_[slot]) + 0.5 * static_cast<double>(other.cell);
    int32_t low[3], high[3];
    const float p[3] = {x_[slot], y_[slot], z_[slot]};
    const uint32_t mask[3] = {other.mask_x, other.mask_y, other.mask_z};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = cellOf(p[axis] - reach, other.inverse_cell);
      high[axis] = cellOf(p[axis] + reach, other.inverse_cell);
      // More cells than the table has along this axis: all of them, once.
      if (static_cast<uint32_t>(high[axis]) - static_cast<uint32_t>(low[axis]) >= mask[axis]) {
        low[axis] = 0;
        high[axis] = static_cast<int32_t>(mask[axis]);
      }
    }
    for (int32_t cz = low[2]; cz <= high[2]; ++cz)
      for (int32_t cy = low[1]; cy <= high[1]; ++cy)
        lookInRow(other, low[0], high[0], cy, cz, finder);
  }
  finder.finish();
}

bool Grid::moveAlone(uint32_t slot, vec3 position, float reach, std::vector<uint32_t>& met) {
  x_[slot] = position.x;
  y_[slot] = position.y;
  z_[slot] = position.z;
  reach_[slot] = reach;
  met.clear();
  Finder finder(*this, slot, met);
  finder.look(0, slot);
  finder.look(slot + 1, slab_begin_.back());
  finder.finish();
  return met.empty();
}

}  // namespace scree::grains
