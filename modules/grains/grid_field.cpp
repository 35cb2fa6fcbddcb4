// Sampling a distance field on a grid, and reading it between the samples.
#include "modules/grains/grid_field.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "engine/core/parallel.h"

namespace scree {
namespace grains {
namespace {

constexpr float kFarthest = 1e12f;  // m: keeps squares finite

}  // namespace

Result<SharedField> GridField::sample(const std::function<float(vec3)>& distance, vec3 low, vec3 high,
                                      float cell, Calls calls) {
  auto field = std::make_shared<GridField>();
  if (!(cell > 0) || !std::isfinite(cell))
    return Error{fmt::format("distance field: cell = {} m; allowed is more than 0", cell)};
  double samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(low[axis] < high[axis]) || !std::isfinite(high[axis] - low[axis]))
      return Error{fmt::format("distance field: its box goes from {} to {} m along {}; allowed is a finite box "
                               "with a size", low[axis], high[axis], "xyz"[axis])};
    const double cells = std::max(1.0, std::ceil(static_cast<double>(high[axis] - low[axis]) /
                                                     static_cast<double>(cell) - 1e-3));
    samples *= cells + 1;
    if (!(samples <= static_cast<double>(kMostSamples)))
      return Error{fmt::format("distance field: {} m in cells of {} m are too many samples; allowed are {}",
                               glm::length(high - low), cell, kMostSamples)};
    field->size_[static_cast<size_t>(axis)] = static_cast<size_t>(cells) + 1;
  }
  field->low_ = low;
  field->cell_ = cell;
  field->inverse_ = 1 / cell;
  const std::array<size_t, 3> size = field->size_;
  field->high_ = low + cell * vec3(static_cast<float>(size[0] - 1), static_cast<float>(size[1] - 1),
                                   static_cast<float>(size[2] - 1));
  field->value_.resize(size[0] * size[1] * size[2]);
  std::atomic<size_t> bad{0};
  const auto layer = [&](size_t z) {
    for (size_t y = 0; y < size[1]; ++y)
      for (size_t x = 0; x < size[0]; ++x) {
        const vec3 p = low + cell * vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        const float value = distance(p);
        if (!(std::abs(value) < 1e9f)) bad.fetch_add(1, std::memory_order_relaxed);
        field->value_[field->at(x, y, z)] = value;
      }
  };
  parallelChunks(size[2], 1, [&](size_t z, size_t, size_t) { layer(z); },
                 calls == Calls::Parallel ? Worth::Threads : Worth::OneThread);
  if (bad > 0)
    return Error{fmt::format("distance field: {} of {} samples are not finite or beyond 1e9 m", bad.load(),
                             field->value_.size())};
  return SharedField(std::move(field));
}

SurfacePoint GridField::nearest(vec3 p) const {
  p = glm::clamp(p, vec3(-kFarthest), vec3(kFarthest));
  const vec3 clamped = glm::clamp(p, low_, high_);
  const vec3 place = (clamped - low_) * inverse_;
  size_t cell[3];
  float t[3];
  for (int axis = 0; axis < 3; ++axis) {
    const size_t a = static_cast<size_t>(axis);
    cell[a] = std::min(static_cast<size_t>(std::max(place[axis], 0.0f)), size_[a] - 2);
    t[a] = place[axis] - static_cast<float>(cell[a]);
  }
  const float* v = &value_[at(cell[0], cell[1], cell[2])];
  const size_t row = size_[0], slice = size_[0] * size_[1];
  const auto mix = [](float a, float b, float s) { return a + (b - a) * s; };
  // Along x, then y, then z; and the slopes on the way.
  const float x00 = mix(v[0], v[1], t[0]), x10 = mix(v[row], v[row + 1], t[0]);
  const float x01 = mix(v[slice], v[slice + 1], t[0]),
              x11 = mix(v[slice + row], v[slice + row + 1], t[0]);
  const float y0 = mix(x00, x10, t[1]), y1 = mix(x01, x11, t[1]);
  const float value = mix(y0, y1, t[2]);
  const vec3 slope(mix(mix(v[1] - v[0], v[row + 1] - v[row], t[1]),
                       mix(v[slice + 1] - v[slice], v[slice + row + 1] - v[slice + row], t[1]), t[2]),
                   mix(x10 - x00, x11 - x01, t[2]), y1 - y0);
  const float steep = glm::dot(slope, slope);
  // Where the slopes cancel (the middle of what is hollow), any direction leads to the surface.
  vec3 normal = steep > 1e-12f * cell_ * cell_ ? slope / std::sqrt(steep) : vec3(0, 1, 0);
  const vec3 outside = p - clamped;
  const float square = glm::dot(outside, outside);
  if (!(square > 0)) return {normal, value, 0};
  // Beyond the box: whatever is in it is at least that far (the angle at the clamped point is obtuse).
  const float inner = std::max(value, 0.0f);
  const vec3 way = outside + normal * inner;
  const float length = glm::length(way);
  if (length > 0) normal = way / length;
  return {normal, std::sqrt(square + inner * inner), 0};
}

}  // namespace grains

Result<std::shared_ptr<const DistanceField>> sampleDistance(const std::function<float(vec3)>& distance,
                                                            vec3 low, vec3 high, float cell) {
  return grains::GridField::sample(distance, low, high, cell, grains::GridField::Calls::InOrder);
}

}  // namespace scree
