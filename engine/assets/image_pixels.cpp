// Conversion, reading and writing of images that are compared.
#include "engine/assets/image_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"

namespace scree::images {
namespace {

// Calls set(index in the image, index in the source) for every pixel, turning rows top-down.
template <class Set>
void copyPixels(int width, int height, RowOrder order, Set&& set) {
  for (int y = 0; y < height; ++y) {
    const size_t source_row = static_cast<size_t>(order == RowOrder::TopDown ? y : height - 1 - y);
    for (int x = 0; x < width; ++x) {
      set(static_cast<size_t>(y) * width + x, source_row * width + x);
    }
  }
}

void requireSize(const char* what, int width, int height, int channels, size_t values) {
  const bool fits = width > 0 && height > 0 && channels >= 1 && channels <= 4 &&
                    values == static_cast<size_t>(width) * height * channels;
  if (!fits) {
    fail(fmt::format("{}: {} values for {}x{} pixels of {} channels", what, values, width, height,
                     channels));
  }
}

uint8_t byteFrom(float value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

}  // namespace

double srgbFromLinear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double linearFromSrgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Image imageFromBytes(int width, int height, int channels, std::span<const uint8_t> values,
                     RowOrder order) {
  requireSize("imageFromBytes", width, height, channels, values.size());
  if (channels < 3) fail("imageFromBytes: needs 3 or 4 channels");
  Image image{width, height, std::vector<float>(values.size() / channels * 3), {}};
  copyPixels(width, height, order, [&](size_t to, size_t from) {
    for (size_t c = 0; c < 3; ++c) image.rgb[to * 3 + c] = values[from * channels + c] / 255.0f;
  });
  return image;
}

Image imageFromLinear(int width, int height, int channels, std::span<const float> values,
                      RowOrder order) {
  requireSize("imageFromLinear", width, height, channels, values.size());
  if (channels < 3) fail("imageFromLinear: needs 3 or 4 channels");
  Image image{width, height, std::vector<float>(values.size() / channels * 3), {}};
  copyPixels(width, height, order, [&](size_t to, size_t from) {
    for (size_t c = 0; c < 3; ++c) {
      const float linear = values[from * channels + c];
      image.rgb[to * 3 + c] =
          std::isfinite(linear) ? static_cast<float>(srgbFromLinear(std::clamp(linear, 0.0f, 1.0f)))
                                : linear;
    }
  });
  return image;
}

void setIds(Image& image, std::span<const uint32_t> ids, RowOrder order) {
  requireSize("setIds", image.width, image.height, 1, ids.size());
  image.ids.resize(ids.size());
  copyPixels(image.width, image.height, order,
             [&](size_t to, size_t from) { image.ids[to] = ids[from]; });
}

Image quantised(const Image& image) {
  Image out = image;
  for (float& value : out.rgb) value = byteFrom(value) / 255.0f;
  return out;
}

std::filesystem::path idPath(const std::filesystem::path& path) {
  return std::filesystem::path(path).replace_extension(".id.png");
}

Status writeImage(const std::filesystem::path& path, const Image& image) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  std::vector<uint8_t> bytes(image.rgb.size());
  for (size_t i = 0; i < image.pixels(); ++i) {
    const float* rgb = &image.rgb[i * 3];
    if (std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2])) {
      for (size_t c = 0; c < 3; ++c) bytes[i * 3 + c] = byteFrom(rgb[c]);
    } else {
      bytes[i * 3] = bytes[i * 3 + 2] = 255;
    }
  }
  if (Status written = writePng(path, image.width, image.height, 3, bytes); !written.ok()) {
    return written;
  }
  if (image.ids.empty()) {
    std::filesystem::remove(idPath(path), ignored);
    return Done{};
  }
  std::vector<uint8_t> packed;
  packed.reserve(image.ids.size() * 4);
  for (uint32_t id : image.ids) {
    for (int shift = 0; shift < 32; shift += 8) packed.push_back(static_cast<uint8_t>(id >> shift));
  }
  return writePng(idPath(path), image.width, image.height, 4, packed);
}

Result<Image> readImage(const std::filesystem::path& path) {
  auto colour = loadImage(path, ColorEncoding::Srgb);
  if (!colour.ok()) return colour.takeError();
  if (colour->channels != 3 || colour->bytes.empty()) {
    return Error{
        fmt::format("{}: {} channels, a golden has 3 of 8 bits", path.string(), colour->channels)};
  }
  Image image = imageFromBytes(colour->width, colour->height, 3, colour->bytes);
  if (!std::filesystem::exists(idPath(path))) return image;
  auto packed = loadImage(idPath(path), ColorEncoding::Linear);
  if (!packed.ok()) return packed.takeError();
  if (packed->channels != 4 || packed->width != image.width || packed->height != image.height ||
      packed->bytes.empty()) {
    return Error{fmt::format("{}: {}x{} with {} channels, must be {}x{} with 4 of 8 bits",
                             idPath(path).string(), packed->width, packed->height, packed->channels,
                             image.width, image.height)};
  }
  image.ids.resize(image.pixels());
  for (size_t i = 0; i < image.ids.size(); ++i) {
    const uint8_t* bytes = &packed->bytes[i * 4];
    image.ids[i] = static_cast<uint32_t>(bytes[0]) | static_cast<uint32_t>(bytes[1]) << 8 |
                   static_cast<uint32_t>(bytes[2]) << 16 | static_cast<uint32_t>(bytes[3]) << 24;
  }
  return image;
}

}  // namespace scree::images
