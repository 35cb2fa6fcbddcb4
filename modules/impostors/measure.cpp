// Random views, three measures each.
#include "modules/impostors/measure.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <mutex>
#include <numbers>

#include "engine/assets/image_flip.h"
#include "engine/assets/image_metrics.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"

namespace scree::impostors {
namespace {

// Margin of a picture, so that the grain has as much ground around it as SSIM's window reaches.
constexpr int kMargin = 6;
// Above this size fewer samples a pixel tell as much.
constexpr float kLargePx = 48;

// Uniform in the unit ball without its core, by rejection: no function that machines round apart.
vec3 randomVector(uint64_t k, uint64_t stream) {
  for (uint64_t draw = 0;; draw += 3) {
    const vec3 v = vec3(randomUnit(stream, k, 0, draw), randomUnit(stream, k, 0, draw + 1),
                        randomUnit(stream, k, 0, draw + 2)) *
                       2.0f -
                   1.0f;
    const float length2 = glm::dot(v, v);
    if (length2 < 1 && length2 > 1e-2f) return v;
  }
}

int finely(float diameter_px) {
  return diameter_px > kLargePx ? 4 : 8;
}

using Row = std::array<std::array<ImpostorError, kImpostorSizes>, kImpostorSchemes>;

void measureOne(const UnitGrain& grain, const ImpostorAtlas& atlas, int k, size_t size, Row& row) {
  const float diameter = kImpostorSizesPx[size];
  const Scene scene = randomScene(k, diameter);
  const int edges = diameter > kLargePx ? 2 : 4;
  const images::Image truth = drawMesh(grain, scene, finely(diameter));
  const std::vector<uint8_t> silhouette = meshMask(grain, scene, edges);
  for (size_t scheme = 0; scheme < kImpostorSchemes; ++scheme) {
    const auto which = static_cast<ImpostorScheme>(scheme);
    ImpostorError& error = row[scheme][size];
    const images::Image image = which == ImpostorScheme::Mesh ? drawMesh(grain, scene, 1)
                                                              : drawImpostor(atlas, which, scene);
    error.ssim = static_cast<float>(images::ssim(image, truth).mean);
    error.flip = static_cast<float>(images::flip(image, truth).mean);
    if (which == ImpostorScheme::Mesh) continue;
    error.silhouette_px = static_cast<float>(silhouetteError(
        impostorMask(atlas, which, scene, edges), silhouette, scene.side_px * edges, edges));
    error.worst_silhouette_px = error.silhouette_px;
  }
}

}  // namespace

Scene randomScene(int k, float diameter_px) {
  const vec3 axis = glm::normalize(randomVector(static_cast<uint64_t>(k), 1));
  vec3 other = randomVector(static_cast<uint64_t>(k), 2);
  vec3 right = glm::cross(other, axis);
  if (glm::dot(right, right) < 1e-4f) right = rules::impostorBasis(axis).right;
  right = glm::normalize(right);
  return {axis, right, glm::cross(axis, right), diameter_px,
          static_cast<int>(std::ceil(diameter_px)) + 2 * kMargin};
}

double silhouetteError(const std::vector<uint8_t>& mask, const std::vector<uint8_t>& truth,
                       int side, int samples) {
  size_t differing = 0, crossings = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const auto at = static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x);
      differing += mask[at] != truth[at];
      if (x + 1 < side) crossings += truth[at] != truth[at + 1];
      if (y + 1 < side) crossings += truth[at] != truth[at + static_cast<size_t>(side)];
    }
  }
  const double area = static_cast<double>(differing) / static_cast<double>(samples * samples);
  const double length =
      static_cast<double>(std::max<size_t>(crossings, 1)) * std::numbers::pi / 4 / samples;
  return area / length;
}

float flipAt(const UnitGrain& grain, const ImpostorAtlas& atlas, ImpostorScheme scheme,
             float diameter_px, int directions) {
  std::vector<double> flips(static_cast<size_t>(directions));
  parallelChunks(flips.size(), 1, [&](size_t k, size_t, size_t) {
    const Scene scene = randomScene(static_cast<int>(k), diameter_px);
    flips[k] = images::flip(drawImpostor(atlas, scheme, scene),
                            drawMesh(grain, scene, finely(diameter_px)))
                   .mean;
  });
  double sum = 0;
  for (double flip : flips) sum += flip;
  return static_cast<float>(sum / directions);
}

ImpostorErrors measure(const UnitGrain& grain, const ImpostorAtlas& atlas, int directions,
                       const std::function<void(double)>& progress) {
  std::vector<Row> rows(static_cast<size_t>(directions));
  std::mutex reporting;
  size_t done = 0;
  const size_t jobs = rows.size() * kImpostorSizes;
  // Large pictures first, so that the threads end together.
  parallelChunks(jobs, 1, [&](size_t job, size_t, size_t) {
    const size_t size = kImpostorSizes - 1 - job / rows.size(), k = job % rows.size();
    measureOne(grain, atlas, static_cast<int>(k), size, rows[k]);
    const std::lock_guard lock(reporting);
    ++done;
    progress(static_cast<double>(done) / static_cast<double>(jobs));
  });
  ImpostorErrors errors{.directions = static_cast<uint32_t>(directions)};
  for (size_t scheme = 0; scheme < kImpostorSchemes; ++scheme) {
    for (size_t size = 0; size < kImpostorSizes; ++size) {
      double ssim = 0, flip = 0, silhouette = 0;
      float worst = 0;
      for (const Row& row : rows) {
        const ImpostorError& one = row[scheme][size];
        ssim += one.ssim;
        flip += one.flip;
        silhouette += one.silhouette_px;
        worst = std::max(worst, one.worst_silhouette_px);
      }
      const double share = 1.0 / directions;
      errors.of[scheme][size] = {static_cast<float>(ssim * share), static_cast<float>(flip * share),
                                 static_cast<float>(silhouette * share), worst};
    }
  }
  return errors;
}

}  // namespace scree::impostors
