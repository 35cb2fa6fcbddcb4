// Images in memory, and their files: PNG, JPEG and EXR through OpenImageIO.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"

namespace scree {

// What the stored numbers mean. 8-bit sRGB values become linear when a texture is sampled.
enum class ColorEncoding : uint8_t { Srgb, Linear };

// Which row a pixel array begins with. Files and ImageData begin with the top row; GL reads the
// bottom row first.
enum class RowOrder : uint8_t { TopDown, BottomUp };

// width * height pixels of `channels` (1 to 4) interleaved values, top row first, in `bytes`
// (0 to 255) or, for EXR, in `floats` (linear; NaN and infinity are kept): one of them is empty.
struct ImageData {
  std::string name;
  int width = 0;
  int height = 0;
  int channels = 0;
  ColorEncoding encoding = ColorEncoding::Linear;  // always Linear for floats
  std::vector<uint8_t> bytes;
  std::vector<float> floats;

  bool isFloat() const { return !floats.empty(); }
};

// What is decoded at most; a file that claims more is refused before memory is taken for it.
struct ImageLimits {
  int max_side = 16384;                     // pixels
  uint64_t max_pixels = uint64_t{1} << 26;  // 8192 x 8192
  uint64_t max_file_bytes = uint64_t{1} << 28;
};

// Reads a PNG, JPEG or EXR file. 16-bit PNG is reduced to 8 bits; palettes are expanded; channels
// beyond the fourth are dropped. Errors name the path.
Result<ImageData> loadImage(const std::filesystem::path& path, ColorEncoding encoding,
                            const ImageLimits& limits = {});
// The same from a file's bytes; the format is told by its first bytes. `where` begins every error:
// "level.glb: image 2 \"sand\"".
Result<ImageData> decodeImage(std::span<const uint8_t> encoded, std::string_view where,
                              ColorEncoding encoding, const ImageLimits& limits = {});

// Writes 8-bit PNG; pixels: width * height * channels values, channels 1 (grey), 3 or 4. The
// values are stored as given. The file appears whole or not at all.
Status writePng(const std::filesystem::path& path, int width, int height, int channels,
                std::span<const uint8_t> pixels, RowOrder order = RowOrder::TopDown);

enum class ExrPrecision : uint8_t { Half, Float };

// Writes EXR (ZIP); values: width * height * channel_names.size(), interleaved. Names are those of
// the file: {"R", "G", "B"}, {"Z"} and so on. The file appears whole or not at all.
Status writeExr(const std::filesystem::path& path, int width, int height,
                std::span<const std::string> channel_names, std::span<const float> values,
                ExrPrecision precision = ExrPrecision::Float, RowOrder order = RowOrder::TopDown);

}  // namespace scree
