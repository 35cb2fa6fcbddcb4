// Triangle meshes in memory, as loaded, made by code, and uploaded.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/math.h"

namespace scree {

// 48 bytes, uploaded as it is: attributes 0 to 3 of every mesh program.
struct Vertex {
  vec3 position{0};          // m, local space
  vec3 normal{0, 1, 0};      // unit
  vec4 tangent{1, 0, 0, 1};  // unit xyz along +u; bitangent = w * cross(normal, tangent), w = +-1
  vec2 uv{0};                // (0, 0) = the image's top left
};
static_assert(sizeof(Vertex) == 48);

// One glTF primitive: triangles, counter-clockwise seen from outside.
struct MeshData {
  std::string name;
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;  // 3 a triangle, each < vertices.size()
  vec3 min{0};                    // bounds of the positions that triangles use, m
  vec3 max{0};
  int material = -1;  // index into SceneData::materials; -1: the default material
};

// Sets min and max from the vertices that `indices` name; zero for a mesh without triangles.
void computeBounds(MeshData& mesh);

// Normals as the sum of the triangles' normals weighted by the angle at the vertex (Thuermer and
// Wuethrich 1998). Vertices of one position share a normal only if they share the index: positions
// split on purpose stay split. A vertex without a triangle of non-zero area gets +Y.
void computeNormals(MeshData& mesh);

// Tangents per vertex from the uv gradient of its triangles, weighted by angle, orthogonalised
// against the normal (Lengyel 2001; not MikkTSpace: a normal map baked for MikkTSpace shows slight
// seams where uv shells meet). Where the gradient vanishes, any unit vector perpendicular to the
// normal. Needs normals. A vertex whose triangles mirror each other in uv keeps the sign of their
// weighted sum.
void computeTangents(MeshData& mesh);

}  // namespace scree
