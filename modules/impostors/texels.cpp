// Filtering of texels: coverage-weighted means, and their continuation beyond the silhouette.
#include "modules/impostors/texels.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "shaders/shared/gbuffer.h"
#include "shaders/shared/impostor.h"
#include "shaders/shared/spread.h"

namespace scree::impostors {
namespace {

constexpr int kRings = 2;  // so many texels a bilinear filter of the next level's size can reach

uint8_t unorm(float x) {
  return static_cast<uint8_t>(std::clamp(x, 0.0f, 1.0f) * 255.0f + 0.5f);
}
// 1 to 255, 128 for 0; the inverse of impostorHeightFromCode.
uint8_t centered(float x) {
  return static_cast<uint8_t>(std::clamp(x, -1.0f, 1.0f) * 127.0f + 128.5f);
}

// A mean of normals with the most spread that is kept; what has next to no direction takes that of `otherwise`.
vec3 longEnough(const vec3& normal, const vec3& otherwise) {
  const float least = 1 - rules::kMostSpread;
  const float length = glm::length(normal);
  if (length >= least) return normal;
  return length > 1e-3f ? normal * (least / length) : otherwise * (least / glm::length(otherwise));
}

// Mean of the known neighbours of a texel; not known if there is none.
Texel aroundOf(std::span<const Texel> texels, int side, int x, int y) {
  Texel mean{.albedo = vec3(0), .normal = vec3(0), .roughness = 0};
  int count = 0;
  vec3 last(0);
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side - 1); ++j) {
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side - 1); ++i) {
      const Texel& t = texels[static_cast<size_t>(j * side + i)];
      if (!t.known) continue;
      ++count;
      mean.albedo += t.albedo;
      mean.metallic += t.metallic;
      mean.normal += t.normal;
      mean.roughness += t.roughness;
      mean.height += t.height;
      last = t.normal;
    }
  }
  if (count == 0) return {};
  const float share = 1.0f / static_cast<float>(count);
  mean.albedo *= share;
  mean.metallic *= share;
  mean.roughness *= share;
  mean.height *= share;
  mean.normal = longEnough(mean.normal * share, last);
  mean.known = true;
  return mean;
}

}  // namespace

std::vector<TexelSum> halved(std::span<const TexelSum> sums, int side) {
  const int half = side / 2;
  std::vector<TexelSum> out(static_cast<size_t>(half) * static_cast<size_t>(half));
  for (int y = 0; y < half; ++y) {
    for (int x = 0; x < half; ++x) {
      TexelSum& to = out[static_cast<size_t>(y * half + x)];
      for (int k = 0; k < 4; ++k) {
        const TexelSum& from = sums[static_cast<size_t>((2 * y + k / 2) * side + 2 * x + k % 2)];
        to.coverage += from.coverage * 0.25f;
        to.albedo += from.albedo * 0.25f;
        to.metallic += from.metallic * 0.25f;
        to.normal += from.normal * 0.25f;
        to.alpha2 += from.alpha2 * 0.25f;
        to.height += from.height * 0.25f;
      }
    }
  }
  return out;
}

Texel meanOf(const TexelSum& sum, const vec3& axis) {
  if (!(sum.coverage > 0)) return {.normal = axis};
  const float inverse = 1.0f / sum.coverage;
  return {.albedo = sum.albedo * inverse,
          .metallic = sum.metallic * inverse,
          .normal = longEnough(sum.normal * inverse, axis),
          .roughness = std::sqrt(std::sqrt(sum.alpha2 * inverse)),
          .height = sum.height * inverse,
          .known = true};
}

void spreadOut(std::span<Texel> texels, int side, std::span<const Texel> coarser,
               const Texel& fallback) {
  std::vector<std::pair<size_t, Texel>> ring;
  for (int k = 0; k < kRings; ++k) {
    ring.clear();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const auto at = static_cast<size_t>(y * side + x);
        if (texels[at].known) continue;
        if (const Texel mean = aroundOf(texels, side, x, y); mean.known)
          ring.emplace_back(at, mean);
      }
    }
    for (const auto& [at, texel] : ring) texels[at] = texel;
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      Texel& texel = texels[static_cast<size_t>(y * side + x)];
      if (texel.known) continue;
      texel = coarser.empty() ? fallback : coarser[static_cast<size_t>(y / 2 * (side / 2) + x / 2)];
      texel.known = true;
    }
  }
}

StoredTexel stored(float coverage, const Texel& texel) {
  const vec3 code = rules::albedoCode(texel.albedo);
  return {{unorm(coverage), centered(texel.height)},
          {unorm(code.x), unorm(code.y), unorm(code.z), unorm(texel.metallic)},
          {centered(texel.normal.x), centered(texel.normal.y), centered(texel.normal.z),
           unorm(texel.roughness)}};
}

}  // namespace scree::impostors
