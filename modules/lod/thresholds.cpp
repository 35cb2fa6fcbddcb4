// Which representation suffices from which size on.
#include <algorithm>
#include <cmath>

#include "modules/lod/state.h"
#include "shaders/shared/impostor.h"

namespace scree {
namespace {

// A point shows on 2 x 2 pixels at most.
constexpr float kMostPointPx = 0.82f;
const float kEver = 2 * rules::kLargestPx;

// Largest size at which size (share + more size / pixels_at_1m) is no more than the tolerance, all at least 0.
float mostSize(float share, float more, float tolerance, float pixels_at_1m) {
  const float a = more / pixels_at_1m;
  const float root = std::sqrt(share * share + 4 * a * tolerance) + share;
  return root > 0 ? std::min(2 * tolerance / root, kEver) : kEver;
}

// Of three views, or of one.
struct Outline {
  float SizeError::*share;
  float SizeError::*near;
  float SizeError::*ssim;
};
constexpr Outline kFull{&SizeError::outline, &SizeError::near, &SizeError::ssim},
    kSmall{&SizeError::small_outline, &SizeError::small_near, &SizeError::small_ssim};

// Sizes from which and up to which impostors suffice.
struct Range {
  float from = 0, to = 0;
};

// The longest range of sizes, by the ratio of its ends above `least`, in which outlines are good, and the similarity at
// both ends of each entry.
Range rangeOf(const GrainShape& shape, const LodSettings& settings, float tolerance, float pixels_at_1m, const Outline& outline,
              float least) {
  Range best, range;
  const auto ratio = [least](const Range& r) { return r.to / std::max(r.from, least); };
  float begin = 0;
  bool was_similar = true;  // below the smallest size pictures were not compared; a pixel shows less of them yet
  for (const SizeError& e : shape.impostor) {
    const bool similar = e.*outline.ssim >= std::min(settings.least_ssim, e.mesh_ssim);
    const float most = similar && was_similar ? std::min(mostSize(e.*outline.share, e.*outline.near, tolerance, pixels_at_1m), e.size_px) : 0;
    was_similar = similar;
    if (most > begin) {
      if (range.to < begin || range.to == 0) range.from = begin;
      range.to = most;
      if (ratio(range) > ratio(best)) best = range;
    }
    begin = e.size_px;
  }
  return best;
}

}  // namespace

LodThresholds thresholdsOf(const GrainShape& shape, const LodSettings& settings, float pixels_at_1m, float stretch) {
  LodThresholds t;
  const float most_small = std::min(rules::kSmallPx, rules::mostParallelPx(pixels_at_1m, stretch));
  const float tolerance = std::clamp(lod::notNan(settings.tolerance_px), 0.0f, rules::kLargestPx);
  // Level k - 1 takes over where level k is off by too much; a level without error does for all sizes.
  for (uint32_t level = 1; level < rules::kMeshLevels; ++level) {
    if (level >= shape.levels.size()) continue;  // 0: never
    const float error = shape.levels[level].error;
    t.mesh_px[level] = error > 0 ? tolerance / (error + tolerance / pixels_at_1m) : kEver;
  }
  const bool only_mesh = settings.only >= rules::kMesh;
  if (only_mesh) {
    for (uint32_t level = 1; level < shape.levels.size(); ++level)
      t.mesh_px[level] = level <= settings.only - rules::kMesh ? kEver : 0;
    return t;
  }
  if (settings.only == rules::kPoint) {
    t.point_px = kEver;
    return t;
  }
  const bool only_impostors = settings.only == rules::kImpostor || settings.only == rules::kSmallImpostor;
  if (!only_impostors) t.point_px = std::min(shape.point_outline > 0 ? tolerance / shape.point_outline : kEver, kMostPointPx);
  if (only_impostors && !shape.impostor.empty()) {
    t.impostor_px = kEver;
    t.small_px = most_small;
    return t;
  }
  // One view where it is good, and three from there on: one range of sizes. If there is a gap, the longer part.
  const float least = std::max(t.point_px * (1 - rules::kPointSpread), 0.01f);
  const Range full = rangeOf(shape, settings, tolerance, pixels_at_1m, kFull, least);
  Range small = rangeOf(shape, settings, tolerance, pixels_at_1m, kSmall, least);
  small.to = std::min(small.to, most_small);
  const bool some = small.to > std::max(small.from, least);
  if (some && small.from <= full.from && full.from <= small.to && full.to > small.to) {
    t.impostor_from_px = small.from;
    t.small_px = small.to;
    t.impostor_px = full.to;
  } else if (some && small.to * std::max(full.from, least) >= full.to * std::max(small.from, least)) {
    t.impostor_from_px = small.from;
    t.small_px = kEver;
    t.impostor_px = small.to;
  } else {
    t.impostor_from_px = full.from;
    t.impostor_px = full.to;
  }
  t.impostor_px = std::min(t.impostor_px, rules::kImpostorMostNear / (1 + std::max(lod::notNan(settings.band), 0.0f)) * pixels_at_1m);
  return t;
}

float outlineErrorPx(const GrainShape& shape, uint32_t representation, float size_px, float pixels_at_1m) {
  const float near = size_px / pixels_at_1m;
  if (representation == rules::kNotDrawn) return 0;
  if (representation == rules::kPoint) return shape.point_outline * size_px;
  if (representation >= rules::kMesh) {
    const uint32_t level = representation - rules::kMesh;
    if (level >= shape.levels.size() || !(near < 1)) return -1;
    return shape.levels[level].error * size_px / (1 - near);
  }
  const Outline& outline = representation == rules::kSmallImpostor ? kSmall : kFull;
  for (const SizeError& e : shape.impostor)
    if (size_px <= e.size_px && near <= rules::kImpostorMostNear) return size_px * (e.*outline.share + e.*outline.near * near);
  return -1;
}

lod::SizeRange lod::sizesOf(const SwarmStore::Stored& stored, const vec3& origin, float pixels_at_1m) {
  constexpr float kSlack = 1e-4f;  // more than floats round
  const vec3 low = origin + stored.min, high = origin + stored.max;
  const float near = glm::length(glm::max(glm::max(low, -high), vec3(0))), far = glm::length(glm::max(glm::abs(low), glm::abs(high)));
  return {rules::sizePx(stored.least_radius, far, pixels_at_1m) * (1 - kSlack),
          rules::sizePx(stored.largest_radius, near * (1 - kSlack), pixels_at_1m) * (1 + kSlack)};
}

uint32_t lod::possibleOf(const LodThresholds& t, size_t levels, float band, const SizeRange& sizes) {
  const auto allBelow = [&](float px) { return sizes.most < px * (1 - band); };
  const auto noneBelow = [&](float px) { return sizes.least >= px * (1 + band); };
  uint32_t possible = 0;
  const auto add = [&](uint32_t representation) { possible |= 1u << representation; };
  const float surely_point = t.point_px * (1 - rules::kPointSpread);
  if (!noneBelow(t.point_px)) add(rules::kPoint);
  if (allBelow(surely_point)) return possible;
  // A size may count as below a threshold and not below a lower one.
  const auto mayBeBetween = [&](float low, float high) { return high * (1 + band) > low * (1 - band); };
  if (mayBeBetween(t.impostor_from_px, t.impostor_px) && !noneBelow(t.impostor_px) && !allBelow(t.impostor_from_px)) {
    if (mayBeBetween(t.impostor_from_px, t.small_px) && !noneBelow(t.small_px)) add(rules::kSmallImpostor);
    if (mayBeBetween(t.small_px, t.impostor_px) && !allBelow(t.small_px)) add(rules::kImpostor);
  }
  const bool none_smaller = noneBelow(t.impostor_from_px) || t.impostor_from_px * (1 + band) <= surely_point * (1 - band);
  if (allBelow(t.impostor_px) && none_smaller) return possible;
  for (uint32_t level = 0; level < levels; ++level) add(rules::kMesh + level);
  return possible;
}

void lod::setThresholds(rules::SwarmBlock& block, const LodThresholds& t, float band) {
  block.mesh_px = vec4(t.mesh_px[0], t.mesh_px[1], t.mesh_px[2], t.mesh_px[3]);
  block.point_px = t.point_px;
  block.impostor_px = t.impostor_px;
  block.impostor_from_px = t.impostor_from_px;
  block.small_px = t.small_px;
  block.band = band;
}

}  // namespace scree
