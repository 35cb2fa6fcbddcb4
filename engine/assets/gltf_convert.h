// Steps from a checked document to scene data. Private to assets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/assets/gltf.h"
#include "engine/assets/gltf_document.h"
#include "engine/assets/tinygltf.h"

namespace scree::gltf {

// Runs tinygltf over a document that checkDocument and readResources have passed. Images are kept
// encoded in Image::image. The document's buffers and images are moved out of it.
Result<tinygltf::Model> parseModel(Document& document);

// All elements of an accessor, component after component; normalised integers become [-1, 1] or
// [0, 1], missing buffer views zeros. `where` begins errors.
Result<std::vector<float>> readFloats(const tinygltf::Model& model, int accessor,
                                      const std::string& where);
Result<std::vector<uint32_t>> readIndices(const tinygltf::Model& model, int accessor,
                                          const std::string& where);

// Appends to scene; `ranges` receives the first mesh and the number of meshes of each glTF mesh.
struct MeshRange {
  int first = -1;
  int count = 0;
};
Status convertMeshes(const tinygltf::Model& model, const GltfLimits& limits, SceneData& scene,
                     std::vector<MeshRange>& ranges);
Status convertMaterials(const tinygltf::Model& model, const GltfLimits& limits, SceneData& scene);
Status convertNodes(const tinygltf::Model& model, const Document& document,
                    const GltfLimits& limits, const std::vector<MeshRange>& ranges,
                    SceneData& scene);

}  // namespace scree::gltf
