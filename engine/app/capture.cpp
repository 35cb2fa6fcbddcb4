// Reads the output back and writes it through OpenImageIO; thumbnails are box-filtered.
#include "engine/app/capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engine/assets/image.h"
#include "engine/gpu/readback.h"

namespace scree {
namespace fs = std::filesystem;
namespace {

// Averages the source pixels under each target pixel; `rgba` bottom-up, result RGB, same order.
std::vector<uint8_t> shrink(const std::vector<uint8_t>& rgba, ivec2 size, ivec2 target) {
  std::vector<uint8_t> rgb(static_cast<size_t>(target.x) * target.y * 3);
  for (int y = 0; y < target.y; ++y) {
    const int y0 = y * size.y / target.y, y1 = std::max(y0 + 1, (y + 1) * size.y / target.y);
    for (int x = 0; x < target.x; ++x) {
      const int x0 = x * size.x / target.x, x1 = std::max(x0 + 1, (x + 1) * size.x / target.x);
      std::array<uint32_t, 3> sum{};
      for (int v = y0; v < y1; ++v)
        for (int u = x0; u < x1; ++u)
          for (int c = 0; c < 3; ++c) sum[c] += rgba[(static_cast<size_t>(v) * size.x + u) * 4 + c];
      const uint32_t count = static_cast<uint32_t>((y1 - y0) * (x1 - x0));
      for (int c = 0; c < 3; ++c)
        rgb[(static_cast<size_t>(y) * target.x + x) * 3 + c] =
            static_cast<uint8_t>((sum[c] + count / 2) / count);
    }
  }
  return rgb;
}

}  // namespace

Result<Capture> Capture::open(const fs::path& folder, bool exr) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code || !fs::is_directory(folder))
    return Error{fmt::format("{}: cannot make the capture folder: {}", folder.string(),
                             code ? code.message() : "it is not a folder")};
  Capture capture;
  capture.folder_ = folder;
  capture.exr_ = exr;
  return capture;
}

Status Capture::add(const Frame& frame, uint64_t tick, std::span<const std::string> radiance_targets) {
  const gpu::Texture& output = frame.texture(Frame::kOutput);
  const ivec2 size = output.size();
  const std::vector<uint8_t> rgba = gpu::readBytes(output, 4);
  const fs::path stem = folder_ / fmt::format("frame_{:06}", tick);
  std::vector<uint8_t> rgb(static_cast<size_t>(size.x) * size.y * 3);
  for (size_t i = 0; i < rgb.size() / 3; ++i)
    for (size_t c = 0; c < 3; ++c) rgb[i * 3 + c] = rgba[i * 4 + c];
  if (Status status =
          writePng(stem.string() + ".png", size.x, size.y, 3, rgb, RowOrder::BottomUp);
      !status.ok())
    return status;
  const auto radiance_target =
      std::find_if(radiance_targets.begin(), radiance_targets.end(),
                   [&](const std::string& target) { return frame.hasContent(target); });
  if (exr_ && radiance_target != radiance_targets.end()) {
    const std::vector<float> radiance = gpu::readFloats(frame.texture(*radiance_target), 3);
    const std::array<std::string, 3> channels{"R", "G", "B"};
    if (Status status = writeExr(stem.string() + ".exr", size.x, size.y, channels, radiance,
                                 ExrPrecision::Float, RowOrder::BottomUp);
        !status.ok())
      return status;
  }

  if (frame_count_++ % stride_ != 0) return Done{};
  if (thumbnails_.size() == kMaxThumbnails) {
    for (size_t i = 1; i < kMaxThumbnails / 2; ++i) thumbnails_[i] = std::move(thumbnails_[2 * i]);
    thumbnails_.resize(kMaxThumbnails / 2);
    stride_ *= 2;
    if ((frame_count_ - 1) % stride_ != 0) return Done{};
  }
  const int width = std::min(kThumbnailWidth, size.x);
  const ivec2 small{width, std::max(1, size.y * width / size.x)};
  thumbnails_.push_back({small, shrink(rgba, size, small)});
  return Done{};
}

Status Capture::finish() const {
  if (thumbnails_.empty()) return Done{};
  ivec2 cell{0, 0};
  for (const Thumbnail& thumbnail : thumbnails_) cell = glm::max(cell, thumbnail.size);
  const int count = static_cast<int>(thumbnails_.size());
  int columns = 1;  // as many as rows, or one more
  while (columns * columns < count) ++columns;
  const int rows = (count + columns - 1) / columns;
  const ivec2 sheet = cell * ivec2{columns, rows};
  std::vector<uint8_t> rgb(static_cast<size_t>(sheet.x) * sheet.y * 3, 24);
  for (int i = 0; i < count; ++i) {
    const Thumbnail& thumbnail = thumbnails_[static_cast<size_t>(i)];
    const ivec2 corner{i % columns * cell.x, (rows - 1 - i / columns) * cell.y};
    for (int y = 0; y < thumbnail.size.y; ++y)
      std::copy_n(&thumbnail.rgb[static_cast<size_t>(y) * thumbnail.size.x * 3],
                  thumbnail.size.x * 3,
                  &rgb[(static_cast<size_t>(corner.y + y) * sheet.x + corner.x) * 3]);
  }
  return writePng(folder_ / "contact_sheet.png", sheet.x, sheet.y, 3, rgb, RowOrder::BottomUp);
}

}  // namespace scree
