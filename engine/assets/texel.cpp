// Decoding, wrapping and filtering of texels.
#include "engine/assets/texel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

namespace scree {
namespace {

// x^(1/5) of x in (0, 1] by Newton's steps from above: only exact operations, so the same bits
// everywhere, which std::pow does not promise.
double fifthRoot(double x) {
  double y = 1;
  for (int step = 0; step < 64; ++step) y -= (y - x / (y * y * y * y)) / 5;
  return y;
}
// sRGB decoding (IEC 61966-2-1), by code.
const std::array<float, 256>& linearFromCode() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> out{};
    for (size_t code = 0; code < out.size(); ++code) {
      const double x = static_cast<double>(code) / 255;
      const double y = (x + 0.055) / 1.055;
      out[code] = static_cast<float>(x <= 0.04045 ? x / 12.92 : y * y * fifthRoot(y * y));
    }
    return out;
  }();
  return table;
}

int wrapped(int x, int size, TextureWrap wrap) {
  if (wrap == TextureWrap::ClampToEdge) return std::clamp(x, 0, size - 1);
  const int period = wrap == TextureWrap::Repeat ? size : 2 * size;
  x %= period;
  if (x < 0) x += period;
  return x < size ? x : period - 1 - x;
}

// In texels of the image, from its upper left corner.
vec2 placeOf(const ImageData& image, vec2 uv) {
  constexpr float kFar = 1e5f;  // times the largest image it still fits an int
  const auto within = [=](float v) { return v > -kFar ? std::min(v, kFar) : -kFar; };  // NaN too
  return vec2(within(uv.x) * static_cast<float>(image.width), within(uv.y) * static_cast<float>(image.height));
}

}  // namespace

vec4 texelAt(const ImageData& image, int x, int y) {
  const auto channels = static_cast<size_t>(image.channels);
  const size_t at =
      (static_cast<size_t>(y) * static_cast<size_t>(image.width) + static_cast<size_t>(x)) *
      channels;
  vec4 out(0, 0, 0, 1);
  const bool grey = channels < 3;
  for (size_t c = 0; c < 4; ++c) {
    if (c == 3 && channels % 2 == 1) continue;
    const size_t from = at + (c == 3 ? channels - 1 : grey ? 0 : c);
    if (image.isFloat())
      out[static_cast<int>(c)] = std::isfinite(image.floats[from]) ? image.floats[from] : 0;
    else if (image.encoding == ColorEncoding::Srgb && c < 3)
      out[static_cast<int>(c)] = linearFromCode()[image.bytes[from]];
    else
      out[static_cast<int>(c)] = static_cast<float>(image.bytes[from]) * (1.0f / 255.0f);
  }
  return out;
}

vec4 nearestTexel(const ImageData& image, const TextureUse& use, vec2 uv) {
  const vec2 place = glm::floor(placeOf(image, uv));
  return texelAt(image, wrapped(static_cast<int>(place.x), image.width, use.wrap_u),
                 wrapped(static_cast<int>(place.y), image.height, use.wrap_v));
}

vec4 bilinearTexel(const ImageData& image, const TextureUse& use, vec2 uv) {
  const vec2 place = placeOf(image, uv) - 0.5f, first = glm::floor(place);
  const auto column = [&](int k) { return wrapped(static_cast<int>(first.x) + k, image.width, use.wrap_u); };
  const auto row = [&](int k) { return wrapped(static_cast<int>(first.y) + k, image.height, use.wrap_v); };
  const vec2 part = place - first;
  const vec4 low = glm::mix(texelAt(image, column(0), row(0)), texelAt(image, column(1), row(0)), part.x);
  const vec4 high = glm::mix(texelAt(image, column(0), row(1)), texelAt(image, column(1), row(1)), part.x);
  return glm::mix(low, high, part.y);
}

}  // namespace scree
