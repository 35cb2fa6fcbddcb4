// The buffer of marked tiles.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "modules/lod/lod.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/tiles.h"

namespace scree {

void MarkedTiles::clear(ivec2 size_px) {
  const ivec2 tiles = rules::tileCount(size_px);
  count_ = tiles.x * tiles.y;
  gpu::reserve(marked_, label_, sizeof(uint32_t) * static_cast<size_t>(count_));
  marked_.fill(0);
  bind();
}

void MarkedTiles::bind() const { marked_.bindStorage(rules::kTilesBinding); }

void MarkedTiles::draw() const {
  bind();
  gpu::drawVertexless(GL_TRIANGLES, 6 * count_);
}

}  // namespace scree
