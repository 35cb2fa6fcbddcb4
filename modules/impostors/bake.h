// Baking a grain's mesh into an atlas, on the CPU: the same bytes on every machine and for every
// number of threads.
#pragma once

#include <functional>

#include "engine/core/result.h"
#include "modules/impostors/atlas.h"
#include "modules/impostors/grain_mesh.h"

namespace scree {

struct BakeParameters {
  int edge = 9;         // n: vertices along an edge of the view octahedron; 4 (n - 1)^2 + 2 views
  int texels = 64;      // p: texels along a view's side
  int supersample = 4;  // samples along a texel's side, 1 to 8
  int directions = 24;  // from which errors are measured, 0 to 1024; 0: not at all
};

// Refuses, in one line, numbers that are out of range and atlases over kImpostorMaxBytes.
Status checkParameters(const BakeParameters& parameters);

// Identifies what bake() would make.
uint64_t bakeKey(const GrainMesh& grain, const BakeParameters& parameters);

// Called with the share that is done, 0 to 1, from any thread, one call at a time.
using BakeProgress = std::function<void(double done)>;

Result<ImpostorAtlas> bake(const GrainMesh& grain, const BakeParameters& parameters,
                           const BakeProgress& progress = {});

}  // namespace scree
