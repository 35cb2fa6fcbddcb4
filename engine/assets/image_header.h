// What an image file claims about itself, read before a decoder gets it. Private to assets.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "engine/core/result.h"

namespace scree {

struct ImageHeader {
  const char* format = "";     // "PNG", for messages
  const char* extension = "";  // "png", for OpenImageIO
  bool is_float = false;
  int64_t width = 0;
  int64_t height = 0;
};

// Tells PNG, JPEG and single-part, flat EXR by their first bytes and finds the claimed size.
Result<ImageHeader> readImageHeader(std::span<const uint8_t> encoded, std::string_view where);

}  // namespace scree
