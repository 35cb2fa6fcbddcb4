// The levels of a shape's mesh, by meshoptimizer.
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/assets/mesh_data.h"
#include "modules/lod/lod.h"
#include "modules/lod/surface_distance.h"

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

size_t indexCount(std::span<const MeshData> parts) {
  size_t count = 0;
  for (const MeshData& part : parts) count += part.indices.size();
  return count;
}

// About `share` of the part's triangles. From the finest level, so that errors do not add up; of whatever error:
// the router knows it.
MeshData simplified(const MeshData& part, double share, bool alone) {
  const size_t target = static_cast<size_t>(static_cast<double>(part.indices.size() / 3) * share) * 3;
  if (part.indices.empty() || share >= 1) return compacted(part, part.indices);
  std::vector<uint32_t> fewer(part.indices.size());
  fewer.resize(meshopt_simplify(fewer.data(), part.indices.data(), part.indices.size(),
                                &part.vertices.front().position.x, part.vertices.size(), sizeof(Vertex), target, 1.0f,
                                alone ? 0 : meshopt_SimplifyLockBorder, nullptr));
  return compacted(part, std::move(fewer));
}

}  // namespace

Status addLevels(MeshStore& meshes, GrainShape& shape, std::span<const MeshData> parts) {
  shape.levels.clear();
  if (parts.size() > rules::kMeshParts)
    return Error{fmt::format("shape \"{}\": {} parts of different materials; at most {} are allowed", shape.name,
                             parts.size(), rules::kMeshParts)};
  const size_t finest = indexCount(parts);
  if (finest == 0) return Error{fmt::format("shape \"{}\": no triangle", shape.name)};
  size_t before = 0;
  for (double share = 1; shape.levels.size() < rules::kMeshLevels; share *= kShare) {
    std::vector<MeshData> level;
    for (const MeshData& part : parts) level.push_back(simplified(part, share, parts.size() == 1));
    const size_t count = indexCount(level);
    // What cannot lose a third of its triangles is not worth another list.
    if (before > 0 && (count < 3 * kFewTriangles || 3 * count > 2 * before)) break;
    before = count;
    // The simplifier's own estimate of the error is not a bound.
    const double off = shape.levels.empty() ? 0 : surfaceDistance(parts, level);
    shape.levels.push_back({meshes.add(shape.name, level), static_cast<float>(off) / shape.outer_radius});
  }
  return Done{};
}

}  // namespace scree
