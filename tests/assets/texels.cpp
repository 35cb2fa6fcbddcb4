// Texels of images of every kind, their wrapping and filtering, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine/assets/texel.h"

namespace scree::test {
namespace {

ImageData imageOf(int width, int height, int channels, std::vector<uint8_t> bytes, ColorEncoding encoding) {
  ImageData image;
  image.width = width;
  image.height = height;
  image.channels = channels;
  image.encoding = encoding;
  image.bytes = std::move(bytes);
  return image;
}

double linear(double code) {
  const double x = code / 255;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

TEST(Texels, GreyIsAllColorsAndTheLastOfTwoAndFourIsAlpha) {
  for (const ColorEncoding encoding : {ColorEncoding::Srgb, ColorEncoding::Linear})
    for (int channels = 1; channels <= 4; ++channels) {
      std::vector<uint8_t> bytes;
      for (int texel = 0; texel < 256; ++texel)
        for (int c = 0; c < channels; ++c) bytes.push_back(static_cast<uint8_t>(texel * (2 * c + 1) + 31 * c));
      const ImageData image = imageOf(16, 16, channels, bytes, encoding);
      for (int texel = 0; texel < 256; ++texel) {
        const vec4 read = texelAt(image, texel % 16, texel / 16);
        const auto code = [&](int c) { return static_cast<double>(bytes[static_cast<size_t>(texel * channels + c)]); };
        const auto value = [&](int c) { return encoding == ColorEncoding::Srgb ? linear(code(c)) : code(c) / 255; };
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(static_cast<double>(read[c]), value(channels < 3 ? 0 : c), 1e-7) << channels << ", " << texel;
        EXPECT_NEAR(static_cast<double>(read.w), channels % 2 == 0 ? code(channels - 1) / 255 : 1, 1e-7);
      }
    }
}

TEST(Texels, FloatsThatAreNotFiniteAreZero) {
  ImageData image = imageOf(2, 1, 3, {}, ColorEncoding::Linear);
  image.floats = {std::nanf(""), 7, -std::numeric_limits<float>::infinity(), 0.5f, -2, 1e30f};
  EXPECT_EQ(texelAt(image, 0, 0), vec4(0, 7, 0, 1));
  EXPECT_EQ(texelAt(image, 1, 0), vec4(0.5f, -2, 1e30f, 1));
}

// Against the definitions of the wrap modes, in double.
double wrappedPlace(double texel, int size, TextureWrap wrap) {
  if (wrap == TextureWrap::ClampToEdge) return std::min(std::max(texel, 0.0), size - 1.0);
  const double period = wrap == TextureWrap::Repeat ? size : 2 * size, within = texel - period * std::floor(texel / period);
  return within < size ? within : period - 1 - within;
}

TEST(Texels, AreWrappedAndFiltered) {
  constexpr int kWidth = 5, kHeight = 3;
  std::vector<uint8_t> bytes;
  for (int k = 0; k < kWidth * kHeight; ++k) bytes.push_back(static_cast<uint8_t>(17 * k));
  const ImageData image = imageOf(kWidth, kHeight, 1, bytes, ColorEncoding::Linear);
  for (const TextureWrap wrap_u : {TextureWrap::Repeat, TextureWrap::MirroredRepeat, TextureWrap::ClampToEdge})
    for (const TextureWrap wrap_v : {TextureWrap::Repeat, TextureWrap::MirroredRepeat, TextureWrap::ClampToEdge}) {
      const TextureUse use{.image = 0, .wrap_u = wrap_u, .wrap_v = wrap_v};
      const auto texel = [&](double x, double y) {
        const double at = wrappedPlace(y, kHeight, wrap_v) * kWidth + wrappedPlace(x, kWidth, wrap_u);
        return bytes[static_cast<size_t>(at)] / 255.0;
      };
      for (int i = -40; i <= 40; ++i)
        for (int j = -40; j <= 40; ++j) {
          const vec2 uv(0.0731f * static_cast<float>(i) + 0.003f, 0.0911f * static_cast<float>(j) + 0.002f);
          const double x = static_cast<double>(uv.x) * kWidth, y = static_cast<double>(uv.y) * kHeight;
          const auto nearest = static_cast<double>(nearestTexel(image, use, uv).x);
          EXPECT_NEAR(nearest, texel(std::floor(x), std::floor(y)), 1e-6) << uv.x << " " << uv.y;
          const double x0 = std::floor(x - 0.5), y0 = std::floor(y - 0.5), u = x - 0.5 - x0, v = y - 0.5 - y0;
          const double low = texel(x0, y0) * (1 - u) + texel(x0 + 1, y0) * u;
          const double high = texel(x0, y0 + 1) * (1 - u) + texel(x0 + 1, y0 + 1) * u;
          const auto between = static_cast<double>(bilinearTexel(image, use, uv).x);
          EXPECT_NEAR(between, low * (1 - v) + high * v, 1e-5) << uv.x << " " << uv.y;
        }
      for (const float far : {1e30f, -1e30f, std::numeric_limits<float>::infinity(), std::nanf("")}) {
        EXPECT_TRUE(std::isfinite(nearestTexel(image, use, {far, -far}).x));
        EXPECT_TRUE(std::isfinite(bilinearTexel(image, use, {-far, far}).x));
      }
    }
}

}  // namespace
}  // namespace scree::test
