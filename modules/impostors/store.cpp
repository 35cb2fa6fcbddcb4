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
  gpu::Texture coverage, height, surface;
  gpu::Texture shape, color, normal;  // for bindTextures()
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
  // Of shared/coverage.h; `channel`: of the shape.
  gpu::Texture packedShape(const char* label, size_t channel) const {
    const ivec2 size = rules::coverageSize(atlas.texels, atlas.views());
    std::vector<uint32_t> words(static_cast<size_t>(size.x * size.y));
    for (int level = 0; level < atlas.levels(); ++level)
      for (int view = 0; view < atlas.views(); ++view) {
        const int last = atlas.side(level) - 1;
        const ivec2 base = rules::coverageBase(atlas.texels, view, level);
        const uint8_t* from = atlas.shape.data() + 2 * atlas.offset(level, view) + channel;
        const auto at = [&](int x, int y) { return uint32_t{from[2 * (std::min(y, last) * (last + 1) + std::min(x, last))]}; };
        for (int y = 0; y <= last; ++y)
          for (int x = 0; x <= last; ++x)
            words[static_cast<size_t>((base.y + y) * size.x + base.x + x)] =
                at(x, y) | at(x + 1, y) << 8 | at(x, y + 1) << 16 | at(x + 1, y + 1) << 24;
      }
    gpu::Texture texture(label, {.format = GL_R32UI, .size = size});
    texture.upload(std::span<const uint32_t>(words), 1);
    return texture;
  }
  gpu::Texture packedSurface() const {
    const ivec2 size = rules::coverageSize(atlas.texels, atlas.views());
    std::vector<uint32_t> words(2 * static_cast<size_t>(size.x * size.y));
    const auto word = [](const uint8_t* b) { return b[0] | b[1] << 8u | b[2] << 16u | uint32_t{b[3]} << 24u; };
    for (int level = 0; level < atlas.levels(); ++level)
      for (int view = 0; view < atlas.views(); ++view) {
        const int side = atlas.side(level);
        const ivec2 base = rules::coverageBase(atlas.texels, view, level);
        size_t from = 4 * atlas.offset(level, view);
        for (int y = 0; y < side; ++y)
          for (int x = 0; x < side; ++x, from += 4) {
            uint32_t* to = &words[2 * static_cast<size_t>((base.y + y) * size.x + base.x + x)];
            to[0] = word(&atlas.color[from]);
            to[1] = word(&atlas.normal[from]);
          }
      }
    gpu::Texture texture("impostors.surface", {.format = GL_RG32UI, .size = size});
    texture.upload(std::span<const uint32_t>(words), 2);
    return texture;
  }
  void uploadTextures() {
    shape = textureOf("impostors.shape", GL_RG8, 2, atlas.shape);
    color = textureOf("impostors.color", GL_RGBA8, 4, atlas.color);
    normal = textureOf("impostors.normal", GL_RGBA8, 4, atlas.normal);
  }
  void upload() {
    coverage = packedShape("impostors.coverage", 0);
    height = packedShape("impostors.height", 1);
    surface = packedSurface();
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
  entry.height.bindImage(rules::kImpostorHeightImage, GL_READ_ONLY);
  entry.surface.bindImage(rules::kImpostorSurfaceImage, GL_READ_ONLY);
}

void ImpostorStore::bindTextures(uint32_t shape) {
  bind(shape);
  Entry& entry = *entries_.at(shape);
  if (!entry.shape) entry.uploadTextures();
  entry.shape.bind(rules::kImpostorShapeUnit);
  entry.color.bind(rules::kImpostorColorUnit);
  entry.normal.bind(rules::kImpostorNormalUnit);
}

}  // namespace scree
