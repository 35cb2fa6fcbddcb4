// Bounds of the casters in the light's axes, snapped to a grid of texels.
#include "modules/deferred/shadow_fit.h"

#include <algorithm>
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

}  // namespace

int shadowMapSide(const ShadowSettings& settings, int output_height) {
  // 2.8 texels a row: over a level that fills the picture, about one a pixel at its near end.
  const int wanted = settings.side_texels > 0 ? settings.side_texels : (output_height * 14 / 5 + 63) / 64 * 64;
  return std::clamp(wanted, 64, rules::kShadowMapSize);
}

rules::ShadowViewBlock fitShadowView(std::span<const ShadowCasters::Sphere> casters,
                                     const dvec3& camera, const vec3& to_sun, int map_size,
                                     float max_distance_m) {
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
  rules::ShadowViewBlock view{};
  if (!(x.min <= x.max) || !std::isfinite(z.max - z.min)) return view;

  const double usable = map_size - 2 * kShadowBorderTexels - 1;  // 1: lost to the snapping
  const double texel = steppedUp(std::max(std::max(x.max - x.min, y.max - y.min), 1e-3) / usable);
  const double left = (std::floor(x.min / texel) - kShadowBorderTexels) * texel;
  const double bottom = (std::floor(y.min / texel) - kShadowBorderTexels) * texel;
  const double side = map_size * texel;
  // A margin, so that rounding puts no caster outside [0, 1].
  const double margin = 1e-4 * (z.max - z.min) + 1e-4;
  const double far = z.min - margin, depth = z.max + margin - far;

  // Rows: coordinate = dot(row.xyz, relative) + row.w; x and y in texels of the map.
  const glm::dvec4 rows[3] = {glm::dvec4(axis_x, eye.x - left) / texel,
                              glm::dvec4(axis_y, eye.y - bottom) / texel,
                              glm::dvec4(axis_z, eye.z - far) / depth};
  const double clip = 2.0 / rules::kShadowMapSize;
  for (int c = 0; c < 4; ++c) {
    const double one = c == 3 ? 1 : 0;
    view.shadow_from_relative[c] = vec4(rows[0][c], rows[1][c], rows[2][c], one);
    view.clip_from_relative[c] = vec4(clip * rows[0][c] - one, clip * rows[1][c] - one, rows[2][c], one);
  }
  view.axis_x = vec4(vec3(axis_x), side / 2);
  view.axis_y = vec4(vec3(axis_y), side / 2);
  view.to_sun = vec4(vec3(axis_z), depth);
  view.size_px = vec2(static_cast<float>(map_size));
  view.texel_m = static_cast<float>(texel);
  view.enabled = 1;
  return view;
}

}  // namespace scree
