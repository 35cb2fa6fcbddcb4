// Bounds of the casters in the light's axes, snapped to a grid of texels.
#include "modules/deferred/shadow_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace scree {
namespace {

struct Interval {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  void include(double low, double high) {
    min = std::min(min, low);
    max = std::max(max, high);
  }
};

// Smallest 2^(k/8) that is >= length.
double steppedUp(double length) { return std::exp2(std::ceil(std::log2(length) * 8) / 8); }

// From texels of the used part to clip space, along x and y.
constexpr double kClip = 2.0 / rules::kShadowMapSize;

// Coordinate = dot(row.xyz, p - origin) + row.w; x and y in texels of the map, z is depth.
using Rows = std::array<glm::dvec4, 3>;
Rows rowsFrom(const ShadowFit& fit, const dvec3& origin) {
  return {glm::dvec4(fit.axis_x, glm::dot(origin, fit.axis_x) - fit.left) / fit.texel,
          glm::dvec4(fit.axis_y, glm::dot(origin, fit.axis_y) - fit.bottom) / fit.texel,
          glm::dvec4(fit.axis_z, glm::dot(origin, fit.axis_z) - fit.far) / fit.depth};
}

}  // namespace

int shadowMapSide(const ShadowSettings& settings, int output_height) {
  // 2.8 texels a row: over a level that fills the picture, about one a pixel at its near end.
  const int wanted = settings.side_texels > 0 ? settings.side_texels : (output_height * 14 / 5 + 63) / 64 * 64;
  return std::clamp(wanted, 64, rules::kShadowMapSize);
}

ShadowFit fitShadow(std::span<const ShadowCasters::Sphere> casters, const dvec3& camera,
                    const vec3& to_sun, int map_size, float max_distance_m) {
  const dvec3 axis_z = glm::normalize(dvec3(to_sun));
  const dvec3 up = std::abs(axis_z.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(0, 0, 1);
  const dvec3 axis_x = glm::normalize(glm::cross(up, axis_z));
  const dvec3 axis_y = glm::cross(axis_z, axis_x);
  const dvec3 eye(glm::dot(camera, axis_x), glm::dot(camera, axis_y), glm::dot(camera, axis_z));
  const double reach = max_distance_m;

  Interval x, y, z;
  for (const ShadowCasters::Sphere& caster : casters) {
    const double r = caster.radius;
    const double cx = glm::dot(caster.center, axis_x), cy = glm::dot(caster.center, axis_y);
    const double cz = glm::dot(caster.center, axis_z);
    const bool in_reach = std::abs(cx - eye.x) - r < reach && std::abs(cy - eye.y) - r < reach;
    if (!in_reach || !(r > 0)) continue;  // also false for NaN
    x.include(std::max(cx - r, eye.x - reach), std::min(cx + r, eye.x + reach));
    y.include(std::max(cy - r, eye.y - reach), std::min(cy + r, eye.y + reach));
    z.include(cz - r, cz + r);
  }
  ShadowFit fit;
  if (!(x.min <= x.max) || !std::isfinite(z.max - z.min)) return fit;

  const int step = std::max(map_size / kShadowSteps, 1);
  const double usable = map_size - 2 * kShadowBorderTexels - step;
  fit.texel = steppedUp(std::max(std::max(x.max - x.min, y.max - y.min), 1e-3) / usable);
  const double across = step * fit.texel, border = kShadowBorderTexels * fit.texel;
  fit.left = std::floor(x.min / across) * across - border;
  fit.bottom = std::floor(y.min / across) * across - border;
  // A margin, so that rounding puts no caster outside [0, 1].
  const double margin = 1e-4 * (z.max - z.min) + 1e-4;
  const double along = steppedUp(z.max - z.min + 2 * margin) / kShadowSteps;
  fit.far = std::floor((z.min - margin) / along) * along;
  fit.depth = std::ceil((z.max + margin) / along) * along - fit.far;
  fit.axis_x = axis_x;
  fit.axis_y = axis_y;
  fit.axis_z = axis_z;
  fit.side = map_size;
  fit.enabled = true;
  return fit;
}

rules::ShadowViewBlock shadowViewBlock(const ShadowFit& fit, const dvec3& camera) {
  rules::ShadowViewBlock view{};
  if (!fit.enabled) return view;
  const Rows rows = rowsFrom(fit, camera);
  const double side = fit.side * fit.texel;
  for (int c = 0; c < 4; ++c) {
    const double one = c == 3 ? 1 : 0;
    view.shadow_from_relative[c] = vec4(rows[0][c], rows[1][c], rows[2][c], one);
    view.clip_from_relative[c] =
        vec4(kClip * rows[0][c] - one, kClip * rows[1][c] - one, rows[2][c], one);
  }
  view.axis_x = vec4(vec3(fit.axis_x), side / 2);
  view.axis_y = vec4(vec3(fit.axis_y), side / 2);
  view.to_sun = vec4(vec3(fit.axis_z), fit.depth);
  view.size_px = vec2(static_cast<float>(fit.side));
  view.texel_m = static_cast<float>(fit.texel);
  view.enabled = 1;
  return view;
}

void writeCasterRows(vec4* out, const ShadowFit& fit, const Transform& placed) {
  const Rows rows = rowsFrom(fit, placed.position);
  const mat4 turned = relativeFromLocal(placed, placed.position);
  for (int r = 0; r < 3; ++r) {
    const double scale = r < 2 ? kClip : 1;
    glm::dvec4 row(0, 0, 0, scale * rows[r].w - (r < 2 ? 1 : 0));
    for (int c = 0; c < 3; ++c) row[c] = scale * glm::dot(dvec3(rows[r]), dvec3(turned[c]));
    out[r] = vec4(row);
  }
}

rules::ShadowViewBlock fitShadowView(std::span<const ShadowCasters::Sphere> casters,
                                     const dvec3& camera, const vec3& to_sun, int map_size,
                                     float max_distance_m) {
  return shadowViewBlock(fitShadow(casters, camera, to_sun, map_size, max_distance_m), camera);
}

}  // namespace scree
