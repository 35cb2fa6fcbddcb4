// Makes and uploads the lobe tables.
#include "modules/deferred/lobe_textures.h"

#include <span>

#include "engine/gpu/gl.h"
#include "modules/deferred/lobe_table.h"
#include "shaders/shared/spread.h"

namespace scree {
namespace {

gpu::Texture upload(const char* label, gpu::TextureKind kind, std::span<const vec4> texels) {
  const size_t layer = static_cast<size_t>(rules::kLobeTableSize) * rules::kLobeTableSize;
  gpu::Texture texture(label, {.format = GL_RGBA32F,
                               .size = ivec2(rules::kLobeTableSize),
                               .layers = static_cast<int>(texels.size() / layer),
                               .kind = kind,
                               .sampling = {.filter = gpu::Filter::Linear}});
  for (size_t k = 0; k < texels.size() / layer; ++k)
    texture.upload(std::span(&texels[k * layer].x, 4 * layer), 4, 0, static_cast<int>(k));
  return texture;
}

}  // namespace

const gpu::Texture& LobeTextures::of(bool spread_normals) {
  gpu::Texture& texture = spread_normals ? spread_ : plain_;
  if (texture) return texture;
  if (table_.empty()) table_ = makeLobeTable();
  texture = spread_normals ? upload("deferred.spread_lobe_tables", gpu::TextureKind::Array, makeSpreadLobeTables(table_))
                           : upload("deferred.lobe_table", gpu::TextureKind::Flat, table_);
  return texture;
}

}  // namespace scree
