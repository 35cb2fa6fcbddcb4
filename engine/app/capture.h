// Captured frames as files: PNG (and EXR) a frame, and a contact sheet of all of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/frame/frame.h"

namespace scree {

class Capture {
 public:
  // Makes the folder. Errors name it.
  static Result<Capture> open(const std::filesystem::path& folder, bool exr);

  // Writes frame_<tick, six digits>.png from Frame::kOutput and, on demand, .exr from the linear
  // radiance of the first of `radiance_targets` that this frame wrote.
  Status add(const Frame& frame, uint64_t tick, std::span<const std::string> radiance_targets);

  // Writes contact_sheet.png: up to kMaxThumbnails frames, evenly spread, in rows.
  Status finish() const;
  size_t frameCount() const { return frame_count_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  static constexpr size_t kMaxThumbnails = 48;  // when full, every second one is dropped
  static constexpr int kThumbnailWidth = 320;   // pixels

  struct Thumbnail {
    ivec2 size;
    std::vector<uint8_t> rgb;  // bottom-up
  };
  std::filesystem::path folder_;
  bool exr_ = false;
  size_t frame_count_ = 0;
  size_t stride_ = 1;  // frames between thumbnails
  std::vector<Thumbnail> thumbnails_;
};

}  // namespace scree
