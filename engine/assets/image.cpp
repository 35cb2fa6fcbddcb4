// Reading and writing of images through OpenImageIO.
#include "engine/assets/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "engine/assets/image_header.h"
#include "engine/core/file.h"

namespace scree {
namespace fs = std::filesystem;
namespace {

// OpenImageIO's messages on one line.
std::string oneLine(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20; }, ' ');
  return text.empty() ? "not readable" : text;
}

template <class T>
void flipRows(std::vector<T>& pixels, int height) {
  const size_t row = pixels.size() / static_cast<size_t>(height);
  for (int y = 0; y < height / 2; ++y)
    std::swap_ranges(pixels.begin() + static_cast<ptrdiff_t>(row) * y,
                     pixels.begin() + static_cast<ptrdiff_t>(row) * (y + 1),
                     pixels.end() - static_cast<ptrdiff_t>(row) * (y + 1));
}

Status checkSize(std::string_view where, int width, int height, int channels, size_t given) {
  if (width < 1 || height < 1 || channels < 1)
    return Error{fmt::format("{}: size = {}x{}, channels = {}; must be at least 1", where, width,
                             height, channels)};
  const uint64_t wanted = static_cast<uint64_t>(width) * static_cast<uint64_t>(height) *
                          static_cast<uint64_t>(channels);
  if (given != wanted)
    return Error{fmt::format("{}: pixels: {} values; {}x{} with {} channels need {}", where, given,
                             width, height, channels, wanted)};
  return Done{};
}

Status write(const fs::path& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
             const void* pixels) {
  const auto refuse = [&](const std::string& why) {
    return Error{fmt::format("{}: cannot write: {}", path.string(), oneLine(why)),
                 ErrorKind::Failure};
  };
  // Encoded in memory: OpenImageIO's PNG writer does not notice a full disk.
  OIIO::Filesystem::IOVecOutput encoded;
  auto output = OIIO::ImageOutput::create(path.string());
  if (!output) return refuse(OIIO::geterror());
  output->set_ioproxy(&encoded);
  if (!output->open(path.string(), spec)) return refuse(output->geterror());
  const bool written = output->write_image(type, pixels);
  const std::string error = output->geterror();
  if (!output->close() || !written) return refuse(written ? output->geterror() : error);
  const std::vector<unsigned char>& bytes = encoded.buffer();
  return writeFile(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

Result<ImageData> decodeImage(std::span<const uint8_t> encoded, std::string_view where,
                              ColorEncoding encoding, const ImageLimits& limits) {
  if (encoded.size() > limits.max_file_bytes)
    return Error{fmt::format("{}: {} bytes; at most {} are read", where, encoded.size(),
                             limits.max_file_bytes)};
  Result<ImageHeader> header = readImageHeader(encoded, where);
  if (!header.ok()) return header.takeError();
  const auto refuse_size = [&](int64_t width, int64_t height) {
    return Error{fmt::format("{}: size = {}x{}; at most {} a side and {} pixels are read", where,
                             width, height, limits.max_side, limits.max_pixels)};
  };
  const auto fits = [&](int64_t width, int64_t height) {
    return width >= 1 && height >= 1 && width <= limits.max_side && height <= limits.max_side &&
           static_cast<uint64_t>(width) * static_cast<uint64_t>(height) <= limits.max_pixels;
  };
  if (!fits(header->width, header->height)) return refuse_size(header->width, header->height);

  OIIO::Filesystem::IOMemReader memory(const_cast<uint8_t*>(encoded.data()), encoded.size());
  OIIO::ImageSpec config;
  void* proxy = &memory;
  config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  config.attribute("oiio:UnassociatedAlpha", 1);
  const std::string name = std::string("memory.") + header->extension;
  auto input = OIIO::ImageInput::open(name, &config);
  if (!input)
    return Error{fmt::format("{}: {}: {}", where, header->format, oneLine(OIIO::geterror()))};
  const OIIO::ImageSpec& spec = input->spec();
  if (!fits(spec.width, spec.height) || spec.depth > 1) return refuse_size(spec.width, spec.height);

  ImageData image;
  image.width = spec.width;
  image.height = spec.height;
  image.channels = std::clamp(spec.nchannels, 1, 4);
  const size_t values = static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                        static_cast<size_t>(image.channels);
  bool read = false;
  if (header->is_float) {
    image.floats.resize(values);
    read = input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::FLOAT, image.floats.data());
  } else {
    image.encoding = encoding;
    image.bytes.resize(values);
    read = input->read_image(0, 0, 0, image.channels, OIIO::TypeDesc::UINT8, image.bytes.data());
  }
  const std::string error = input->geterror();
  input->close();
  // Some readers fill in what is missing and only note it: a picture that is half there is refused.
  if (!read || !error.empty())
    return Error{fmt::format("{}: {}: pixels: {}", where, header->format, oneLine(error))};
  return image;
}

Result<ImageData> loadImage(const fs::path& path, ColorEncoding encoding,
                            const ImageLimits& limits) {
  Result<std::vector<uint8_t>> bytes = readBytes(path, limits.max_file_bytes);
  if (!bytes.ok()) return bytes.takeError();
  Result<ImageData> image = decodeImage(*bytes, path.string(), encoding, limits);
  if (image.ok()) image->name = path.stem().string();
  return image;
}

Status writePng(const fs::path& path, int width, int height, int channels,
                std::span<const uint8_t> pixels, RowOrder order) {
  if (Status size = checkSize(path.string(), width, height, channels, pixels.size()); !size.ok())
    return size;
  if (channels == 2 || channels > 4)
    return Error{fmt::format("{}: channels = {}; must be 1, 3 or 4", path.string(), channels)};
  if (path.extension() != ".png")
    return Error{fmt::format("{}: the name must end in .png", path.string())};
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("png:compressionLevel", 6);
  if (order == RowOrder::TopDown) return write(path, spec, OIIO::TypeDesc::UINT8, pixels.data());
  std::vector<uint8_t> flipped(pixels.begin(), pixels.end());
  flipRows(flipped, height);
  return write(path, spec, OIIO::TypeDesc::UINT8, flipped.data());
}

Status writeExr(const fs::path& path, int width, int height,
                std::span<const std::string> channel_names, std::span<const float> values,
                ExrPrecision precision, RowOrder order) {
  const int channels = static_cast<int>(channel_names.size());
  if (Status size = checkSize(path.string(), width, height, channels, values.size()); !size.ok())
    return size;
  if (path.extension() != ".exr")
    return Error{fmt::format("{}: the name must end in .exr", path.string())};
  OIIO::ImageSpec spec(
      width, height, channels,
      precision == ExrPrecision::Half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  spec.channelnames.assign(channel_names.begin(), channel_names.end());
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", "Linear");
  if (order == RowOrder::TopDown) return write(path, spec, OIIO::TypeDesc::FLOAT, values.data());
  std::vector<float> flipped(values.begin(), values.end());
  flipRows(flipped, height);
  return write(path, spec, OIIO::TypeDesc::FLOAT, flipped.data());
}

}  // namespace scree
