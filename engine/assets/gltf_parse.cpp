// The one translation unit that contains tinygltf. It sees only what we hand to it: a document
// whose uris are replaced by keys, and callbacks that answer these keys from memory.
#define TINYGLTF_IMPLEMENTATION
#include "engine/assets/tinygltf.h"

#include <fmt/format.h>

#include <charconv>

#include "engine/assets/gltf_convert.h"
#include "engine/core/log.h"

namespace scree::gltf {
using nlohmann::json;
namespace {

constexpr std::string_view kBufferKey = "buffer/";
constexpr std::string_view kImageKey = "image/";

std::vector<uint8_t>* lookUp(std::string_view key, void* user) {
  auto& document = *static_cast<Document*>(user);
  const auto entry = [&](std::string_view prefix, std::vector<std::vector<uint8_t>>& entries) {
    size_t index = entries.size();
    if (key.starts_with(prefix))
      std::from_chars(key.data() + prefix.size(), key.data() + key.size(), index);
    return index < entries.size() ? &entries[index] : nullptr;
  };
  if (auto* found = entry(kBufferKey, document.buffers)) return found;
  return entry(kImageKey, document.images);
}

bool exists(const std::string& key, void* user) {
  return lookUp(key, user) != nullptr;
}
std::string expand(const std::string& key, void*) {
  return key;
}
bool read(std::vector<unsigned char>* out, std::string*, const std::string& key, void* user) {
  std::vector<uint8_t>* bytes = lookUp(key, user);
  if (bytes == nullptr) return false;
  *out = std::move(*bytes);
  return true;
}
bool refuseWrite(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

// Decoding waits until it is known whether a material reads the image as sRGB or linear.
bool keepEncoded(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                 const unsigned char* bytes, int size, void*) {
  image->image.assign(bytes, bytes + size);
  return true;
}

json withKeys(const Document& document) {
  json copy = document.json;
  const auto replace = [&](const char* section, std::string_view prefix, bool every) {
    if (!copy.contains(section)) return;
    size_t index = 0;
    for (json& entry : copy[section]) {
      if (every || entry.contains("uri")) entry["uri"] = fmt::format("{}{}", prefix, index);
      ++index;
    }
  };
  replace("buffers", kBufferKey, true);
  replace("images", kImageKey, false);
  for (const char* unread : {"skins", "animations"}) copy.erase(unread);
  return copy;
}

}  // namespace

Result<tinygltf::Model> parseModel(Document& document) {
  const std::string file = document.path.string();
  for (const char* unread : {"skins", "animations"})
    if (const auto found = document.json.find(unread);
        found != document.json.end() && !found->empty())
      logWarning("{}: {} are not read", file, unread);

  tinygltf::TinyGLTF parser;
  parser.SetImageLoader(keepEncoded, nullptr);
  parser.SetFsCallbacks({exists, expand, read, refuseWrite, &document});
  tinygltf::Model model;
  std::string error, warning;
  bool parsed = false;
  try {
    const std::string text = withKeys(document).dump();
    if (text.size() > std::numeric_limits<unsigned>::max())
      return Error{fmt::format("{}: JSON: {} bytes are too many", file, text.size())};
    parsed = parser.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                        static_cast<unsigned>(text.size()), "", 0);
  } catch (const std::exception& thrown) {
    error = thrown.what();
  }
  if (!parsed) return Error{fmt::format("{}: {}", file, printable(error, 200))};
  // tinygltf drops what it does not understand; then indices would name the wrong objects.
  for (const char* section :
       {"buffers", "bufferViews", "accessors", "materials", "meshes", "nodes"}) {
    const auto found = document.json.find(section);
    const size_t wanted = found == document.json.end() ? 0 : found->size();
    const std::string_view name = section;
    const size_t got = name == "buffers"       ? model.buffers.size()
                       : name == "bufferViews" ? model.bufferViews.size()
                       : name == "accessors"   ? model.accessors.size()
                       : name == "materials"   ? model.materials.size()
                       : name == "meshes"      ? model.meshes.size()
                                               : model.nodes.size();
    if (got != wanted)
      return Error{fmt::format("{}: {}: {} of {} could be read", file, section, got, wanted)};
  }
  return model;
}

}  // namespace scree::gltf
