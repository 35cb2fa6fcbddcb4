// A distance field sampled on a grid.
#pragma once

#include <functional>
#include <vector>

#include "modules/grains/surface_field.h"

namespace scree::grains {

class GridField : public DistanceField {
 public:
  static constexpr size_t kMostSamples = size_t{1} << 26;

  enum class Calls { InOrder, Parallel };
  // See sampleDistance.
  static Result<SharedField> sample(const std::function<float(vec3)>& distance, vec3 low, vec3 high,
                                    float cell, Calls calls);

  SurfacePoint nearest(vec3 p) const override;
  std::array<vec3, 2> bounds() const override { return {low_, high_}; }
  size_t memoryBytes() const override { return sizeof *this + value_.capacity() * sizeof(float); }

 private:
  size_t at(size_t x, size_t y, size_t z) const { return (z * size_[1] + y) * size_[0] + x; }

  vec3 low_{0}, high_{0};
  float cell_ = 1, inverse_ = 1;
  std::array<size_t, 3> size_{};  // samples along x, y, z
  std::vector<float> value_;      // m, x fastest
};

}  // namespace scree::grains
