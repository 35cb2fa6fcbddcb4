// Reading of .gltf and .glb containers into JSON.
#include "engine/assets/gltf_document.h"

#include <fmt/format.h>

#include <cstring>

#include "engine/core/file.h"
#include "engine/core/json_depth.h"

namespace scree::gltf {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr uint32_t kGlbMagic = 0x46546c67;   // "glTF"
constexpr uint32_t kJsonChunk = 0x4e4f534a;  // "JSON"
constexpr uint32_t kBinChunk = 0x004e4942;   // "BIN"

uint32_t word(const std::vector<uint8_t>& bytes, size_t at) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

struct Chunks {
  std::string_view text;
  size_t binary_at = 0;
  size_t binary_size = 0;
  bool has_binary = false;
};

// https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#binary-gltf-layout
Result<Chunks> splitGlb(const std::string& file, const std::vector<uint8_t>& bytes) {
  if (bytes.size() < 20)
    return Error{
        fmt::format("{}: GLB header: {} bytes; at least 20 are needed", file, bytes.size())};
  if (word(bytes, 4) != 2)
    return Error{fmt::format("{}: GLB header: version = {}; only 2 is read", file, word(bytes, 4))};
  const uint64_t length = word(bytes, 8);
  if (length != bytes.size())
    return Error{fmt::format("{}: GLB header: length = {}; the file has {} bytes", file, length,
                             bytes.size())};
  Chunks chunks;
  for (uint64_t at = 12, index = 0; at < length; ++index) {
    if (length - at < 8)
      return Error{fmt::format("{}: GLB chunk {}: header cut off at byte {}", file, index, at)};
    const uint64_t size = word(bytes, at);
    const uint32_t type = word(bytes, at + 4);
    if (size > length - at - 8)
      return Error{fmt::format("{}: GLB chunk {}: length = {}; {} bytes are left in the file", file,
                               index, size, length - at - 8)};
    if (index == 0 && type != kJsonChunk)
      return Error{fmt::format("{}: GLB chunk 0: type = {:#010x}; must be JSON ({:#010x})", file,
                               type, kJsonChunk)};
    if (index == 0) {
      chunks.text = {reinterpret_cast<const char*>(bytes.data()) + at + 8, size};
    } else if (index == 1 && type == kBinChunk) {
      chunks.binary_at = at + 8;
      chunks.binary_size = size;
      chunks.has_binary = true;
    }
    at += 8 + size;
  }
  return chunks;
}

// The parser and the destructor of the JSON library survive any depth; those who walk the tree by
// recursion do not.
}  // namespace

Result<Document> readDocument(const fs::path& path, const GltfLimits& limits) {
  const std::string file = path.string();
  Result<std::vector<uint8_t>> read = readBytes(path, limits.max_file_bytes);
  if (!read.ok()) return read.takeError();
  const std::vector<uint8_t>& bytes = *read;
  if (bytes.empty()) return Error{fmt::format("{}: empty file; a glTF 2.0 file is needed", file)};

  Document document;
  document.path = path;
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (bytes.size() >= 4 && word(bytes, 0) == kGlbMagic) {
    Result<Chunks> chunks = splitGlb(file, bytes);
    if (!chunks.ok()) return chunks.takeError();
    text = chunks->text;
    document.has_binary = chunks->has_binary;
    const auto begin = bytes.begin() + static_cast<ptrdiff_t>(chunks->binary_at);
    document.binary.assign(begin, begin + static_cast<ptrdiff_t>(chunks->binary_size));
  } else if (path.extension() == ".glb") {
    return Error{fmt::format("{}: GLB header: magic is not 'glTF'", file)};
  }
  if (const size_t at = findTooDeep(text, limits.max_json_depth); at != std::string_view::npos)
    return Error{fmt::format("{}: JSON: nested deeper than {} at byte {}", file,
                             limits.max_json_depth, at)};
  try {
    document.json = json::parse(text);
  } catch (const json::exception& error) {
    return Error{fmt::format("{}: JSON: {}", file, printable(error.what(), 200))};
  }
  return document;
}

int componentBytes(int64_t component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

int typeComponents(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  if (type == "MAT3") return 9;
  if (type == "MAT4") return 16;
  return 0;
}

std::string printable(std::string_view text, size_t longest) {
  std::string line;
  for (char c : text.substr(0, longest)) {
    const auto byte = static_cast<unsigned char>(c);
    line += byte < 0x20 || byte == 0x7f ? ' ' : c;
  }
  if (text.size() > longest) line += "...";
  return line;
}

std::string objectName(std::string_view kind, size_t index, const json& object) {
  std::string name = fmt::format("{} {}", kind, index);
  if (const auto found = object.find("name"); found != object.end() && found->is_string())
    name += fmt::format(" \"{}\"", printable(found->get_ref<const std::string&>()));
  return name;
}

std::string valueText(const json& value) {
  if (value.is_array() && value.size() > 16) return fmt::format("array of {}", value.size());
  if (value.is_object()) return fmt::format("object of {}", value.size());
  return printable(value.dump(-1, ' ', false, json::error_handler_t::replace), 80);
}

}  // namespace scree::gltf
