// Three levels a dispatch, until one texel is left.
#include "modules/occlusion/pyramid.h"

#include <algorithm>

#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/occlusion.h"

namespace scree::occlusion {
namespace {

constexpr int kSize = 0, kLevel = 1;  // uniform locations
constexpr int kLevelsADispatch = 3;
constexpr int kGroup = 64;  // invocations along x

}  // namespace

void Pyramid::resize(ivec2 size_px) {
  const ivec2 side(rules::pyramidSide(size_px.x), rules::pyramidSide(size_px.y));
  if (texture_ && texture_.size() == side) return;
  texture_ = gpu::Texture();  // first, so that old and new never need memory at once
  texture_ = gpu::Texture("occlusion.pyramid", {.format = GL_R32F, .size = side, .levels = 0});
  cleared_ = false;
}

void Pyramid::build(const gpu::Texture& depth) {
  resize(depth.size());
  cleared_ = false;
  const int levels = texture_.desc().levels;
  ivec2 source = depth.size();
  for (int level = 0; level < levels; level += kLevelsADispatch) {
    gpu::Program& program = level == 0 ? first_ : next_;
    if (!program.use()) return;
    if (level > 0) gpu::barrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    (level == 0 ? depth : texture_).bind(rules::kPassTextureUnit);
    // Above the last level, whose one texel covers all, the same value is stored to it again.
    for (int k = 0; k < kLevelsADispatch; ++k)
      texture_.bindImage(static_cast<unsigned>(rules::kPyramidImage + k), GL_WRITE_ONLY,
                         std::min(level + k, levels - 1));
    program.set(kSize, source);
    program.set(kLevel, level - 1);
    source = rules::pyramidTexels(depth.size(), level + kLevelsADispatch - 1);
    gpu::dispatch(static_cast<uint32_t>((source.x + kGroup - 1) / kGroup),
                  static_cast<uint32_t>(source.y));
  }
}

void Pyramid::clear(ivec2 size_px) {
  resize(size_px);
  if (cleared_) return;
  for (int level = 0; level < texture_.desc().levels; ++level) texture_.clear(vec4(0), level);
  cleared_ = true;
}

}  // namespace scree::occlusion
