// What a shape looks like from so far that nothing of it is told apart.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/assets/gltf.h"
#include "engine/assets/mesh_data.h"
#include "engine/assets/texel.h"
#include "modules/lod/lod.h"

namespace scree {
namespace {

// White if there is none, or its pixels are not kept. Nearest: the mean over a surface needs no more.
vec4 mapped(const MaterialStore& materials, const TextureUse& use, vec2 uv) {
  if (use.image < 0) return vec4(1);
  const ImageData& image = materials.image(use.image);
  return image.bytes.empty() && image.floats.empty() ? vec4(1) : nearestTexel(image, use, uv);
}

constexpr int kSteps = 4;  // samples along an edge of a triangle
constexpr int kSamples = kSteps * (kSteps + 1) / 2;

struct Means {
  dvec3 albedo{0};
  double roughness = 0, metallic = 0, facing = 0, weight = 0;
};

void addPart(const MaterialStore& materials, const MeshData& mesh, Means& means) {
  const MaterialData& material = materials.material(mesh.material < 0 ? 0u : static_cast<uint32_t>(mesh.material));
  for (size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
    const Vertex &a = mesh.vertices[mesh.indices[k]], &b = mesh.vertices[mesh.indices[k + 1]],
                 &c = mesh.vertices[mesh.indices[k + 2]];
    const vec3 across = glm::cross(b.position - a.position, c.position - a.position);
    const float twice = glm::length(across);
    const double area = 0.5 * static_cast<double>(twice);
    if (!(area > 0)) continue;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps - i; ++j) {
        const float u = (static_cast<float>(i) + 1.0f / 3) / kSteps, v = (static_cast<float>(j) + 1.0f / 3) / kSteps;
        const vec2 uv = a.uv + (b.uv - a.uv) * u + (c.uv - a.uv) * v;
        const vec4 surface = mapped(materials, material.metallic_roughness_map, uv);
        means.albedo += area * dvec3(vec3(material.base_color) * vec3(mapped(materials, material.base_color_map, uv)));
        means.roughness += area * static_cast<double>(material.roughness * surface.y);
        means.metallic += area * static_cast<double>(material.metallic * surface.z);
        const vec3 normal = a.normal + (b.normal - a.normal) * u + (c.normal - a.normal) * v;
        const float cosine = glm::dot(normal, across) / (glm::length(normal) * twice);
        means.facing += area * static_cast<double>(std::isfinite(cosine) ? std::clamp(cosine, 0.0f, 1.0f) : 1.0f);
        means.weight += area;
      }
  }
}

}  // namespace

double meanShadowRadius(double surface) { return std::sqrt(surface / (4 * std::numbers::pi)); }

void setMeanLook(const MaterialStore& materials, GrainShape& shape, std::span<const MeshData> parts) {
  Means means;
  for (const MeshData& part : parts) addPart(materials, part, means);
  if (!(means.weight > 0)) return;
  shape.albedo = vec3(means.albedo / means.weight);
  shape.roughness = static_cast<float>(means.roughness / means.weight);
  shape.metallic = static_cast<float>(means.metallic / means.weight);
  shape.facing = static_cast<float>(means.facing / means.weight);
  shape.cast_share = std::min(1.0f, static_cast<float>(meanShadowRadius(means.weight / kSamples)) / shape.outer_radius);
}

}  // namespace scree
