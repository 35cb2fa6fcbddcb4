// Small glTF files made in a test: a document, its one buffer, and the ways to save them.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/assets/image.h"

namespace scree::test {

using nlohmann::json;
using Bytes = std::vector<uint8_t>;

// A new folder below the system's temporary folder, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "scree_assets_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void saveBytes(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}
inline void saveText(const std::filesystem::path& path, const std::string& text) {
  saveBytes(path, Bytes(text.begin(), text.end()));
}
inline Bytes readAll(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(stream), {});
}

inline std::string base64(const Bytes& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
constexpr int componentType() {
  if constexpr (std::is_same_v<T, int8_t>) return 5120;
  if constexpr (std::is_same_v<T, uint8_t>) return 5121;
  if constexpr (std::is_same_v<T, int16_t>) return 5122;
  if constexpr (std::is_same_v<T, uint16_t>) return 5123;
  if constexpr (std::is_same_v<T, uint32_t>) return 5125;
  return 5126;
}

// A .glb of any text and any bytes.
inline Bytes glbOf(std::string text, Bytes body) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  body.resize((body.size() + 3) / 4 * 4);
  Bytes file;
  const auto word = [&](size_t value) {
    for (int shift = 0; shift < 32; shift += 8)
      file.push_back(static_cast<uint8_t>(value >> shift & 0xff));
  };
  word(0x46546c67);
  word(2);
  word(12 + 8 + text.size() + 8 + body.size());
  word(text.size());
  word(0x4e4f534a);
  file.insert(file.end(), text.begin(), text.end());
  word(body.size());
  word(0x004e4942);
  file.insert(file.end(), body.begin(), body.end());
  return file;
}

struct GltfBuilder {
  json doc = {{"asset", {{"version", "2.0"}}}, {"buffers", json::array()}};
  Bytes bin;

  int add(const char* section, json entry) {
    doc[section].push_back(std::move(entry));
    return static_cast<int>(doc[section].size()) - 1;
  }

  // A buffer view over copied bytes, 4-byte aligned.
  int addView(const void* data, size_t bytes, json extra = json::object()) {
    bin.resize((bin.size() + 3) / 4 * 4);
    extra.update({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes}});
    const auto* begin = static_cast<const uint8_t*>(data);
    bin.insert(bin.end(), begin, begin + bytes);
    return add("bufferViews", std::move(extra));
  }
  int addView(const Bytes& bytes) { return addView(bytes.data(), bytes.size()); }

  // An accessor of all values; `type` "VEC3" has 3 components.
  template <class T>
  int addAccessor(const std::vector<T>& values, const char* type, json extra = json::object()) {
    const size_t components =
        std::strcmp(type, "SCALAR") == 0 ? 1 : static_cast<size_t>(type[3] - '0');
    extra.update({{"bufferView", addView(values.data(), values.size() * sizeof(T))},
                  {"componentType", componentType<T>()},
                  {"count", values.size() / components},
                  {"type", type}});
    return add("accessors", std::move(extra));
  }

  void setBuffer(json buffer) {
    buffer["byteLength"] = bin.size();
    doc["buffers"] = json::array({std::move(buffer)});
  }

  // Saved with the buffer in a file beside it, or as a data URI.
  void saveGltf(const std::filesystem::path& path, bool beside = false) {
    if (doc["buffers"].empty()) {
      if (beside) {
        saveBytes(path.parent_path() / "data.bin", bin);
        setBuffer({{"uri", "data.bin"}});
      } else {
        setBuffer({{"uri", "data:application/octet-stream;base64," + base64(bin)}});
      }
    }
    saveText(path, doc.dump());
  }
  Bytes glb() {
    if (doc["buffers"].empty()) setBuffer(json::object());
    return glbOf(doc.dump(), bin);
  }
  void saveGlb(const std::filesystem::path& path) { saveBytes(path, glb()); }
};

// 2x2 RGBA PNG: red, green (top), blue, half-transparent white (bottom).
inline Bytes smallPng(const TemporaryFolder& folder) {
  const Bytes pixels = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128};
  (void)writePng(folder / "small.png", 2, 2, 4, pixels).ok();
  return readAll(folder / "small.png");
}

// One of everything that is read: a textured, indexed, sparse quad with a material, a parent and a
// child node, a camera, a light.
inline GltfBuilder fullFile(const TemporaryFolder& folder) {
  GltfBuilder b;
  const int position =
      b.addAccessor<float>({-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1}, "VEC3", {{"name", "corners"}});
  const int normal = b.addAccessor<float>({0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, "VEC3");
  const int uv =
      b.addAccessor<uint8_t>({0, 0, 255, 0, 255, 255, 0, 255}, "VEC2", {{"normalized", true}});
  const int index = b.addAccessor<uint16_t>({0, 2, 1, 0, 3, 2}, "SCALAR");
  const std::vector<uint8_t> sparse_index = {2};
  const std::vector<float> sparse_value = {1, 0.5f, 1};
  b.doc["accessors"][position]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", b.addView(sparse_index)}, {"componentType", 5121}}},
      {"values", {{"bufferView", b.addView(sparse_value.data(), 12)}}}};
  const int image = b.add(
      "images",
      {{"bufferView", b.addView(smallPng(folder))}, {"mimeType", "image/png"}, {"name", "checks"}});
  const int sampler = b.add("samplers", {{"wrapS", 33071}, {"magFilter", 9728}});
  const int texture = b.add("textures", {{"source", image}, {"sampler", sampler}});
  b.add("materials",
        {{"name", "tiles"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {1, 0.5, 0.25, 1}},
           {"metallicFactor", 0.25},
           {"roughnessFactor", 0.75},
           {"baseColorTexture", {{"index", texture}}}}},
         {"normalTexture", {{"index", texture}, {"scale", 2}}},
         {"emissiveFactor", {0.5, 0, 0}},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.25},
         {"doubleSided", true},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}}}}});
  b.add("meshes",
        {{"name", "floor"},
         {"primitives",
          {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
            {"indices", index},
            {"material", 0}}}}});
  b.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.125}}}});
  b.doc["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_emissive_strength"};
  b.doc["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"},
       {"color", {1, 0.5, 0}},
       {"intensity", 100},
       {"range", 20},
       {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}};
  b.add("nodes", {{"name", "table"},
                  {"mesh", 0},
                  {"translation", {10, 0, 0}},
                  {"rotation", {0, 0.7071067811865476, 0, 0.7071067811865476}},
                  {"scale", {2, 2, 2}},
                  {"children", {1}},
                  {"extras", {{"artist", "nobody"}}}});
  b.add("nodes", {{"name", "eye"}, {"camera", 0}, {"translation", {0, 0, 1}}});
  b.add("nodes", {{"name", "lamp"},
                  {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                  {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1}}});
  b.add("scenes", {{"nodes", {0, 2}}});
  b.doc["scene"] = 0;
  return b;
}

}  // namespace scree::test
