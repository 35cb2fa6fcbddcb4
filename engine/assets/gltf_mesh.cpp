// glTF primitives to triangle meshes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/assets/gltf_convert.h"
#include "engine/core/log.h"

#include <glm/geometric.hpp>

namespace scree::gltf {
namespace {

struct Budget {
  uint64_t vertices;
  uint64_t indices;
};

// The accessor of an attribute, or -1.
int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

// Reads an attribute, checks every number, hands `components` floats a vertex to put(vertex,
// values).
Status readAttribute(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                     const char* name, size_t components, double most, const std::string& where,
                     const std::function<void(size_t, const float*)>& put) {
  const int accessor = attribute(primitive, name);
  if (accessor < 0) return Done{};
  Result<std::vector<float>> values =
      readFloats(model, accessor, fmt::format("{}: {}", where, name));
  if (!values.ok()) return values.takeError();
  for (size_t i = 0; i < values->size(); ++i) {
    const float value = (*values)[i];
    if (std::isfinite(value) && std::abs(value) <= most) continue;
    return Error{fmt::format("{}: {}[{}]: component {} = {}; must be finite and at most {} in size",
                             where, name, i / components, i % components, value, most)};
  }
  for (size_t i = 0; i * components < values->size(); ++i) put(i, values->data() + i * components);
  return Done{};
}

// Strips and fans become triangles (glTF 2.0, 3.7.2.1).
std::vector<uint32_t> asTriangles(const std::vector<uint32_t>& order, int mode) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return order;
  std::vector<uint32_t> triangles;
  for (size_t i = 0; i + 2 < order.size(); ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
      triangles.insert(triangles.end(), {order[i + 1], order[i + 2], order[0]});
    else
      triangles.insert(triangles.end(), {order[i], order[i + 1 + i % 2], order[i + 2 - i % 2]});
  }
  return triangles;
}

Status readTriangles(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                     const std::string& where, Budget& budget, MeshData& mesh) {
  std::vector<uint32_t> order;
  if (primitive.indices >= 0) {
    Result<std::vector<uint32_t>> read = readIndices(model, primitive.indices, where + ": indices");
    if (!read.ok()) return read.takeError();
    order = std::move(*read);
    for (size_t i = 0; i < order.size(); ++i)
      if (order[i] >= mesh.vertices.size())
        return Error{fmt::format("{}: indices[{}] = {}; POSITION has {} elements", where, i,
                                 order[i], mesh.vertices.size())};
  } else {
    order.resize(mesh.vertices.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>(i);
  }
  const bool list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  if (order.size() < 3 || (list && order.size() % 3 != 0))
    return Error{fmt::format("{}: {}: count = {}; must be {}", where,
                             primitive.indices >= 0 ? "indices" : "POSITION", order.size(),
                             list ? "a multiple of 3, not 0" : "at least 3")};
  const uint64_t count = list ? order.size() : (order.size() - 2) * 3;
  if (count > budget.indices)
    return Error{fmt::format("{}: indices: {} more pass the limit of the file", where, count)};
  budget.indices -= count;
  mesh.indices = asTriangles(order, primitive.mode);
  return Done{};
}

// Without normals a primitive is flat (glTF 2.0, 3.7.2.1): its triangles share no vertices.
void splitTriangles(MeshData& mesh) {
  std::vector<Vertex> vertices;
  vertices.reserve(mesh.indices.size());
  for (uint32_t& index : mesh.indices) {
    vertices.push_back(mesh.vertices[index]);
    index = static_cast<uint32_t>(vertices.size() - 1);
  }
  mesh.vertices = std::move(vertices);
}

// Unit normals; the zero ones are taken from the triangles.
void repairNormals(MeshData& mesh, const std::string& where) {
  size_t broken = 0;
  MeshData computed;
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    vec3& normal = mesh.vertices[i].normal;
    const float length = glm::length(normal);
    if (length > 1e-6f) {
      normal /= length;
      continue;
    }
    if (broken++ == 0) {
      computed = mesh;
      computeNormals(computed);
    }
    normal = computed.vertices[i].normal;
  }
  if (broken > 0) logWarning("{}: NORMAL: {} of length 0 are computed instead", where, broken);
}

void repairTangents(MeshData& mesh) {
  for (Vertex& vertex : mesh.vertices) {
    vec3 along(vertex.tangent);
    along -= vertex.normal * glm::dot(vertex.normal, along);
    const float length = glm::length(along);
    if (!(length > 1e-6f)) return computeTangents(mesh);
    vertex.tangent = vec4(along / length, vertex.tangent.w < 0 ? -1.0f : 1.0f);
  }
}

bool needsTangents(const tinygltf::Model& model, const tinygltf::Primitive& primitive) {
  return primitive.material >= 0 &&
         model.materials[static_cast<size_t>(primitive.material)].normalTexture.index >= 0;
}

Status convertPrimitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                        const GltfLimits& limits, const std::string& where, Budget& budget,
                        MeshData& mesh) {
  const size_t count = model.accessors[static_cast<size_t>(attribute(primitive, "POSITION"))].count;
  const auto take = [&](uint64_t vertices) {
    if (vertices > budget.vertices) return false;
    budget.vertices -= vertices;
    return true;
  };
  const auto full = [&](uint64_t vertices) {
    return Error{fmt::format("{}: POSITION: {} more vertices pass the limit of {} a file", where,
                             vertices, limits.max_vertices)};
  };
  if (!take(count)) return full(count);
  mesh.vertices.resize(count);
  mesh.material = primitive.material;
  auto& v = mesh.vertices;
  const auto read = [&](const char* name, size_t components, double most,
                        const std::function<void(size_t, const float*)>& put) {
    return readAttribute(model, primitive, name, components, most, where, put);
  };
  if (Status done = read("POSITION", 3, limits.max_coordinate,
                         [&](size_t i, const float* p) {
                           v[i].position = {p[0], p[1], p[2]};
                         });
      !done.ok())
    return done;
  if (Status done = readTriangles(model, primitive, where, budget, mesh); !done.ok()) return done;
  if (Status done = read("TEXCOORD_0", 2, 1e6,
                         [&](size_t i, const float* p) {
                           v[i].uv = {p[0], p[1]};
                         });
      !done.ok())
    return done;
  if (Status done = read("NORMAL", 3, 1e6,
                         [&](size_t i, const float* p) {
                           v[i].normal = {p[0], p[1], p[2]};
                         });
      !done.ok())
    return done;
  const bool has_normals = attribute(primitive, "NORMAL") >= 0;
  if (has_normals) {
    repairNormals(mesh, where);
  } else {
    if (!take(mesh.indices.size())) return full(mesh.indices.size());
    splitTriangles(mesh);
    computeNormals(mesh);
  }
  if (has_normals && attribute(primitive, "TANGENT") >= 0) {
    if (Status done = read("TANGENT", 4, 1e6,
                           [&](size_t i, const float* p) {
                             v[i].tangent = {p[0], p[1], p[2], p[3]};
                           });
        !done.ok())
      return done;
    repairTangents(mesh);
  } else if (needsTangents(model, primitive)) {
    computeTangents(mesh);
  }
  computeBounds(mesh);
  return Done{};
}

}  // namespace

Status convertMeshes(const tinygltf::Model& model, const GltfLimits& limits, SceneData& scene,
                     std::vector<MeshRange>& ranges) {
  Budget budget{limits.max_vertices, limits.max_indices};
  const std::string file = scene.path.string();
  size_t skipped = 0, morphed = 0;
  for (size_t m = 0; m < model.meshes.size(); ++m) {
    const tinygltf::Mesh& source = model.meshes[m];
    MeshRange range{static_cast<int>(scene.meshes.size()), 0};
    for (size_t p = 0; p < source.primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = source.primitives[p];
      morphed += !primitive.targets.empty();
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
        ++skipped;
        continue;
      }
      MeshData mesh;
      mesh.name = source.name;
      const std::string name =
          source.name.empty() ? "" : fmt::format(" \"{}\"", printable(source.name));
      const std::string where = fmt::format("{}: mesh {}{} primitive {}", file, m, name, p);
      if (Status done = convertPrimitive(model, primitive, limits, where, budget, mesh); !done.ok())
        return done;
      scene.meshes.push_back(std::move(mesh));
      ++range.count;
    }
    if (range.count == 0) range.first = -1;
    ranges.push_back(range);
  }
  if (skipped > 0) logWarning("{}: {} primitives of points or lines are not read", file, skipped);
  if (morphed > 0) logWarning("{}: morph targets of {} primitives are not read", file, morphed);
  return Done{};
}

}  // namespace scree::gltf
