// Masks by the shared rules and by the exact rasteriser.
#include "modules/impostors/outline.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "modules/impostors/cast.h"
#include "modules/impostors/measure.h"
#include "modules/lod/lod.h"
#include "shaders/shared/swarm.h"

namespace scree::impostors {
namespace {

// Samples around the silhouette of the outer sphere that stay empty.
constexpr int kMargin = 2;

// Diameters in pixels at which three views, and one alone, may be drawn.
const float kLeastFullPx = 3, kMostSmallPx = 2.2f * rules::kSmallPx;

constexpr uint64_t kSearchSeed = 4;
constexpr float kSearchSamples = 48;  // a radius

// Radius of that silhouette on the plane through the centre.
float sphereExtent(float nearness) { return 1 / std::sqrt(1 - nearness * nearness); }

OutlineMask empty(const OutlineView& view, float samples_a_radius) {
  OutlineMask mask;
  const float half = sphereExtent(view.nearness) * samples_a_radius;
  mask.side = 2 * (static_cast<int>(std::ceil(half)) + kMargin);
  mask.samples_a_radius = samples_a_radius;
  mask.covered.resize(static_cast<size_t>(mask.side) * static_cast<size_t>(mask.side));
  return mask;
}

// Calls covers(x, y) for each sample, at a place on the plane.
template <class Covers>
void fill(OutlineMask& mask, const Covers& covers) {
  const float step = 1 / mask.samples_a_radius, middle = 0.5f * static_cast<float>(mask.side);
  size_t at = 0;
  for (int y = 0; y < mask.side; ++y)
    for (int x = 0; x < mask.side; ++x)
      mask.covered[at++] = covers((static_cast<float>(x) + 0.5f - middle) * step, (static_cast<float>(y) + 0.5f - middle) * step);
}

// A unit vector around `middle`, at most about `reach` away from it.
vec3 around(const vec3& middle, float reach, uint64_t number) {
  const auto unit = [&](uint64_t k) { return 2 * randomUnit(kSearchSeed, number, 1, k) - 1; };
  return glm::normalize(middle + reach * vec3(unit(0), unit(1), unit(2)));
}

struct Tried {
  vec3 axis{0, 0, 1};
  double off = 0;
};

// The most that off(axis) was found to be.
double worstOf(const std::function<double(const vec3&)>& off) {
  constexpr int kFirstView = 5000;  // none of those of measure()
  constexpr size_t kDirections = 160, kBest = 6, kTries = 4;
  std::vector<Tried> tried(kDirections);
  parallelChunks(tried.size(), 1, [&](size_t k, size_t, size_t) {
    tried[k].axis = randomScene(kFirstView + static_cast<int>(k), 1).axis;
    tried[k].off = off(tried[k].axis);
  });
  float reach = 0.15f;  // half of what lies between two of these directions
  for (uint64_t round = 0; round < 4; ++round, reach *= 0.5f) {
    std::ranges::stable_sort(tried, [](const Tried& a, const Tried& b) { return a.off > b.off; });
    tried.resize(kBest * (1 + kTries));
    parallelChunks(kBest * kTries, 1, [&](size_t k, size_t, size_t) {
      Tried& next = tried[kBest + k];
      next.axis = around(tried[k / kTries].axis, reach, 1000 * round + k);
      next.off = off(next.axis);
    });
  }
  double most = 0;
  for (const Tried& t : tried) most = std::max(most, t.off);
  return most;
}

// Radius of the disc that the grain is as a point: at most that of the sphere around it.
double pointRadius(const UnitGrain& grain) {
  double area = 0;
  for (const UnitTriangle& t : grain.triangles) {
    const dvec3 a = grain.positions[t.v[0]], b = grain.positions[t.v[1]], c = grain.positions[t.v[2]];
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return std::min(meanShadowRadius(area), 1.0);
}

}  // namespace

OutlineView outlineView(const vec3& axis, float nearness) {
  const rules::ImpostorBasis basis = rules::impostorBasis(axis);
  return {axis, basis.right, basis.up, nearness};
}

OutlineMask meshOutline(const UnitGrain& grain, const OutlineView& view, float samples_a_radius) {
  OutlineMask mask = empty(view, samples_a_radius);
  const dvec3 axis(view.axis), right(view.right), up(view.up);
  // What is nearer to the eye than the centre is larger by perspective; the rest is orthographic.
  std::vector<dvec3> positions;
  positions.reserve(grain.positions.size());
  for (const dvec3& p : grain.positions) {
    const double height = glm::dot(p, axis), scale = 1 / (1 - static_cast<double>(view.nearness) * height);
    positions.push_back((right * glm::dot(p, right) + up * glm::dot(p, up)) * scale + axis * (height * scale));
  }
  std::vector<Seen> seen;
  cast(grain, positions, {axis, right, up, 0.5 * mask.side / static_cast<double>(samples_a_radius), mask.side}, seen);
  for (size_t k = 0; k < seen.size(); ++k) mask.covered[k] = seen[k].triangle >= 0;
  return mask;
}

OutlineMask impostorOutline(const ImpostorAtlas& atlas, const OutlineView& view, int level, bool small,
                            float samples_a_radius) {
  OutlineMask mask = empty(view, samples_a_radius);
  const rules::ImpostorViews views = rules::impostorViews(view.axis, atlas.edge);
  const int layers[3] = {static_cast<int>(views.layer0), static_cast<int>(views.layer1), static_cast<int>(views.layer2)};
  const vec3 axes[3] = {views.axis0, views.axis1, views.axis2};
  const float extent = rules::impostorExtent(atlas.texels), near = view.nearness;
  level = std::clamp(level, 0, atlas.levels() - 1);
  const rules::Ellipsoid bound = near * rules::kLeastEllipsoidEye > 1 ? rules::unitBall() : atlas.bound;
  const int nearest = views.weight.x >= std::max(views.weight.y, views.weight.z) ? 0 : views.weight.y >= views.weight.z ? 1 : 2;
  fill(mask, [&](float x, float y) {
    // The ray through this point of the plane, and the point itself, a unit towards the eye being `near` of its distance.
    const vec3 point = view.right * x + view.up * y;
    // As if all rays were parallel.
    if (small)
      return !rules::missesEllipsoid(atlas.bound, point, view.axis) &&
             sampleShape(atlas, level, layers[nearest], rules::impostorUv(point, axes[nearest], extent)).x >= 0.5f;
    const rules::ImpostorRay ray = rules::impostorRay(point, point * near - view.axis);
    if (rules::missesEllipsoid(bound, ray.foot, ray.direction)) return false;
    const vec3 seen = rules::impostorOnProxy(ray, atlas.proxy);
    float coverage = 0;
    for (int k = 0; k < 3; ++k)
      coverage += views.weight[k] * sampleShape(atlas, level, layers[k], rules::impostorUv(seen, axes[k], extent)).x;
    return coverage >= 0.5f;
  });
  return mask;
}

OutlineMask discOutline(float radius, const OutlineView& view, float samples_a_radius) {
  OutlineMask mask = empty(view, samples_a_radius);
  fill(mask, [&](float x, float y) { return x * x + y * y < radius * radius; });
  return mask;
}

double outlineOff(const OutlineMask& mask, const OutlineMask& truth) {
  return silhouetteError(mask.covered, truth.covered, truth.side, 1) / static_cast<double>(truth.samples_a_radius);
}

ImpostorOutlines outlineBounds(const UnitGrain& grain, const ImpostorAtlas& atlas, const std::function<void(double)>& progress) {
  ImpostorOutlines bounds;
  int done = 0;  // searches, of two a level and three more at most
  const auto report = [&] {
    if (progress) progress(static_cast<double>(++done) / (2 * atlas.levels() + 3));
  };
  const auto worst = [&](int level, bool small, float nearness) {
    return kOutlineMargin * static_cast<float>(worstOf([&](const vec3& axis) {
             const OutlineView view = outlineView(axis, nearness);
             return outlineOff(impostorOutline(atlas, view, level, small, kSearchSamples),
                               meshOutline(grain, view, kSearchSamples));
           }));
  };
  for (int level = 0; level < atlas.levels(); ++level) {
    const auto at = static_cast<size_t>(level);
    const float largest_px = impostorLevelMostPx(atlas.texels, level), least_px = impostorLevelMostPx(atlas.texels, level + 1);
    if (level == 0 || largest_px > kLeastFullPx) bounds.full[at] = worst(level, false, 0);
    report();
    if (level + 1 == atlas.levels() || least_px < kMostSmallPx) bounds.small[at] = worst(level, true, 0);
    report();
  }
  // Most at the sharpest levels.
  const auto slope = [&](bool small, const auto& levels) {
    const size_t sharpest = static_cast<size_t>(std::ranges::find_if(levels, [](float x) { return x < kImpostorOutlineUnknown; }) - levels.begin());
    return std::max(worst(static_cast<int>(sharpest), small, rules::kImpostorMostNear) - levels[sharpest], 0.0f) / rules::kImpostorMostNear;
  };
  const auto disc = static_cast<float>(pointRadius(grain));
  bounds.point = kOutlineMargin * static_cast<float>(worstOf([&](const vec3& axis) {
                   const OutlineView view = outlineView(axis, 0);
                   return outlineOff(discOutline(disc, view, kSearchSamples), meshOutline(grain, view, kSearchSamples));
                 }));
  report();
  bounds.full_near = slope(false, bounds.full);
  report();
  bounds.small_near = slope(true, bounds.small);
  report();
  return bounds;
}

}  // namespace scree::impostors
