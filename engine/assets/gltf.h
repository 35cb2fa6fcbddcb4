// glTF 2.0 (.gltf and .glb) into plain data: meshes, materials, images, nodes, cameras, lights.
//
// The loader trusts nothing: sizes, counts, indices, strides, ranges, numbers and paths are checked
// before use, and the first fault ends the load with one line (file, object, field, value, what is
// allowed). What it does not draw (animations, skins, morph targets, points and lines) is left out
// with one warning a kind; a required extension it does not know is an error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/assets/image.h"
#include "engine/assets/mesh_data.h"
#include "engine/core/math.h"
#include "engine/core/result.h"

namespace scree {

// Above these a file is refused. They bound memory to a few times max_file_bytes.
struct GltfLimits {
  uint64_t max_file_bytes = uint64_t{1} << 29;   // a file and each buffer beside it
  uint64_t max_total_bytes = uint64_t{1} << 30;  // all buffers; all image files; all decoded images
  int max_json_depth = 64;
  uint32_t max_objects = 1u << 20;   // entries in any one array of the document
  uint32_t max_vertices = 1u << 24;  // all primitives together, after expansion
  uint32_t max_indices = 1u << 26;   // all primitives together, after expansion
  int max_node_depth = 256;
  double max_coordinate = 1e9;  // absolute value of positions and translations, m
  ImageLimits image;
};

enum class TextureWrap : uint8_t { Repeat, MirroredRepeat, ClampToEdge };

// An image as a material uses it.
struct TextureUse {
  int image = -1;  // index into SceneData::images; -1: none
  TextureWrap wrap_u = TextureWrap::Repeat;
  TextureWrap wrap_v = TextureWrap::Repeat;
  bool nearest = false;  // magnification without filtering
};

enum class AlphaMode : uint8_t { Opaque, Mask, Blend };

// Metallic-roughness material of glTF 2.0; a factor multiplies its texture.
struct MaterialData {
  std::string name;
  vec4 base_color{1};   // linear, a = opacity
  float metallic = 1;   // texture's B channel
  float roughness = 1;  // texture's G channel; perceptual: alpha = roughness^2
  vec3 emissive{0};     // linear radiance: emissiveFactor * KHR_materials_emissive_strength
  float normal_scale = 1;
  TextureUse base_color_map;          // sRGB
  TextureUse metallic_roughness_map;  // linear
  TextureUse normal_map;              // linear, +Y up
  TextureUse emissive_map;            // sRGB
  AlphaMode alpha_mode = AlphaMode::Opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
};

struct CameraData {
  std::string name;
  float fov_y_rad = 0;  // (0, pi)
  float near_m = 0;
};

// KHR_lights_punctual; shines along -Z of its node.
struct LightData {
  enum class Kind : uint8_t { Directional, Point, Spot };
  std::string name;
  Kind kind = Kind::Directional;
  vec3 color{1};             // linear
  float intensity = 1;       // lux (directional), candela (point, spot)
  float range_m = 0;         // 0: unlimited
  float inner_cone_rad = 0;  // half-angles
  float outer_cone_rad = 0.785398163f;
};

// A node with its world placement: parents applied, hierarchy dropped.
struct NodeData {
  std::string name;
  int index = 0;      // in the file
  dvec3 position{0};  // m
  quat rotation{1, 0, 0, 0};
  vec3 scale{1};        // mirrored nodes have one negative factor, in x
  int first_mesh = -1;  // its primitives: meshes[first_mesh ... first_mesh + mesh_count)
  int mesh_count = 0;
  int camera = -1;
  int light = -1;
  int parent = -1;        // index into SceneData::nodes
  nlohmann::json extras;  // null if none
};

// The default scene of a file. Every index in it is valid.
struct SceneData {
  std::filesystem::path path;
  std::vector<MeshData> meshes;  // one a primitive, those of one glTF mesh side by side
  std::vector<MaterialData> materials;
  std::vector<ImageData> images;  // only those that a material uses; one a use as sRGB or linear
  std::vector<NodeData> nodes;    // parents before children
  std::vector<CameraData> cameras;
  std::vector<LightData> lights;
};

// Reads the default scene (or the first; with no scene, all root nodes). Files beside the .gltf are
// read from its folder only. A rotation under a non-uniform scale (shear) has no position, rotation
// and scale: such nodes are refused.
Result<SceneData> loadGltf(const std::filesystem::path& path, const GltfLimits& limits = {});

}  // namespace scree
