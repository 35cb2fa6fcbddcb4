// Which representation suffices from which size on.
#include <algorithm>

#include "modules/lod/lod.h"

namespace scree {
namespace {

// A point shows on 2 x 2 pixels at most.
constexpr float kMostPointPx = 0.75f;
// Mean distance of a disc's points from its centre / radius: what a point is off by.
constexpr float kPointError = 2.0f / 3;

}  // namespace

LodThresholds thresholdsOf(const GrainShape& shape, const LodSettings& settings) {
  const float kEver = 2 * rules::kLargestPx;
  LodThresholds t;
  const float tolerance = std::max(settings.tolerance_px, 0.0f);
  // Level k - 1 takes over where level k is off by too much; a level without error does for all sizes.
  for (uint32_t level = 1; level < rules::kMeshLevels; ++level) {
    if (level >= shape.levels.size()) continue;  // 0: never
    const float error = shape.levels[level].error;
    t.mesh_px[level] = error > 0 ? tolerance / error : kEver;
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
  if (!only_impostors) t.point_px = std::min(tolerance / kPointError, kMostPointPx);
  if (only_impostors && !shape.impostor.empty()) {
    t.impostor_px = kEver;
    return t;
  }
  // One range of sizes: from the first measured size that is good enough to the last before one that is not.
  bool inside = false;
  for (const SizeError& measured : shape.impostor) {
    const bool good = measured.silhouette_px <= tolerance && measured.ssim >= std::min(settings.least_ssim, measured.mesh_ssim);
    if (good && !inside) {
      if (t.impostor_px > 0) break;
      // Below the smallest that was measured outlines are off by less yet.
      t.impostor_from_px = &measured == &shape.impostor.front() ? 0 : measured.size_px;
      inside = true;
    }
    if (good) t.impostor_px = measured.size_px;
    if (!good && inside) break;
  }
  return t;
}

}  // namespace scree
