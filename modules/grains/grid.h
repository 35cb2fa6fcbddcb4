// Counting-sorted grid over hashed cells: which grains may touch before the next search.
//
// Each grain has a reach: its radius plus its margin. Two are neighbours if their distance is less
// than the sum of their reaches. Cells come in levels, each half the size of the one above; a grain
// lives in the smallest cells that are at least twice its reach, so that any mix of radii works.
// Coordinates wrap around in each level (a power of two of cells along each axis): the grid covers
// an unbounded space with a bounded table; cells that share a bucket only cost distance tests.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/bodies.h"
#include "modules/grains/kernels.h"
#include "modules/grains/workspace.h"

namespace scree::grains {

// Levels of cells; what is smaller than the smallest level's cell shares its cells: slower, right.
inline constexpr int kMostLevels = 10;
// Neighbours of a grain among grains of its own level that one search keeps; more can only touch it
// when dozens overlap in one place, and are then left out until the crowd has spread.
inline constexpr uint32_t kMostLevelNeighbours = 512;

// Integer cell of a coordinate; clamped to +-2^30, which keeps neighbours neighbours. NaN is -2^30.
inline int32_t cellOf(double x, double inverse_cell) {
  constexpr double kLimit = 1 << 30;
  double cell = x * inverse_cell;
  cell = cell > -kLimit ? cell < kLimit ? cell : kLimit : -kLimit;
  const int32_t whole = static_cast<int32_t>(cell);
  return whole - (cell < whole);
}

class Grid {
 public:
  // Chooses levels and sizes for the grains (their position, radius and margin), and the order in
  // which they are to be stored: order[new slot] = old slot. Ties go by entity index. What is in the
  // workspace then, the order excepted, is there for the search.
  std::span<uint32_t> plan(const Bodies& bodies, Workspace& workspace);

  // Keeps its part of a workspace that was given back.
  void keepSearch(Workspace& workspace);
  // After the bodies were put in that order: copies what the search reads.
  void read(const Bodies& bodies);

  // The instruction set of the searches to come.
  void use(const Kernels& kernels) { kernels_ = &kernels; }

  uint32_t slabCount() const { return slabs_; }
  uint32_t slabBegin(uint32_t slab) const { return slab_begin_[slab]; }
  uint32_t slabEnd(uint32_t slab) const { return slabBegin(slab + 1); }
  uint32_t slabOf(uint32_t slot) const {
    uint32_t begin = 0, end = slabs_;  // the last slab that begins no later, whole or empty
    while (end - begin > 1) {
      const uint32_t middle = (begin + end) / 2;
      (slabBegin(middle) <= slot ? begin : end) = middle;
    }
    return begin;
  }
  uint32_t slabAbove(uint32_t slab) const { return (slab + 1) & (slabs_ - 1); }
  // True if grains of different sizes are found from either side: see neighbours().
  bool mixed() const { return level_count_ > 1; }

  // Appends the neighbours of `slot` that this grain is the one to find: their slots, with kNearBit
  // if the two nearly touch. Over all grains, each neighbouring pair is found exactly once. They lie in the grain's slab or the next
  // above it, or, if mixed(), the next below.
  void neighbours(uint32_t slot, std::vector<uint32_t>& found) const;

  // Lets the grain be searched for at another place, with another reach; false if it is within reach
  // of another one there. `met`: working memory.
  bool moveAlone(uint32_t slot, vec3 position, float reach, std::vector<uint32_t>& met);

  // Where the grain was at the last search, or when it was moved alone; it must be listed.
  vec3 listedAt(uint32_t slot) const { return {x_[slot], y_[slot], z_[slot]}; }
  // Of `slot` and those behind it.
  Reaches reachesFrom(uint32_t slot) const {
    return {&x_[slot], &y_[slot], &z_[slot], &radius_[slot], &reach_[slot]};
  }
  uint32_t listed() const { return listed_; }
  // Of one that is not listed yet: where it is.
  Reference referenceOf(const Bodies& bodies, uint32_t slot) const {
    return {slot < listed_ ? listedAt(slot) : bodies.body[slot].position, bodies.margin[slot]};
  }

  // What a search left behind: where slot after slot was listed, and then where the slabs begin (one
  // more than there are slabs) and the bodies. Nothing can be searched for before the next plan().
  void restore(uint32_t slot, vec3 listed_at);
  void restore(std::span<const uint32_t> slab_begin, const Bodies& bodies);

  size_t memoryBytes() const;

 private:
  struct Level {
    int halvings = 0;  // below the largest cell
    double inverse_cell = 1;
    float cell = 1;
    uint32_t mask_x = 3, mask_y = 3, mask_z = 3;
    int bits_x = 2, bits_y = 2;
    uint32_t offset = 0;  // of its buckets within a slab's
    uint32_t members = 0;
    std::array<uint8_t, kMostLevels> asks{};  // levels whose grains it looks for
    int ask_count = 0;
  };
  void chooseLevels(const Bodies& bodies);
  void fillReaches(const Bodies& bodies);
  void chooseSizes(const Bodies& bodies);
  void chooseSides();
  uint32_t bucketRow(const Level& level, int32_t y, int32_t z) const;
  class Finder;  // grid_search.cpp
  void lookInRow(const Level& level, int32_t x0, int32_t x1, int32_t y, int32_t z,
                 Finder& finder) const;

  const Kernels* kernels_ = &kBaselineKernels;
  std::array<Level, kMostLevels> level_;
  int level_count_ = 0;
  uint32_t slabs_ = 4;
  uint32_t buckets_a_slab_ = 0;
  std::vector<uint32_t> slab_begin_;  // one more than there are slabs
  std::vector<float> x_, y_, z_, radius_, reach_;
  Need need_;  // of their lengths
  uint32_t listed_ = 0;  // grains
  // In the workspace.
  std::span<uint32_t> bucket_begin_;
  std::span<uint8_t> level_of_;  // by old slot in plan(), then by slot
};

}  // namespace scree::grains
