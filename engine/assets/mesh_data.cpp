// Bounds, normals and tangents of triangle meshes.
#include "engine/assets/mesh_data.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scree {
namespace {

// Angle between two directions, radians; 0 if one vanishes.
float angleBetween(const vec3& a, const vec3& b) {
  const float sine = glm::length(glm::cross(a, b));
  const float cosine = glm::dot(a, b);
  return std::atan2(sine, cosine);
}

// Calls body(corner indices, weight of each corner = its angle).
template <class Body>
void eachTriangle(const MeshData& mesh, Body&& body) {
  for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const uint32_t corner[3] = {mesh.indices[t], mesh.indices[t + 1], mesh.indices[t + 2]};
    float angle[3];
    for (int c = 0; c < 3; ++c) {
      const vec3& here = mesh.vertices[corner[c]].position;
      angle[c] = angleBetween(mesh.vertices[corner[(c + 1) % 3]].position - here,
                              mesh.vertices[corner[(c + 2) % 3]].position - here);
    }
    body(corner, angle);
  }
}

vec3 perpendicular(const vec3& normal) {
  const vec3 axis = std::abs(normal.x) < 0.5f ? vec3(1, 0, 0) : vec3(0, 0, 1);
  return glm::normalize(axis - normal * glm::dot(axis, normal));
}

// Unit vector of `v`, whatever its length; false if it has no direction.
bool direction(vec3& v) {
  const float largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return false;
  v = glm::normalize(v / largest);
  return true;
}

}  // namespace

void computeBounds(MeshData& mesh) {
  mesh.min = mesh.max = vec3(0);
  if (mesh.indices.empty()) return;
  mesh.min = mesh.max = mesh.vertices[mesh.indices[0]].position;
  for (uint32_t index : mesh.indices) {
    mesh.min = glm::min(mesh.min, mesh.vertices[index].position);
    mesh.max = glm::max(mesh.max, mesh.vertices[index].position);
  }
}

void computeNormals(MeshData& mesh) {
  for (Vertex& vertex : mesh.vertices) vertex.normal = vec3(0);
  eachTriangle(mesh, [&](const uint32_t* corner, const float* angle) {
    const vec3& origin = mesh.vertices[corner[0]].position;
    vec3 normal = glm::cross(mesh.vertices[corner[1]].position - origin,
                             mesh.vertices[corner[2]].position - origin);
    if (!direction(normal)) return;
    for (int c = 0; c < 3; ++c) mesh.vertices[corner[c]].normal += normal * angle[c];
  });
  for (Vertex& vertex : mesh.vertices)
    if (!direction(vertex.normal)) vertex.normal = vec3(0, 1, 0);
}

void computeTangents(MeshData& mesh) {
  std::vector<std::pair<vec3, vec3>> gradients(mesh.vertices.size(), {vec3(0), vec3(0)});
  eachTriangle(mesh, [&](const uint32_t* corner, const float* angle) {
    const Vertex& a = mesh.vertices[corner[0]];
    const Vertex& b = mesh.vertices[corner[1]];
    const Vertex& c = mesh.vertices[corner[2]];
    const vec3 edge1 = b.position - a.position, edge2 = c.position - a.position;
    const vec2 uv1 = b.uv - a.uv, uv2 = c.uv - a.uv;
    const float area = uv1.x * uv2.y - uv2.x * uv1.y;
    if (area == 0) return;
    // Only directions count: the sign of the area replaces the division by it.
    const float sign = area < 0 ? -1.0f : 1.0f;
    vec3 along_u = (edge1 * uv2.y - edge2 * uv1.y) * sign;
    vec3 along_v = (edge2 * uv1.x - edge1 * uv2.x) * sign;
    if (!direction(along_u) || !direction(along_v)) return;
    for (int k = 0; k < 3; ++k) {
      gradients[corner[k]].first += along_u * angle[k];
      gradients[corner[k]].second += along_v * angle[k];
    }
  });
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    Vertex& vertex = mesh.vertices[i];
    const auto& [along_u, along_v] = gradients[i];
    vec3 tangent = along_u - vertex.normal * glm::dot(vertex.normal, along_u);
    // What is left of a gradient along the normal is rounding, not a direction.
    if (glm::length(tangent) <= 1e-5f * glm::length(along_u) || !direction(tangent))
      tangent = perpendicular(vertex.normal);
    // Images grow downwards in v, so the bitangent of a right-handed normal map points along -v.
    const float handed = glm::dot(glm::cross(vertex.normal, tangent), along_v) < 0 ? 1.0f : -1.0f;
    vertex.tangent = vec4(tangent, along_v == vec3(0) ? 1.0f : handed);
  }
}

}  // namespace scree
