// Sizes claimed by PNG, JPEG and EXR headers. A decoder may take memory for them before it finds
// that the pixels are missing (OpenEXR: 8 bytes a row), so they are judged here first.
#include "engine/assets/image_header.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string>

namespace scree {
namespace {

using Bytes = std::span<const uint8_t>;

bool startsWith(Bytes bytes, std::initializer_list<int> magic) {
  size_t at = 0;
  for (int byte : magic)
    if (at >= bytes.size() || bytes[at++] != byte) return false;
  return true;
}

uint32_t bigEndian(Bytes bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

int64_t littleEndian(Bytes bytes, size_t at) {
  int32_t value;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

constexpr std::array<uint32_t, 256> kCrcTable = [] {
  std::array<uint32_t, 256> table{};
  for (uint32_t n = 0; n < 256; ++n) {
    uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320u ^ c >> 1 : c >> 1;
    table[n] = c;
  }
  return table;
}();

// Annex D of the PNG specification (ISO/IEC 15948).
uint32_t crc32(Bytes bytes) {
  uint32_t c = 0xffffffffu;
  for (uint8_t byte : bytes) c = kCrcTable[(c ^ byte) & 0xff] ^ c >> 8;
  return c ^ 0xffffffffu;
}

// Walks all chunks before libpng sees them: it writes its own lines to standard error.
Result<ImageHeader> readPng(Bytes bytes, std::string_view where) {
  if (bytes.size() < 33 || std::memcmp(bytes.data() + 12, "IHDR", 4) != 0)
    return Error{fmt::format("{}: PNG: header: the IHDR chunk is missing", where)};
  bool ended = false;
  for (size_t at = 8; !ended;) {
    if (bytes.size() - at < 12)
      return Error{
          fmt::format("{}: PNG: pixels: cut off at byte {}, before the IEND chunk", where, at)};
    const uint64_t length = bigEndian(bytes, at, 4);
    if (length > bytes.size() - at - 12)
      return Error{
          fmt::format("{}: PNG: pixels: the chunk at byte {} has length = {}; {} bytes are "
                      "left in the file",
                      where, at, length, bytes.size() - at - 12)};
    if (crc32(bytes.subspan(at + 4, length + 4)) != bigEndian(bytes, at + 8 + length, 4))
      return Error{
          fmt::format("{}: PNG: pixels: the chunk at byte {} is damaged (CRC)", where, at)};
    ended = std::memcmp(bytes.data() + at + 4, "IEND", 4) == 0;
    at += 12 + length;
  }
  return ImageHeader{"PNG", "png", false, bigEndian(bytes, 16, 4), bigEndian(bytes, 20, 4)};
}

// Walks the segments to the frame header (SOF); ITU T.81, B.1.1.
Result<ImageHeader> readJpeg(Bytes bytes, std::string_view where) {
  for (size_t at = 2; at + 4 <= bytes.size();) {
    if (bytes[at] != 0xff)
      return Error{fmt::format("{}: JPEG: marker: missing at byte {}", where, at)};
    const int marker = bytes[at + 1];
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    const bool frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    const size_t length = bigEndian(bytes, at + 2, 2);
    if (length < 2)
      return Error{
          fmt::format("{}: JPEG: segment length = {} at byte {}; at least 2", where, length, at)};
    if (frame) {
      if (at + 9 > bytes.size()) break;
      return ImageHeader{"JPEG", "jpg", false, bigEndian(bytes, at + 7, 2),
                         bigEndian(bytes, at + 5, 2)};
    }
    if (marker == 0xda || marker == 0xd9) break;
    at += 2 + length;
  }
  return Error{fmt::format("{}: JPEG: header: the frame header (SOF) is missing", where)};
}

// Attributes: name, type (both end in NUL), size, value; an empty name ends them.
Result<ImageHeader> readExr(Bytes bytes, std::string_view where) {
  const auto refuse = [&](std::string_view what) {
    return Error{fmt::format("{}: EXR: header: {}", where, what)};
  };
  if (bytes.size() < 9) return refuse("cut off");
  const uint8_t flags = bytes[5];
  if (flags & 0x08) return refuse("deep pixels are not read");
  if (flags & 0x10) return refuse("multi-part files are not read");
  const auto text = [&](size_t& at) {
    const size_t begin = at;
    while (at < bytes.size() && bytes[at] != 0) ++at;
    std::string found(reinterpret_cast<const char*>(bytes.data()) + begin, at - begin);
    ++at;
    return found;
  };
  bool tiles_fit = true;
  int64_t window[4] = {};
  bool found = false;
  for (size_t at = 8; at < bytes.size();) {
    const std::string name = text(at);
    if (name.empty()) break;
    const std::string type = text(at);
    if (at + 4 > bytes.size()) return refuse("cut off");
    const int64_t size = littleEndian(bytes, at);
    at += 4;
    if (size < 0 || static_cast<uint64_t>(size) > bytes.size() - at)
      return refuse(
          fmt::format("size of an attribute = {}; {} bytes are left", size, bytes.size() - at));
    if (name == "dataWindow" && type == "box2i" && size == 16) {
      for (size_t i = 0; i < 4; ++i) window[i] = littleEndian(bytes, at + i * 4);
      found = true;
    }
    if (name == "tiles" && size >= 8)
      tiles_fit = littleEndian(bytes, at) >= 8 && littleEndian(bytes, at + 4) >= 8;
    at += static_cast<size_t>(size);
  }
  if (!found) return refuse("dataWindow is missing");
  if (!tiles_fit) return refuse("tiles are smaller than 8 pixels");
  return ImageHeader{"EXR", "exr", true, window[2] - window[0] + 1, window[3] - window[1] + 1};
}

}  // namespace

Result<ImageHeader> readImageHeader(Bytes encoded, std::string_view where) {
  if (encoded.empty())
    return Error{fmt::format("{}: content: empty; PNG, JPEG or EXR is needed", where)};
  if (startsWith(encoded, {0x89, 'P', 'N', 'G', 0x0d, 0x0a, 0x1a, 0x0a}))
    return readPng(encoded, where);
  if (startsWith(encoded, {0xff, 0xd8, 0xff})) return readJpeg(encoded, where);
  if (startsWith(encoded, {0x76, 0x2f, 0x31, 0x01})) return readExr(encoded, where);
  return Error{fmt::format("{}: content: neither PNG, JPEG nor EXR by its first bytes", where)};
}

}  // namespace scree
