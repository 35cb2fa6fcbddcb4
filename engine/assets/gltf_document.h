// A glTF file as checked JSON and bytes, before it is turned into scene data. Private to assets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/assets/gltf.h"
#include "engine/core/result.h"

namespace scree::gltf {

struct Document {
  std::filesystem::path path;
  nlohmann::json json;
  std::vector<uint8_t> binary;  // BIN chunk of a .glb
  bool has_binary = false;
  std::vector<std::vector<uint8_t>> buffers;  // bytes of each buffer, exactly its byteLength
  std::vector<std::vector<uint8_t>> images;   // encoded bytes of each image that has a uri
};

// Reads the file, takes a .glb apart, parses the JSON. Checks the container and the JSON's depth.
Result<Document> readDocument(const std::filesystem::path& path, const GltfLimits& limits);

// Checks types, numbers, enumerations, indices and ranges of everything that is used later. After
// it every index is valid and every accessor lies inside its buffer.
Status checkDocument(const Document& document, const GltfLimits& limits);

// Fills buffers and images: from the BIN chunk, data URIs, and files in the document's folder.
Status readResources(Document& document, const GltfLimits& limits);

// Bytes of one component (5120 ... 5126), 0 if unknown; components of a type ("VEC3"), 0 if
// unknown.
int componentBytes(int64_t component_type);
int typeComponents(std::string_view type);

// `mesh 3 "beast"`: how messages name an object; control characters and long names are cut.
std::string objectName(std::string_view kind, size_t index, const nlohmann::json& object);
std::string printable(std::string_view text, size_t longest = 64);
// A JSON value on one short line.
std::string valueText(const nlohmann::json& value);

}  // namespace scree::gltf
