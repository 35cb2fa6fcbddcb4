// Grains made by code for the tests of the bake.
#pragma once

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>

#include "modules/impostors/impostors.h"

namespace scree::test {

// A closed sphere of latitude bands, moved by `place`; normals from the finished triangles.
inline MeshData globe(
    int bands, const std::function<vec3(vec3)>& place = [](vec3 p) { return p; }) {
  MeshData mesh;
  const int around = 2 * bands;
  for (int i = 0; i <= bands; ++i) {
    for (int j = 0; j < around; ++j) {
      const float a = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(bands);
      const float b =
          2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(around);
      const float ring = i == 0 || i == bands ? 0.0f : std::sin(a);
      mesh.vertices.push_back(
          {.position = place({ring * std::cos(b), -std::cos(a), -ring * std::sin(b)})});
    }
  }
  for (int i = 0; i < bands; ++i) {
    for (int j = 0; j < around; ++j) {
      const auto at = [&](int row, int column) {
        return static_cast<uint32_t>(row * around + column % around);
      };
      for (uint32_t k :
           {at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)})
        mesh.indices.push_back(k);
    }
  }
  computeNormals(mesh);
  computeTangents(mesh);
  return mesh;
}

// Triangles given by their corners, flat, no vertex shared.
inline MeshData soup(const std::vector<vec3>& corners) {
  MeshData mesh;
  for (size_t i = 0; i < corners.size(); ++i) {
    mesh.vertices.push_back({.position = corners[i]});
    mesh.indices.push_back(static_cast<uint32_t>(i));
  }
  computeNormals(mesh);
  computeTangents(mesh);
  return mesh;
}

inline MaterialData plain(vec3 color, float roughness = 0.5f, float metallic = 0) {
  return {.base_color = vec4(color, 1), .metallic = metallic, .roughness = roughness};
}

inline GrainMesh grainOf(MeshData mesh, MaterialData material = plain({0.5f, 0.4f, 0.3f})) {
  mesh.material = 0;
  GrainMesh grain;
  grain.parts.push_back(std::move(mesh));
  grain.materials.push_back(std::move(material));
  return grain;
}

inline GrainMesh model(const char* name) {
  Result<SceneData> scene =
      loadGltf(std::filesystem::path(SCREE_SOURCE_DIR) / "content/models" / name);
  if (!scene.ok()) return {};
  Result<GrainMesh> grain = grainFromScene(std::move(scene).value());
  return grain.ok() ? std::move(grain).value() : GrainMesh{};
}

}  // namespace scree::test
