// The grid's plan: levels, table sizes, and the sort.
#include "modules/grains/grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace scree::grains {
namespace {

// Buckets of a level: enough that few cells share one, few enough that clearing them is cheap.
uint32_t bucketBudget(uint32_t members) { return std::max(256u, 4 * members); }

// log2 of a power of two of cells that covers `cells` of them: 4 to 1024.
int sizeBits(double cells) {
  int bits = 2;
  while (bits < 10 && (1 << bits) < cells) ++bits;
  return bits;
}

// Classes of sizes within an octave.
constexpr size_t kSizeClasses = 16;

}  // namespace

std::span<uint32_t> Grid::plan(const Bodies& bodies, Workspace& workspace) {
  const uint32_t n = bodies.count;
  const std::span<uint8_t> sorted_level_of = workspace.take<uint8_t>(n);
  level_of_ = workspace.take<uint8_t>(n);
  chooseLevels(bodies);
  chooseSizes(bodies);
  chooseSides();

  bucket_begin_ = workspace.take<uint32_t>(size_t{slabs_} * buckets_a_slab_ + 1, 0);
  const std::span<uint32_t> order = workspace.take<uint32_t>(n), bucket_of = workspace.take<uint32_t>(n);
  for (uint32_t i = 0; i < n; ++i) {
    const Level& level = level_[level_of_[i]];
    const vec3 p = bodies.body[i].position;
    const uint32_t row =
        bucketRow(level, cellOf(p.y, level.inverse_cell), cellOf(p.z, level.inverse_cell));
    bucket_of[i] =
        row + (static_cast<uint32_t>(cellOf(p.x, level.inverse_cell)) & level.mask_x);
    ++bucket_begin_[bucket_of[i] + 1];
  }
  for (size_t b = 1; b < bucket_begin_.size(); ++b) bucket_begin_[b] += bucket_begin_[b - 1];
  for (uint32_t i = 0; i < n; ++i) order[bucket_begin_[bucket_of[i]]++] = i;
  std::shift_right(bucket_begin_.begin(), bucket_begin_.end(), 1);
  bucket_begin_[0] = 0;

  // Within a bucket by entity: the result does not depend on the order before.
  const auto earlier = [&](uint32_t a, uint32_t b) { return bodies.entity[a] < bodies.entity[b]; };
  for (size_t b = 0; b + 1 < bucket_begin_.size(); ++b) {
    const uint32_t begin = bucket_begin_[b], end = bucket_begin_[b + 1];
    if (end - begin > 24) {
      std::sort(order.begin() + begin, order.begin() + end, earlier);
      continue;
    }
    for (uint32_t k = begin + 1; k < end; ++k) {
      const uint32_t moved = order[k];
      uint32_t at = k;
      for (; at > begin && earlier(moved, order[at - 1]); --at) order[at] = order[at - 1];
      order[at] = moved;
    }
  }
  for (uint32_t k = 0; k < n; ++k) sorted_level_of[k] = level_of_[order[k]];
  level_of_ = sorted_level_of;
  slab_begin_.resize(slabs_ + 1);
  for (uint32_t s = 0; s <= slabs_; ++s) slab_begin_[s] = bucket_begin_[size_t{s} * buckets_a_slab_];
  return order;
}

void Grid::chooseLevels(const Bodies& bodies) {
  const uint32_t n = bodies.count;
  // Cells are c 2^k; which c wastes least is decided by the sizes' mantissas: a cell that is wider
  // than a grain's size by a factor w costs w^3 distance tests. Integer sums and maxima only: they
  // do not depend on the order of the grains.
  std::array<uint32_t, kSizeClasses> count{};
  std::array<float, kSizeClasses> top{};
  float largest = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const float size = 2 * (bodies.body[i].radius + bodies.margin[i]);
    const float mantissa = std::bit_cast<float>((std::bit_cast<uint32_t>(size) & 0x7fffffu) |
                                                0x3f800000u);  // in [1, 2)
    const size_t c = static_cast<size_t>((mantissa - 1) * kSizeClasses);
    ++count[c];
    top[c] = std::max(top[c], mantissa);
    largest = std::max(largest, size);
  }
  double least = 1e300;
  float mantissa = 1;
  for (size_t c = 0; c < kSizeClasses; ++c) {
    if (count[c] == 0) continue;
    double cost = 0;
    for (size_t k = 0; k < kSizeClasses; ++k) {
      const double waste = (k <= c ? 1.0 : 2.0) * top[c] / std::max(top[k], 1.0f);
      cost += count[k] * waste * waste * waste;
    }
    if (cost < least) {
      least = cost;
      mantissa = top[c];
    }
  }
  constexpr float kSlack = 1.00001f;  // rounding of the distance test
  const float cell = [&] {
    int exponent = 0;
    std::frexp(largest, &exponent);
    const float fits = std::ldexp(mantissa, exponent - 1);
    return (fits >= largest ? fits : 2 * fits) * kSlack;
  }();

  std::array<uint32_t, kMostLevels> members{};
  for (uint32_t i = 0; i < n; ++i) {
    const float size = 2 * (bodies.body[i].radius + bodies.margin[i]) * kSlack;
    int halvings = 0;
    for (float c = cell; halvings + 1 < kMostLevels && 0.5f * c >= size; c *= 0.5f) ++halvings;
    level_of_[i] = static_cast<uint8_t>(halvings);
    ++members[static_cast<size_t>(halvings)];
  }
  std::array<uint8_t, kMostLevels> index{};
  level_count_ = 0;
  for (int k = 0; k < kMostLevels; ++k) {
    if (members[static_cast<size_t>(k)] == 0) continue;
    index[static_cast<size_t>(k)] = static_cast<uint8_t>(level_count_);
    Level& level = level_[static_cast<size_t>(level_count_++)];
    level.halvings = k;
    level.cell = std::ldexp(cell, -k);
    level.inverse_cell = std::ldexp(1.0 / static_cast<double>(cell), k);
    level.members = members[static_cast<size_t>(k)];
  }
  for (uint32_t i = 0; i < n; ++i) level_of_[i] = index[level_of_[i]];
}

void Grid::chooseSizes(const Bodies& bodies) {
  constexpr float kFar = 3e38f;
  std::array<vec3, kMostLevels> low, high;
  low.fill(vec3(kFar));
  high.fill(vec3(-kFar));
  for (uint32_t i = 0; i < bodies.count; ++i) {
    const vec3 p = bodies.body[i].position;
    const size_t l = level_of_[i];
    for (int axis = 0; axis < 3; ++axis) {
      low[l][axis] = std::min(low[l][axis], p[axis]);
      high[l][axis] = std::max(high[l][axis], p[axis]);
    }
  }
  const auto cells = [&](int l, int axis) {
    const size_t k = static_cast<size_t>(l);
    return (static_cast<double>(high[k][axis]) - low[k][axis]) * level_[k].inverse_cell + 2;
  };
  // Slabs are layers of the largest cells; all levels share them.
  double layers = 4;
  for (int l = 0; l < level_count_; ++l) {
    const Level& level = level_[static_cast<size_t>(l)];
    layers = std::max(layers, std::ldexp(cells(l, 2), -level.halvings));
  }
  int slab_bits = std::min(8, sizeBits(layers));
  while (slab_bits > 2 && (1u << slab_bits) > bucketBudget(bodies.count) / 16) --slab_bits;
  slabs_ = 1u << slab_bits;
  buckets_a_slab_ = 0;
  for (int l = 0; l < level_count_; ++l) {
    Level& level = level_[static_cast<size_t>(l)];
    level.bits_x = sizeBits(cells(l, 0));
    level.bits_y = sizeBits(cells(l, 1));
    const int bits_z = slab_bits + level.halvings;
    const int budget = std::bit_width(bucketBudget(level.members)) - 1;
    while (level.bits_x + level.bits_y + bits_z > budget && level.bits_x + level.bits_y > 4)
      --(level.bits_x > level.bits_y ? level.bits_x : level.bits_y);
    level.mask_x = (1u << level.bits_x) - 1;
    level.mask_y = (1u << level.bits_y) - 1;
    level.mask_z = (1u << bits_z) - 1;
    level.offset = buckets_a_slab_;
    buckets_a_slab_ += 1u << (level.bits_x + level.bits_y + level.halvings);
  }
}

// For every two levels: does each fine grain look for coarse ones, or each coarse for fine ones?
// Whichever visits fewer cells.
void Grid::chooseSides() {
  for (int l = 0; l < level_count_; ++l) level_[static_cast<size_t>(l)].ask_count = 0;
  for (int coarse = 0; coarse < level_count_; ++coarse) {
    for (int fine = coarse + 1; fine < level_count_; ++fine) {
      Level& a = level_[static_cast<size_t>(coarse)];
      Level& b = level_[static_cast<size_t>(fine)];
      const double ratio = std::ldexp(1.0, b.halvings - a.halvings);
      const double from_fine = 12.0 * b.members;
      const double from_coarse = (ratio + 2) * (ratio + 2) * (ratio + 2) * a.members;
      if (from_coarse < from_fine) {
        a.asks[static_cast<size_t>(a.ask_count++)] = static_cast<uint8_t>(fine);
      } else {
        b.asks[static_cast<size_t>(b.ask_count++)] = static_cast<uint8_t>(coarse);
      }
    }
  }
}

uint32_t Grid::bucketRow(const Level& level, int32_t y, int32_t z) const {
  const uint32_t wrapped_z = static_cast<uint32_t>(z) & level.mask_z;
  const uint32_t slab = wrapped_z >> level.halvings;
  const uint32_t layer = wrapped_z & ((1u << level.halvings) - 1);
  const uint32_t wrapped_y = static_cast<uint32_t>(y) & level.mask_y;
  return slab * buckets_a_slab_ + level.offset +
         (((layer << level.bits_y) + wrapped_y) << level.bits_x);
}

void Grid::keepSearch(Workspace& workspace) {
  level_of_ = workspace.keep(level_of_);
  bucket_begin_ = workspace.keep(bucket_begin_);
}

size_t Grid::memoryBytes() const {
  return 4 * (slab_begin_.capacity() + x_.capacity() + y_.capacity() + z_.capacity() + radius_.capacity() +
              reach_.capacity());
}

}  // namespace scree::grains
