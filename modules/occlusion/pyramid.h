// The texture of the depth pyramid and how it is filled. Private to the module.
#pragma once

#include "engine/core/math.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/program.h"

namespace scree::occlusion {

// World singleton.
class Pyramid {
 public:
  // Fills all levels from a depth texture of the picture.
  void build(const gpu::Texture& depth);
  // Makes it that of an empty picture of `size_px`.
  void clear(ivec2 size_px);
  const gpu::Texture& texture() const { return texture_; }

 private:
  void resize(ivec2 size_px);

  gpu::Texture texture_;
  bool cleared_ = false;  // every texel is 0
  gpu::Program first_{{.name = "occlusion.pyramid", .compute = "occlusion/pyramid.comp"}};
  gpu::Program next_{{.name = "occlusion.pyramid_next",
                      .compute = "occlusion/pyramid.comp",
                      .defines = {"FROM_LEVEL"}}};
};

}  // namespace scree::occlusion
