// Offsets into an atlas, filtered reading, and errors between measured sizes.
#include "modules/impostors/atlas.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "shaders/shared/coverage.h"

namespace scree {
namespace {

template <size_t kChannels>
std::array<float, kChannels> sampleChannels(const std::vector<uint8_t>& data,
                                            const ImpostorAtlas& atlas, int level, int layer,
                                            vec2 uv) {
  const int side = atlas.side(level);
  const uint8_t* from = data.data() + atlas.offset(level, layer) * kChannels;
  // Beyond the edge all is the edge's; a number that is not finite reads the lower edge.
  const auto position = [side](float u) {
    const float x = u * static_cast<float>(side) - 0.5f;
    return x > 0 ? std::min(x, static_cast<float>(side - 1)) : 0.0f;
  };
  const float x = position(uv.x), y = position(uv.y);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, side - 1), y1 = std::min(y0 + 1, side - 1);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  std::array<float, kChannels> out;
  for (size_t c = 0; c < kChannels; ++c) {
    const auto at = [&](int i, int j) {
      return static_cast<float>(from[static_cast<size_t>(j * side + i) * kChannels + c]);
    };
    const float low = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * fx;
    const float high = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * fx;
    out[c] = (low + (high - low) * fy) * (1.0f / 255.0f);
  }
  return out;
}

}  // namespace

int ImpostorAtlas::levels() const {
  int count = 0;
  while (texels >> count > 0) ++count;
  return count;
}

uint64_t ImpostorAtlas::levelOffset(int level) const {
  uint64_t before = 0;
  for (int l = 0; l < level; ++l)
    before += static_cast<uint64_t>(views()) * static_cast<uint64_t>(side(l) * side(l));
  return before;
}

uint64_t ImpostorAtlas::offset(int level, int layer) const {
  return levelOffset(level) +
         static_cast<uint64_t>(layer) * static_cast<uint64_t>(side(level) * side(level));
}

float impostorLevelMostPx(int texels, int level) {
  if (level <= 0) return std::numeric_limits<float>::max();
  return static_cast<float>(texels - 2) * std::exp2(rules::kImpostorShapeBias + 0.5f - static_cast<float>(level));
}

uint64_t impostorBytes(int edge, int texels) {
  // shared/coverage.h: a word of coverage, one of heights and two of surface for each texel.
  const ivec2 size = rules::coverageSize(texels, rules::impostorViewCount(edge));
  return 16 * static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y);
}

vec2 sampleShape(const ImpostorAtlas& atlas, int level, int layer, vec2 uv) {
  const auto v = sampleChannels<2>(atlas.shape, atlas, level, layer, uv);
  return {v[0], v[1]};
}
vec4 sampleColor(const ImpostorAtlas& atlas, int level, int layer, vec2 uv) {
  const auto v = sampleChannels<4>(atlas.color, atlas, level, layer, uv);
  return {v[0], v[1], v[2], v[3]};
}
vec4 sampleNormal(const ImpostorAtlas& atlas, int level, int layer, vec2 uv) {
  const auto v = sampleChannels<4>(atlas.normal, atlas, level, layer, uv);
  return {v[0], v[1], v[2], v[3]};
}

ImpostorError ImpostorErrors::at(ImpostorScheme scheme, float diameter_px) const {
  const auto& row = of[static_cast<size_t>(scheme)];
  if (!(diameter_px > kImpostorSizesPx[0])) return row[0];
  size_t k = 1;
  while (k < kImpostorSizes && diameter_px > kImpostorSizesPx[k]) ++k;
  if (k == kImpostorSizes) return row[k - 1];
  const float t = std::log(diameter_px / kImpostorSizesPx[k - 1]) /
                  std::log(kImpostorSizesPx[k] / kImpostorSizesPx[k - 1]);
  const auto between = [&](float ImpostorError::*member) {
    return row[k - 1].*member + (row[k].*member - row[k - 1].*member) * t;
  };
  return {between(&ImpostorError::ssim), between(&ImpostorError::flip),
          between(&ImpostorError::silhouette_px), between(&ImpostorError::worst_silhouette_px)};
}

}  // namespace scree
