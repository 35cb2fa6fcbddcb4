// Atlases on the GPU.
#include <algorithm>
#include <utility>
#include <vector>

#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"
#include "modules/impostors/impostors.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/coverage.h"

namespace scree {

struct ImpostorStore::Entry {
  ImpostorAtlas atlas;
  gpu::Texture coverage, shape, color, normal;
  gpu::Buffer block;

  gpu::Texture textureOf(const char* label, unsigned format, int channels, const std::vector<uint8_t>& bytes) const {
    // Linear within the level that the program chooses.
    gpu::Texture texture(label, {.format = format,
                                 .size = ivec2(atlas.texels),
                                 .levels = atlas.levels(),
                                 .layers = atlas.views(),
                                 .kind = gpu::TextureKind::Array,
                                 .sampling = {.filter = gpu::Filter::NearestMip}});
    for (int level = 0; level < atlas.levels(); ++level) {
      const auto size = static_cast<size_t>(atlas.side(level) * atlas.side(level)) * static_cast<size_t>(channels);
      for (int layer = 0; layer < atlas.views(); ++layer)
        texture.upload(std::span(bytes).subspan(atlas.offset(level, layer) * static_cast<size_t>(channels), size),
                       channels, level, layer);
    }
    return texture;
  }
  // Of shared/coverage.h.
  gpu::Texture packedCoverage() const {
    const ivec2 size = rules::coverageSize(atlas.texels, atlas.views());
    std::vector<uint32_t> words(static_cast<size_t>(size.x * size.y));
    for (int level = 0; level < atlas.levels(); ++level)
      for (int view = 0; view < atlas.views(); ++view) {
        const int last = atlas.side(level) - 1;
        const ivec2 base = rules::coverageBase(atlas.texels, view, level);
        const uint8_t* from = atlas.shape.data() + 2 * atlas.offset(level, view);
        const auto at = [&](int x, int y) { return uint32_t{from[2 * (std::min(y, last) * (last + 1) + std::min(x, last))]}; };
        for (int y = 0; y <= last; ++y)
          for (int x = 0; x <= last; ++x)
            words[static_cast<size_t>((base.y + y) * size.x + base.x + x)] =
                at(x, y) | at(x + 1, y) << 8 | at(x, y + 1) << 16 | at(x + 1, y + 1) << 24;
      }
    gpu::Texture texture("impostors.coverage", {.format = GL_R32UI, .size = size});
    texture.upload(std::span<const uint32_t>(words), 1);
    return texture;
  }
  void upload() {
    coverage = packedCoverage();
    shape = textureOf("impostors.shape", GL_RG8, 2, atlas.shape);
    color = textureOf("impostors.color", GL_RGBA8, 4, atlas.color);
    normal = textureOf("impostors.normal", GL_RGBA8, 4, atlas.normal);
    const float extent = rules::impostorExtent(atlas.texels);
    const rules::ImpostorBlock constants{atlas.proxy, atlas.edge, atlas.texels, extent, 0.5f / extent};
    block = gpu::Buffer("impostors.block", sizeof(constants), &constants);
  }
};

ImpostorStore::ImpostorStore() = default;
ImpostorStore::~ImpostorStore() = default;
ImpostorStore::ImpostorStore(ImpostorStore&&) noexcept = default;
ImpostorStore& ImpostorStore::operator=(ImpostorStore&&) noexcept = default;

void ImpostorStore::set(uint32_t shape, ImpostorAtlas atlas) {
  auto entry = std::make_unique<Entry>();
  entry->atlas = std::move(atlas);
  entries_[shape] = std::move(entry);
}

const ImpostorAtlas* ImpostorStore::find(uint32_t shape) const {
  const auto found = entries_.find(shape);
  return found == entries_.end() ? nullptr : &found->second->atlas;
}

void ImpostorStore::bind(uint32_t shape) {
  Entry& entry = *entries_.at(shape);
  if (!entry.block) entry.upload();
  entry.block.bindUniform(rules::kDrawBinding);
  entry.coverage.bindImage(rules::kImpostorCoverageImage, GL_READ_ONLY);
  entry.shape.bind(rules::kImpostorShapeUnit);
  entry.color.bind(rules::kImpostorColorUnit);
  entry.normal.bind(rules::kImpostorNormalUnit);
}

}  // namespace scree
