// A few grains that lie together, so that who is near them is asked once for all.
#pragma once

#include <glm/common.hpp>

#include <array>
#include <cstddef>

#include "modules/grains/bodies.h"
#include "modules/grains/simd4.h"

namespace scree::grains {

class Company {
 public:
  // Takes the grain in; false if the company is full, or would be spread too far by it.
  bool admits(const Body& grain, float margin) {
    if (count_ == kMost) return false;
    const float reach = grain.radius + margin;
    const vec3 low = glm::min(low_, grain.position - reach);
    const vec3 high = glm::max(high_, grain.position + reach);
    if (count_ > 0) {
      // Along one axis only, as the grains of a row of cells do: the box stays slim.
      const vec3 spread = high - low;
      const float most = kWidest * reach;
      if (!(spread.x <= kLongest * reach && spread.y <= most && spread.z <= most)) return false;
    }
    low_ = low;
    high_ = high;
    x_[count_] = grain.position.x;
    y_[count_] = grain.position.y;
    z_[count_] = grain.position.z;
    reach_[count_] = reach;
    ++count_;
    return true;
  }
  // After the last grain: fills up the lanes.
  void close() {
    for (size_t k = count_; k < kMost; ++k) {
      x_[k] = x_[0];
      y_[k] = y_[0];
      z_[k] = z_[0];
      reach_[k] = reach_[0];
    }
  }

  vec3 low() const { return low_; }
  vec3 high() const { return high_; }
  // Whether a sphere lies within reach of any of the grains.
  bool reaches(vec3 position, float radius) const {
    const simd::Vec3x4 at{simd::splat(position.x), simd::splat(position.y),
                          simd::splat(position.z)};
    const auto half = [&](size_t k) {
      const simd::Vec3x4 d = at - simd::load3(&x_[k], &y_[k], &z_[k]);
      const simd::Float4 sum = simd::load(&reach_[k]) + simd::splat(radius);
      return simd::less(simd::dot(d, d), sum * sum);
    };
    return simd::any(half(0) | half(4));
  }

 private:
  static constexpr size_t kMost = 8;  // two fours
  // Of the box around the grains, in reaches of the grain that joins.
  static constexpr float kLongest = 16, kWidest = 6;

  std::array<float, kMost> x_, y_, z_, reach_;
  size_t count_ = 0;
  vec3 low_{3e38f}, high_{-3e38f};
};

}  // namespace scree::grains
