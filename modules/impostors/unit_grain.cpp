// Placing a grain's mesh in its own space, and its materials at a point.
#include "modules/impostors/unit_grain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/assets/texel.h"
#include "modules/impostors/atlas.h"

namespace scree::impostors {
namespace {

// At full resolution: the bake's samples are finer than a grain's images, or average them.
vec4 mapped(const UnitGrain& grain, const TextureUse& use, vec2 uv, vec4 neutral) {
  return use.image < 0 ? neutral
                       : bilinearTexel((*grain.images)[static_cast<size_t>(use.image)], use, uv);
}

struct Weights {
  const Vertex &a, &b, &c;
  float wa, wb, wc;
  template <class T>
  T of(T Vertex::*member) const {
    return a.*member * wa + b.*member * wb + c.*member * wc;
  }
};
Weights weightsOf(const UnitGrain& grain, const UnitTriangle& t, float b, float c) {
  return {grain.vertices[t.v[0]], grain.vertices[t.v[1]], grain.vertices[t.v[2]], 1 - b - c, b, c};
}

vec3 unitOr(vec3 v, vec3 otherwise) {
  const float length2 = glm::dot(v, v);
  return length2 > 1e-12f && length2 < 1e12f ? v * (1.0f / std::sqrt(length2)) : otherwise;
}

}  // namespace

Result<UnitGrain> unitGrain(const GrainMesh& grain) {
  UnitGrain unit;
  unit.materials = grain.materials;
  unit.materials.push_back({.metallic = 0});
  unit.images = &grain.images;
  std::vector<dvec3> used;
  for (const MeshData& part : grain.parts) {
    const auto base = static_cast<uint32_t>(unit.vertices.size());
    unit.vertices.insert(unit.vertices.end(), part.vertices.begin(), part.vertices.end());
    const int material =
        part.material < 0 ? static_cast<int>(grain.materials.size()) : part.material;
    const MaterialData& about = unit.materials[static_cast<size_t>(material)];
    for (size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      UnitTriangle triangle{.material = material,
                            .masked = about.alpha_mode != AlphaMode::Opaque,
                            .double_sided = about.double_sided};
      for (size_t k = 0; k < 3; ++k) {
        triangle.v[k] = base + part.indices[i + k];
        used.emplace_back(part.vertices[part.indices[i + k]].position);
      }
      unit.triangles.push_back(triangle);
    }
  }
  const Sphere outer = roomySphere(used, used);
  const double size =
      std::max({std::abs(outer.center.x), std::abs(outer.center.y), std::abs(outer.center.z)});
  constexpr double kLeastShare = 1e-6, kLeast = 1e-30, kMost = static_cast<double>(kImpostorMostUnits);
  if (!(outer.radius > kLeast && outer.radius > kLeastShare * size && std::max(outer.radius, size) <= kMost))
    return Error{fmt::format("grain: its outer radius is {:g} around {:g} {:g} {:g}; it must be above {:g} and a millionth of the "
                             "distance from the mesh's origin, both at most {:g}",
                             outer.radius, outer.center.x, outer.center.y, outer.center.z, kLeast, kMost)};
  unit.center = outer.center;
  unit.outer = outer.radius;
  for (Vertex& vertex : unit.vertices) {
    unit.positions.push_back((dvec3(vertex.position) - outer.center) / outer.radius);
    vertex.position = vec3(unit.positions.back());
  }
  for (const UnitTriangle& triangle : unit.triangles)
    for (uint32_t v : triangle.v) unit.corners.push_back(unit.positions[v]);
  // Beside an outer radius of 1; floats leave some to a line.
  constexpr double kLeastArea = 1e-9;
  double area = 0;
  for (size_t k = 0; k + 2 < unit.corners.size(); k += 3)
    area += 0.5 * glm::length(glm::cross(unit.corners[k + 1] - unit.corners[k], unit.corners[k + 2] - unit.corners[k]));
  if (!(area > kLeastArea))
    return Error{fmt::format("grain: its {} triangles have an area of {:g} outer radii squared; nothing of it could be seen",
                             unit.triangles.size(), area)};
  unit.inner = innerRadius(unit.corners, dvec3(0));
  return unit;
}

Surface surfaceAt(const UnitGrain& grain, const UnitTriangle& triangle, float b, float c,
                  bool flipped) {
  const Weights at = weightsOf(grain, triangle, b, c);
  const MaterialData& material = grain.materials[static_cast<size_t>(triangle.material)];
  const vec2 uv = at.of(&Vertex::uv);
  Surface s;
  s.albedo = vec3(material.base_color) * vec3(mapped(grain, material.base_color_map, uv, vec4(1)));
  s.albedo = glm::clamp(s.albedo, 0.0f, 1.0f);
  const vec4 metal_rough = mapped(grain, material.metallic_roughness_map, uv, vec4(1));
  s.roughness = std::clamp(material.roughness * metal_rough.y, 0.0f, 1.0f);
  s.metallic = std::clamp(material.metallic * metal_rough.z, 0.0f, 1.0f);
  s.normal = unitOr(at.of(&Vertex::normal), at.a.normal);
  if (material.normal_map.image >= 0) {
    const vec4 code = mapped(grain, material.normal_map, uv, vec4(0.5f, 0.5f, 1, 1));
    const vec2 slope = (vec2(code) * 2.0f - 1.0f) * material.normal_scale;
    const vec4 tangent4 = at.of(&Vertex::tangent);
    const vec3 tangent =
        unitOr(vec3(tangent4) - s.normal * glm::dot(s.normal, vec3(tangent4)), vec3(0));
    const vec3 bitangent = glm::cross(s.normal, tangent) * (tangent4.w < 0 ? -1.0f : 1.0f);
    s.normal =
        unitOr(tangent * slope.x + bitangent * slope.y + s.normal * (code.z * 2 - 1), s.normal);
  }
  if (flipped) s.normal = -s.normal;
  return s;
}

bool opaqueAt(const UnitGrain& grain, const UnitTriangle& triangle, float b, float c) {
  const MaterialData& material = grain.materials[static_cast<size_t>(triangle.material)];
  const vec2 uv = weightsOf(grain, triangle, b, c).of(&Vertex::uv);
  const float alpha = material.base_color.w * mapped(grain, material.base_color_map, uv, vec4(1)).w;
  return alpha >= (material.alpha_mode == AlphaMode::Mask ? material.alpha_cutoff : 0.5f);
}

}  // namespace scree::impostors
