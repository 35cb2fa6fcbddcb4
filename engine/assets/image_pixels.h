// The image that comparisons take: display colours and, where there is one, an id for each pixel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "engine/assets/image.h"
#include "engine/core/result.h"

namespace scree::images {

// Rows from the top. Colours are sRGB-encoded display values: 0 black, 1 white; what lies outside
// is clamped when compared with a golden, what is not finite fails every comparison.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;     // 3 a pixel
  std::vector<uint32_t> ids;  // 1 a pixel, 0 = nothing; empty: the image has no ids

  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

// From 8-bit pixels with 3 or 4 channels as read from a display buffer; alpha is dropped.
Image imageFromBytes(int width, int height, int channels, std::span<const uint8_t> values,
                     RowOrder order = RowOrder::TopDown);
// From linear radiance with 3 or 4 channels: clamped to 0..1 and sRGB-encoded (IEC 61966-2-1), but
// NaN and infinities stay what they are.
Image imageFromLinear(int width, int height, int channels, std::span<const float> values,
                      RowOrder order = RowOrder::TopDown);
// Adds ids read from an id buffer of the same size.
void setIds(Image& image, std::span<const uint32_t> ids, RowOrder order = RowOrder::TopDown);

// Colour rounded to the 8 bits that a PNG holds; only for finite images.
Image quantised(const Image& image);

// Colours in `path`, ids beside it in idPath(path) if the image has ids (else that file is
// removed). Not-finite pixels are written magenta.
Status writeImage(const std::filesystem::path& path, const Image& image);
Result<Image> readImage(const std::filesystem::path& path);
// sphere.png -> sphere.id.png: RGBA, least significant byte in red.
std::filesystem::path idPath(const std::filesystem::path& path);

// sRGB transfer function of IEC 61966-2-1, and its inverse.
double srgbFromLinear(double linear);
double linearFromSrgb(double encoded);

}  // namespace scree::images
