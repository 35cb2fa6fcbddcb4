// A grain's mesh in its own space (centre at the origin, outer radius 1), flat and ready to be
// cast.
#pragma once

#include <vector>

#include "modules/impostors/grain_mesh.h"
#include "modules/impostors/spheres.h"

namespace scree::impostors {

struct UnitTriangle {
  uint32_t v[3];
  int material = 0;  // index into UnitGrain::materials
  bool masked = false;
  bool double_sided = false;
};

struct UnitGrain {
  std::vector<Vertex> vertices;  // positions rounded from the double ones
  std::vector<dvec3> positions;  // one a vertex
  std::vector<UnitTriangle> triangles;
  std::vector<MaterialData> materials;  // the last is the default: white, metallic 0, roughness 1
  const std::vector<ImageData>* images = nullptr;
  Corners corners;   // three a triangle
  dvec3 center{0};   // of the spheres, in the mesh's units
  double outer = 0;  // R, in the mesh's units
  double inner = 0;  // r / R
};

// `grain` must pass checkGrain and outlive the result. Refuses a mesh without extent.
Result<UnitGrain> unitGrain(const GrainMesh& grain);

// The material at a point of a triangle.
struct Surface {
  vec3 albedo{1};        // linear
  vec3 normal{0, 0, 1};  // unit, out of the side that is seen
  float roughness = 1;
  float metallic = 0;
  float spread = 0;  // of normals, about `normal` (shared/spread.h)
};
// `b` and `c`: barycentric weights of corners 1 and 2; `flipped`: the back is seen.
Surface surfaceAt(const UnitGrain& grain, const UnitTriangle& triangle, float b, float c,
                  bool flipped);
// Whether the material's alpha lets a masked triangle be seen there.
bool opaqueAt(const UnitGrain& grain, const UnitTriangle& triangle, float b, float c);

}  // namespace scree::impostors
