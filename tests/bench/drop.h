// The scene of the grains bench: equal spheres dropped into a box, and what is measured of it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/core/math.h"

namespace scree::bench {

inline constexpr float kDropRadius = 0.05f, kDropDensity = 1000, kDropFriction = 0.5f;
inline constexpr float kDropDamping = 0.05f;  // 1/s
inline constexpr float kDropTick = 1.0f / 60, kDropGravity = 9.81f;

// A loose cubic lattice, 2.4 radii apart and shaken by 0.15, that falls into a box without a lid:
// [0, width] along x and z, floor at y = 0.
struct Drop {
  std::vector<vec3> position;
  float width = 0;
  float height = 0;  // above the highest grain
};
Drop makeDrop(size_t count);

// Of the pairs that overlap, in radii.
struct Overlap {
  double mean = 0, p99 = 0, max = 0;
};
class OverlapSample {
 public:
  void add(std::span<const vec3> positions);
  Overlap result() const;

 private:
  std::vector<float> overlaps_;
};

// The speed that 1 % of the grains pass, m/s.
double fastestPercent(std::span<const vec3> velocities);

// CPU time that the process has used on all its threads, ms: other programs do not count.
double cpuMs();

}  // namespace scree::bench
