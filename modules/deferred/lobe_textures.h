// The lobe tables on the GPU, each made when a frame first needs it.
#pragma once

#include <vector>

#include "engine/gpu/objects.h"

namespace scree {

class LobeTextures {
 public:
  // Of surfaces with one normal; or, as layers, of all steps of spread. Costs what makeLobeTable() takes once, and
  // what makeSpreadLobeTables() takes once where normals are spread.
  const gpu::Texture& of(bool spread_normals);

 private:
  std::vector<vec4> table_;
  gpu::Texture plain_, spread_;
};

}  // namespace scree
