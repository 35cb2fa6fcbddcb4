// The levels of a shape's mesh, by meshoptimizer.
#include <meshoptimizer.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/assets/mesh_data.h"
#include "engine/assets/nearest_on_triangle.h"
#include "modules/lod/lod.h"

namespace scree {
namespace {

// Triangles of a level / of the one before; and below how many no further level is worth its list.
constexpr float kShare = 0.3f;
constexpr size_t kFewTriangles = 8;

MeshData compacted(const MeshData& mesh, std::vector<uint32_t> indices) {
  MeshData level;
  level.name = mesh.name;
  level.material = mesh.material;
  std::vector<uint32_t> place(mesh.vertices.size());
  meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), mesh.vertices.size());
  const size_t used =
      meshopt_optimizeVertexFetchRemap(place.data(), indices.data(), indices.size(), mesh.vertices.size());
  level.vertices.resize(used);
  level.indices.resize(indices.size());
  meshopt_remapVertexBuffer(level.vertices.data(), mesh.vertices.data(), mesh.vertices.size(), sizeof(Vertex),
                            place.data());
  meshopt_remapIndexBuffer(level.indices.data(), indices.data(), indices.size(), place.data());
  computeBounds(level);
  return level;
}

double distanceTo(const MeshData& mesh, dvec3 p) {
  double least = 1e300;
  for (size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
    const dvec3 a(mesh.vertices[mesh.indices[k]].position), b(mesh.vertices[mesh.indices[k + 1]].position),
        c(mesh.vertices[mesh.indices[k + 2]].position);
    if (glm::length(glm::cross(b - a, c - a)) < 1e-30) continue;
    const dvec3 off = p - nearestOnTriangle(p, a, b, c).point;
    least = std::min(least, glm::dot(off, off));
  }
  return std::sqrt(least);
}

// Largest distance of one surface's corners and middles of triangles from the other, of some spread over it if
// they are many.
double farthest(const MeshData& from, const MeshData& to) {
  constexpr size_t kPoints = 1000;
  const size_t stride = 3 * std::max<size_t>(1, 4 * from.indices.size() / 3 / kPoints);
  double most = 0;
  for (size_t k = 0; k + 2 < from.indices.size(); k += stride) {
    dvec3 sum(0);
    for (size_t corner = 0; corner < 3; ++corner) {
      const dvec3 p(from.vertices[from.indices[k + corner]].position);
      sum += p;
      most = std::max(most, distanceTo(to, p));
    }
    most = std::max(most, distanceTo(to, sum / 3.0));
  }
  return most;
}

}  // namespace

void addLevels(MeshStore& meshes, GrainShape& shape, const MeshData& mesh, uint32_t material) {
  shape.levels.clear();
  const float* positions = &mesh.vertices.front().position.x;
  std::vector<uint32_t> indices = mesh.indices;
  while (true) {
    MeshData level = compacted(mesh, indices);
    level.material = static_cast<int>(material);
    // The simplifier's own estimate is not a bound.
    const double off = shape.levels.empty() ? 0 : std::max(farthest(mesh, level), farthest(level, mesh));
    shape.levels.push_back({meshes.add(level), static_cast<float>(off) / shape.outer_radius});
    if (shape.levels.size() == rules::kMeshLevels) return;
    const size_t target = static_cast<size_t>(static_cast<float>(indices.size() / 3) * kShare) * 3;
    if (target < 3 * kFewTriangles) return;
    // From the finest, so that errors do not add up; of whatever error: the router knows it.
    std::vector<uint32_t> fewer(mesh.indices.size());
    fewer.resize(meshopt_simplify(fewer.data(), mesh.indices.data(), mesh.indices.size(), positions,
                                  mesh.vertices.size(), sizeof(Vertex), target, 1.0f, 0, nullptr));
    // What cannot lose a third of its triangles is not worth another list.
    if (fewer.empty() || 3 * fewer.size() > 2 * indices.size()) return;
    indices = std::move(fewer);
  }
}

}  // namespace scree
