// Gathering, checking and hashing of a grain's mesh.
#include "modules/impostors/grain_mesh.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <utility>

#include "engine/core/hash.h"

namespace scree {
namespace {

// The mesh at a node's place. A mirrored node turns the triangles round.
MeshData placed(const MeshData& mesh, const NodeData& node) {
  MeshData out = mesh;
  const vec3 inverse = 1.0f / node.scale;
  const float mirror = node.scale.x * node.scale.y * node.scale.z < 0 ? -1.0f : 1.0f;
  for (Vertex& vertex : out.vertices) {
    vertex.position = vec3(node.position + dvec3(node.rotation * (vertex.position * node.scale)));
    vertex.normal = glm::normalize(node.rotation * (vertex.normal * inverse));
    const vec3 tangent = node.rotation * (vec3(vertex.tangent) * node.scale);
    vertex.tangent = vec4(glm::normalize(tangent), vertex.tangent.w * mirror);
  }
  if (mirror < 0)
    for (size_t t = 0; t + 2 < out.indices.size(); t += 3)
      std::swap(out.indices[t + 1], out.indices[t + 2]);
  return out;
}

uint64_t hashOf(uint64_t hash, const TextureUse& use) {
  hash = hashCombine(hash, static_cast<uint64_t>(use.image + 1));
  return hashCombine(hash, static_cast<uint64_t>(use.wrap_u) | static_cast<uint64_t>(use.wrap_v)
                                                                   << 8);
}

bool imageFits(const ImageData& image) {
  if (image.width <= 0 || image.height <= 0 || image.channels < 1 || image.channels > 4)
    return false;
  const size_t values = static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                        static_cast<size_t>(image.channels);
  return image.isFloat() ? image.floats.size() == values : image.bytes.size() == values;
}

Status checkPart(const MeshData& part, size_t p, const GrainMesh& grain) {
  const auto fault = [&](const std::string& what) {
    return Error{fmt::format("grain: part {} \"{}\": {}", p, part.name, what)};
  };
  if (part.indices.size() % 3 != 0)
    return fault(fmt::format("{} indices, allowed are whole triangles", part.indices.size()));
  for (size_t i = 0; i < part.indices.size(); ++i)
    if (part.indices[i] >= part.vertices.size())
      return fault(
          fmt::format("index {} is {}, of {} vertices", i, part.indices[i], part.vertices.size()));
  for (size_t v = 0; v < part.vertices.size(); ++v) {
    const Vertex& vertex = part.vertices[v];
    const bool numbers = finite(vertex.position) && finite(vertex.normal) &&
                         finite(vec3(vertex.tangent)) && finite(vertex.tangent.w) &&
                         finite(vertex.uv.x) && finite(vertex.uv.y);
    if (!numbers) return fault(fmt::format("vertex {} has a number that is not finite", v));
  }
  if (part.material >= static_cast<int>(grain.materials.size()))
    return fault(fmt::format("material {}, of {}", part.material, grain.materials.size()));
  return Done{};
}

}  // namespace

Result<GrainMesh> grainFromScene(SceneData scene) {
  // Few bytes may say that a mesh is placed many times.
  constexpr size_t kMostTriangles = 4'000'000;
  size_t triangles = 0;
  for (const NodeData& node : scene.nodes)
    for (int m = 0; m < node.mesh_count; ++m)
      triangles += scene.meshes[static_cast<size_t>(node.first_mesh + m)].indices.size() / 3;
  if (triangles > kMostTriangles)
    return Error{fmt::format("{}: grain: has {} triangles, allowed are {}", scene.path.string(), triangles, kMostTriangles)};
  GrainMesh grain;
  for (const NodeData& node : scene.nodes)
    for (int m = 0; m < node.mesh_count; ++m)
      grain.parts.push_back(placed(scene.meshes[static_cast<size_t>(node.first_mesh + m)], node));
  grain.materials = std::move(scene.materials);
  grain.images = std::move(scene.images);
  if (Status fine = checkGrain(grain); !fine.ok())
    return Error{fmt::format("{}: {}", scene.path.string(), fine.error())};
  return grain;
}

Status checkGrain(const GrainMesh& grain) {
  size_t triangles = 0;
  for (size_t p = 0; p < grain.parts.size(); ++p) {
    if (Status fine = checkPart(grain.parts[p], p, grain); !fine.ok()) return fine;
    triangles += grain.parts[p].indices.size() / 3;
  }
  if (triangles == 0) return Error{"grain: has no triangle"};
  for (size_t i = 0; i < grain.images.size(); ++i)
    if (!imageFits(grain.images[i]))
      return Error{fmt::format("grain: image {} \"{}\": its size is not that of its pixels", i,
                               grain.images[i].name)};
  for (size_t m = 0; m < grain.materials.size(); ++m) {
    const MaterialData& material = grain.materials[m];
    for (const TextureUse* use : {&material.base_color_map, &material.metallic_roughness_map,
                                  &material.normal_map, &material.emissive_map})
      if (use->image >= static_cast<int>(grain.images.size()))
        return Error{fmt::format("grain: material {} \"{}\": image {}, of {}", m, material.name,
                                 use->image, grain.images.size())};
  }
  return Done{};
}

uint64_t contentHash(const GrainMesh& grain) {
  uint64_t hash = hashName("scree grain");
  for (const MeshData& part : grain.parts) {
    hash = hashBytes(part.vertices.data(), part.vertices.size() * sizeof(Vertex), hash);
    hash = hashBytes(part.indices.data(), part.indices.size() * sizeof(uint32_t), hash);
    hash = hashCombine(hash, static_cast<uint64_t>(part.material + 1));
  }
  for (const MaterialData& material : grain.materials) {
    const float factors[] = {material.base_color.x, material.base_color.y, material.base_color.z,
                             material.base_color.w, material.metallic,     material.roughness,
                             material.normal_scale, material.alpha_cutoff};
    hash = hashBytes(factors, sizeof factors, hash);
    hash = hashOf(hash, material.base_color_map);
    hash = hashOf(hash, material.metallic_roughness_map);
    hash = hashOf(hash, material.normal_map);
    hash = hashCombine(hash, static_cast<uint64_t>(material.alpha_mode) |
                                 static_cast<uint64_t>(material.double_sided) << 8);
  }
  for (const ImageData& image : grain.images) {
    hash = hashCombine(
        hash, static_cast<uint64_t>(image.width) << 32 | static_cast<uint64_t>(image.height));
    hash = hashCombine(
        hash, static_cast<uint64_t>(image.channels) << 8 | static_cast<uint64_t>(image.encoding));
    hash = hashBytes(image.bytes.data(), image.bytes.size(), hash);
    hash = hashBytes(image.floats.data(), image.floats.size() * sizeof(float), hash);
  }
  return hash;
}

}  // namespace scree
