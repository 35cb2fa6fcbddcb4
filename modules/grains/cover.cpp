// Marking and joining the tiles.
#include "modules/grains/cover.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>

#include "shaders/shared/cover.h"

namespace scree::grains {
namespace {

constexpr float kTile = static_cast<float>(rules::kCoverTilePx);
// Rounding of the bound here, and of the rasteriser's positions.
constexpr float kMarginTiles = 1.0f / kTile;

}  // namespace

void Cover::reset(const View& view) {
  const rules::ViewBlock& block = view.block;
  tiles_ = glm::min((ivec2(block.size_px) + rules::kCoverTilePx - 1) / rules::kCoverTilePx,
                    ivec2(rules::kCoverMask + 1));
  tiles_per_ndc_ = block.size_px * (0.5f / kTile);
  const mat4 rows = glm::transpose(block.clip_from_relative);
  row_x_ = rows[0];
  row_y_ = rows[1];
  row_w_ = rows[3];
  length_x_ = glm::length(vec3(row_x_));
  length_y_ = glm::length(vec3(row_y_));
  marked_.assign(static_cast<size_t>(tiles_.x) * static_cast<size_t>(tiles_.y), 0);
}

void Cover::add(const vec3& center, float radius) {
  const vec4 point(center, 1);
  const float w = glm::dot(row_w_, point);
  ivec2 low(0), high = tiles_ - 1;
  if (w > 1.001f * radius) {
    const vec2 middle(glm::dot(row_x_, point), glm::dot(row_y_, point));
    const vec2 half(length_x_ * radius, length_y_ * radius);
    const float from_near = 1 / (w - radius), from_far = 1 / (w + radius);
    const vec2 least = middle - half, most = middle + half;
    const vec2 ndc_low = glm::min(least * from_near, least * from_far);
    const vec2 ndc_high = glm::max(most * from_near, most * from_far);
    // Clamped as floats: a sphere near the eye's plane may be beyond the range of int.
    const vec2 last(high);
    low = ivec2(glm::clamp((ndc_low + 1.0f) * tiles_per_ndc_ - kMarginTiles, vec2(0), last));
    high = ivec2(glm::clamp((ndc_high + 1.0f) * tiles_per_ndc_ + kMarginTiles, vec2(0), last));
  }
  for (int y = low.y; y <= high.y; ++y) {
    uint8_t* row = &marked_[static_cast<size_t>(y) * static_cast<size_t>(tiles_.x)];
    std::fill(row + low.x, row + high.x + 1, uint8_t{1});
  }
}

void Cover::spans(std::vector<uint32_t>& out) const {
  out.clear();
  for (int y = 0; y < tiles_.y; ++y) {
    const uint8_t* row = &marked_[static_cast<size_t>(y) * static_cast<size_t>(tiles_.x)];
    for (int x = 0; x < tiles_.x;) {
      if (!row[x]) {
        ++x;
        continue;
      }
      int end = x;
      while (end < tiles_.x && row[end]) ++end;
      out.push_back(rules::packCoverSpan(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                         static_cast<uint32_t>(end)));
      x = end;
    }
  }
}

}  // namespace scree::grains
