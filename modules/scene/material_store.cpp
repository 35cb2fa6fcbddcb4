// Materials and their textures.
#include <fmt/format.h>

#include <map>
#include <tuple>

#include "engine/core/log.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/objects.h"
#include "modules/scene/scene.h"

namespace scree {
namespace {

// On a GPU trilinear and anisotropic; where a CPU draws, linear in the nearest mip level. In
// llvmpipe the opaque pass of a textured level takes 46 ms so, 60 ms trilinear, 276 ms anisotropic.
void setFilter(gpu::Sampling& sampling, bool nearest) {
  const bool software = gpu::limits().software;
  sampling.filter = software ? gpu::Filter::NearestMip : gpu::Filter::Mipmap;
  sampling.anisotropy = software || nearest ? 1 : 8;
}

int wrapMode(TextureWrap wrap) {
  switch (wrap) {
    case TextureWrap::Repeat:
      return GL_REPEAT;
    case TextureWrap::MirroredRepeat:
      return GL_MIRRORED_REPEAT;
    case TextureWrap::ClampToEdge:
      return GL_CLAMP_TO_EDGE;
  }
  return GL_REPEAT;
}

// Grey becomes red = green = blue, missing alpha becomes 1.
template <class T>
std::vector<T> asRgba(const std::vector<T>& values, int channels, T one) {
  std::vector<T> rgba(values.size() / static_cast<size_t>(channels) * 4);
  for (size_t i = 0, p = 0; p < rgba.size(); i += static_cast<size_t>(channels), p += 4) {
    for (size_t c = 0; c < 3; ++c) rgba[p + c] = values[i + (channels < 3 ? 0 : c)];
    rgba[p + 3] = channels % 2 == 0 ? values[i + static_cast<size_t>(channels) - 1] : one;
  }
  return rgba;
}

// Rows stay top first: glTF's v = 0 is the image's top, GL's the first row in memory.
gpu::Texture makeTexture(const ImageData& image, const TextureUse& use) {
  gpu::TextureDesc desc;
  desc.format = image.isFloat()                         ? GL_RGBA32F
                : image.encoding == ColorEncoding::Srgb ? GL_SRGB8_ALPHA8
                                                        : GL_RGBA8;
  desc.size = {image.width, image.height};
  desc.levels = 0;
  setFilter(desc.sampling, use.nearest);
  gpu::Texture texture("scene." + (image.name.empty() ? "image" : image.name), desc);
  if (image.isFloat())
    texture.upload(std::span<const float>(asRgba(image.floats, image.channels, 1.0f)), 4);
  else
    texture.upload(std::span<const uint8_t>(asRgba(image.bytes, image.channels, uint8_t{255})), 4);
  texture.generateMips();
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, wrapMode(use.wrap_u));
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, wrapMode(use.wrap_v));
  if (use.nearest) glTextureParameteri(texture.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

gpu::Texture makeFlatNormal() {
  gpu::Texture texture("scene.flat_normal", {.format = GL_RGBA8, .size = {1, 1}});
  texture.clear(vec4(128.0f / 255, 128.0f / 255, 1, 1));
  return texture;
}

const TextureUse& useOf(const MaterialData& material, MaterialMap map) {
  switch (map) {
    case MaterialMap::BaseColor:
      return material.base_color_map;
    case MaterialMap::MetallicRoughness:
      return material.metallic_roughness_map;
    case MaterialMap::Normal:
      return material.normal_map;
    case MaterialMap::Emissive:
      return material.emissive_map;
  }
  fail("MaterialStore: unknown map");
}

}  // namespace

struct MaterialStore::State {
  using Key = std::tuple<int, TextureWrap, TextureWrap, bool>;

  std::vector<ImageData> images;
  std::vector<MaterialData> materials;
  std::map<Key, gpu::Texture> textures;  // empty: too large for the GPU
  gpu::Texture flat_normal;

  const gpu::Texture& neutral(MaterialMap map) {
    if (map != MaterialMap::Normal) return gpu::whiteTexture();
    if (!flat_normal) flat_normal = makeFlatNormal();
    return flat_normal;
  }
};

MaterialStore::MaterialStore() : state_(std::make_unique<State>()) {
  MaterialData plain;
  plain.name = "default";
  plain.metallic = 0;
  state_->materials.push_back(std::move(plain));
}
MaterialStore::~MaterialStore() = default;
MaterialStore::MaterialStore(MaterialStore&&) noexcept = default;
MaterialStore& MaterialStore::operator=(MaterialStore&&) noexcept = default;

int MaterialStore::addImage(ImageData image) {
  const size_t values = image.isFloat() ? image.floats.size() : image.bytes.size();
  const bool sound =
      image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4;
  if (!sound || values != static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                              static_cast<size_t>(image.channels))
    fail(fmt::format("MaterialStore::addImage: image \"{}\": {}x{} with {} channels and {} values",
                     image.name, image.width, image.height, image.channels, values));
  state_->images.push_back(std::move(image));
  return static_cast<int>(state_->images.size()) - 1;
}

uint32_t MaterialStore::add(MaterialData material) {
  for (uint32_t map = 0; map < kMaterialMaps; ++map) {
    const int index = useOf(material, static_cast<MaterialMap>(map)).image;
    if (index >= static_cast<int>(state_->images.size()))
      fail(fmt::format("MaterialStore::add: material \"{}\": image {} of {}", material.name, index,
                       state_->images.size()));
  }
  state_->materials.push_back(std::move(material));
  return static_cast<uint32_t>(state_->materials.size() - 1);
}

size_t MaterialStore::size() const {
  return state_->materials.size();
}
size_t MaterialStore::imageCount() const {
  return state_->images.size();
}

const MaterialData& MaterialStore::material(uint32_t handle) const {
  if (handle >= state_->materials.size())
    fail(fmt::format("MaterialStore: material {}; there are {}", handle, state_->materials.size()));
  return state_->materials[handle];
}

const ImageData& MaterialStore::image(int index) const {
  if (index < 0 || index >= static_cast<int>(state_->images.size()))
    fail(fmt::format("MaterialStore: image {}; there are {}", index, state_->images.size()));
  return state_->images[static_cast<size_t>(index)];
}

const gpu::Texture& MaterialStore::texture(uint32_t handle, MaterialMap map) {
  const TextureUse& use = useOf(material(handle), map);
  if (use.image < 0) return state_->neutral(map);
  const auto [entry, is_new] =
      state_->textures.try_emplace({use.image, use.wrap_u, use.wrap_v, use.nearest});
  if (is_new) {
    const ImageData& source = image(use.image);
    const int most = gpu::limits().texture_size;
    if (source.width <= most && source.height <= most)
      entry->second = makeTexture(source, use);
    else
      logError("image \"{}\": {}x{} pixels; this GPU takes {} a side: drawn without it",
               source.name, source.width, source.height, most);
  }
  return entry->second ? entry->second : state_->neutral(map);
}

void MaterialStore::bind(uint32_t handle) {
  for (uint32_t map = 0; map < kMaterialMaps; ++map)
    texture(handle, static_cast<MaterialMap>(map))
        .bind(static_cast<unsigned>(rules::kBaseColorUnit) + map);
}

}  // namespace scree
