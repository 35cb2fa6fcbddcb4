// Bytes of a glTF document's buffers and images: BIN chunk, data URIs, files beside the document.
#include <fmt/format.h>

#include <array>

#include "engine/assets/gltf_document.h"
#include "engine/core/file.h"

namespace scree::gltf {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

using Bytes = std::vector<uint8_t>;

constexpr std::array<int8_t, 256> kBase64 = [] {
  std::array<int8_t, 256> table{};
  table.fill(-1);
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < digits.size(); ++i)
    table[static_cast<unsigned char>(digits[i])] = static_cast<int8_t>(i);
  return table;
}();

Result<Bytes> decodeBase64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  Bytes bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t bits = 0;
  int held = 0;
  for (size_t at = 0; at < text.size(); ++at) {
    const int digit = kBase64[static_cast<unsigned char>(text[at])];
    if (digit < 0) return Error{fmt::format("byte {} of the base64 text is not base64", at)};
    bits = bits << 6 | static_cast<uint32_t>(digit);
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes.push_back(static_cast<uint8_t>(bits >> held & 0xff));
    }
  }
  return bytes;
}

// %20 and the like (RFC 3986); other characters stay.
std::string decodePercent(std::string_view text) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  };
  std::string decoded;
  for (size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '%' && at + 2 < text.size() && digit(text[at + 1]) >= 0 &&
        digit(text[at + 2]) >= 0) {
      decoded += static_cast<char>(digit(text[at + 1]) * 16 + digit(text[at + 2]));
      at += 2;
    } else {
      decoded += text[at];
    }
  }
  return decoded;
}

// A file below the document's folder, symbolic links followed; anything else is refused, so that a
// downloaded model cannot read the user's other files.
Result<fs::path> resolve(const fs::path& folder, std::string_view uri) {
  const std::string text = decodePercent(uri);
  if (text.empty()) return Error{"must not be empty"};
  if (text.find('\0') != std::string::npos) return Error{"holds a zero byte"};
  const size_t colon = text.find(':');
  if (colon != std::string::npos && text.find('/') > colon)
    return Error{"only data: URIs and relative paths are read"};
  const fs::path relative(text);
  if (relative.is_absolute()) return Error{"absolute paths are refused"};
  std::error_code code;
  const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, code);
  if (code) return Error{code.message()};
  const fs::path target = fs::weakly_canonical(root / relative, code);
  if (code) return Error{code.message()};
  const fs::path inside = target.lexically_relative(root);
  if (inside.empty() || *inside.begin() == ".." || inside == ".")
    return Error{"lies outside the file's folder"};
  return target;
}

Result<Bytes> readUri(const Document& document, const std::string& uri, uint64_t max_bytes) {
  constexpr std::string_view scheme = "data:";
  if (!uri.starts_with(scheme)) {
    Result<fs::path> path = resolve(document.path.parent_path(), uri);
    if (!path.ok()) return path.takeError();
    return readBytes(*path, max_bytes);
  }
  const size_t comma = uri.find(',');
  if (comma == std::string::npos) return Error{"data URI without a comma"};
  if (!std::string_view(uri).substr(0, comma).ends_with(";base64"))
    return Error{"data URI that is not base64"};
  return decodeBase64(std::string_view(uri).substr(comma + 1));
}

Status readBuffers(Document& document, const GltfLimits& limits) {
  const auto section = document.json.find("buffers");
  if (section == document.json.end()) return Done{};
  for (size_t i = 0; i < section->size(); ++i) {
    const json& buffer = (*section)[i];
    const auto length = buffer.at("byteLength").get<uint64_t>();
    const std::string where =
        fmt::format("{}: {}", document.path.string(), objectName("buffer", i, buffer));
    Bytes bytes;
    if (const auto uri = buffer.find("uri"); uri != buffer.end()) {
      Result<Bytes> read =
          readUri(document, uri->get_ref<const std::string&>(), limits.max_file_bytes);
      if (!read.ok())
        return Error{fmt::format("{}: uri = {}: {}", where, valueText(*uri), read.error())};
      bytes = std::move(*read);
    } else if (i == 0 && document.has_binary) {
      bytes = std::move(document.binary);
    } else {
      return Error{fmt::format(
          "{}: uri: missing; only buffer 0 of a .glb with a BIN chunk may leave it out", where)};
    }
    if (bytes.size() < length)
      return Error{
          fmt::format("{}: byteLength = {}; {} bytes are there", where, length, bytes.size())};
    bytes.resize(length);  // padding, or what lies behind
    document.buffers.push_back(std::move(bytes));
  }
  return Done{};
}

Status readImages(Document& document, const GltfLimits& limits) {
  const auto section = document.json.find("images");
  if (section == document.json.end()) return Done{};
  uint64_t total = 0;
  for (size_t i = 0; i < section->size(); ++i) {
    const json& image = (*section)[i];
    document.images.emplace_back();
    const auto uri = image.find("uri");
    if (uri == image.end()) continue;
    Result<Bytes> read =
        readUri(document, uri->get_ref<const std::string&>(), limits.image.max_file_bytes);
    const std::string where =
        fmt::format("{}: {}", document.path.string(), objectName("image", i, image));
    if (!read.ok())
      return Error{fmt::format("{}: uri = {}: {}", where, valueText(*uri), read.error())};
    total += read->size();
    if (total > limits.max_total_bytes)
      return Error{
          fmt::format("{}: uri: all images together pass {} bytes", where, limits.max_total_bytes)};
    document.images.back() = std::move(*read);
  }
  return Done{};
}

}  // namespace

Status readResources(Document& document, const GltfLimits& limits) {
  if (Status buffers = readBuffers(document, limits); !buffers.ok()) return buffers;
  return readImages(document, limits);
}

}  // namespace scree::gltf
