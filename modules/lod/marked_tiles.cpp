// The buffer of marked tiles, with the commands that draw and empty them.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "modules/lod/lod.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/tiles.h"

namespace scree {

static_assert(sizeof(rules::TileCommands) == 32);

void MarkedTiles::ready(ivec2 size_px) {
  const ivec2 tiles = rules::tileCount(size_px);
  const size_t words = static_cast<size_t>(tiles.x) * static_cast<size_t>(tiles.y);
  if (gpu::reserve(marked_, label_, sizeof(rules::TileCommands) + sizeof(uint32_t) * words)) {
    marked_.fill(0);
    const rules::TileCommands none{0, 1, 0, 0, {0, 1, 1}, 0};
    marked_.upload(&none, sizeof(none));
  }
  bind();
}

void MarkedTiles::bind() const { marked_.bindStorage(rules::kTilesBinding); }

void MarkedTiles::draw() const {
  bind();
  gpu::drawVertexlessIndirect(GL_TRIANGLES, marked_, 0);
}

void MarkedTiles::empty() const {
  gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);  // who drew them has read the marks
  bind();
  gpu::dispatchIndirect(marked_, offsetof(rules::TileCommands, groups));
}

}  // namespace scree
