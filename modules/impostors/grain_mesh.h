// The mesh of a grain with its materials, as the bake reads it.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/assets/gltf.h"
#include "engine/core/result.h"

namespace scree {

struct GrainMesh {
  std::vector<MeshData> parts;  // in the grain's axes, any unit
  std::vector<MaterialData> materials;
  std::vector<ImageData> images;
};

// All meshes of a scene, each at its nodes' places; the file's axes become the grain's. Refuses a
// scene without a triangle.
Result<GrainMesh> grainFromScene(SceneData scene);

// Refuses what cannot be baked, in one line: indices, numbers that are not finite, no triangle,
// no extent, images of a wrong size.
Status checkGrain(const GrainMesh& grain);

// Of all that a bake reads: equal content, equal hash.
uint64_t contentHash(const GrainMesh& grain);

}  // namespace scree
