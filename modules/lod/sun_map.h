// What swarms look like from the sun, kept as long as neither the grains nor the shadow map's place change.
#pragma once

#include <cstdint>

#include "engine/gpu/objects.h"

namespace scree::lod {

struct SunMap {
  gpu::Buffer cells;
  gpu::Buffer depth;  // by texel, and which tiles are not empty
  uint64_t shadow_version = 0, casters_version = 0;  // of what `depth` holds; 0: nothing
};

}  // namespace scree::lod
