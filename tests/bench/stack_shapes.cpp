// Meshes over the directions of a cube's grid.
#include "tests/bench/stack_shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

namespace scree::bench {
namespace {

constexpr int kCells = 10;  // along a cube's edge

// `place`: of a unit direction.
GrainMesh shaped(const std::function<vec3(vec3)>& place) {
  MeshData mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<uint32_t>(mesh.vertices.size());
      for (int j = 0; j <= kCells; ++j)
        for (int i = 0; i <= kCells; ++i) {
          vec3 p(0);
          p[axis] = side;
          p[(axis + 1) % 3] = 2 * static_cast<float>(i) / kCells - 1;
          p[(axis + 2) % 3] = side * (2 * static_cast<float>(j) / kCells - 1);
          mesh.vertices.push_back({.position = place(glm::normalize(p))});
        }
      for (uint32_t j = 0; j < kCells; ++j)
        for (uint32_t i = 0; i < kCells; ++i) {
          const uint32_t a = first + j * (kCells + 1) + i, b = a + 1, c = a + kCells + 1, d = c + 1;
          mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
        }
    }
  computeNormals(mesh);
  computeTangents(mesh);
  computeBounds(mesh);
  mesh.material = 0;
  GrainMesh grain;
  grain.parts.push_back(std::move(mesh));
  grain.materials.push_back({.base_color = vec4(0.6f, 0.5f, 0.4f, 1), .metallic = 0, .roughness = 0.8f});
  return grain;
}

}  // namespace

GrainMesh needle(float inner) {
  return shaped([inner](vec3 d) { return d * vec3(1, inner, inner); });
}

GrainMesh disc(float inner) {
  return shaped([inner](vec3 d) { return d * vec3(1, inner, 1); });
}

GrainMesh cube() {
  return shaped([](vec3 d) {
    const vec3 a = glm::abs(d);
    return d / (std::max({a.x, a.y, a.z}) * std::sqrt(3.0f));
  });
}

GrainMesh star(float inner) {
  return shaped([inner](vec3 d) {
    // Towards the 14 corners and faces of a cube; a spike is 25 degrees wide.
    const vec3 a = glm::abs(d);
    const float nearest = std::max({a.x, a.y, a.z, (a.x + a.y + a.z) / std::sqrt(3.0f)});
    const float up = std::clamp((nearest - 0.9f) / 0.1f, 0.0f, 1.0f);
    return d * (inner + (1 - inner) * up);
  });
}

double volumeOf(const GrainMesh& grain) {
  double six = 0;
  for (const MeshData& part : grain.parts)
    for (size_t k = 0; k + 2 < part.indices.size(); k += 3) {
      const auto corner = [&](size_t c) { return dvec3(part.vertices[part.indices[k + c]].position); };
      six += glm::dot(corner(0), glm::cross(corner(1), corner(2)));
    }
  return six / 6;
}

}  // namespace scree::bench
