// glTF materials, with the images that they use, decoded as sRGB or linear by that use.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "engine/assets/gltf_convert.h"

namespace scree::gltf {
namespace {

class Images {
 public:
  Images(const tinygltf::Model& model, const GltfLimits& limits, SceneData& scene)
      : model_(model), scene_(scene), limits_(limits.image), bytes_left_(limits.max_total_bytes) {}

  // The texture of a material's map; on a fault, the first is kept.
  TextureUse use(int texture_index, ColorEncoding encoding) {
    TextureUse use;
    if (texture_index < 0 || !fault_.empty()) return use;
    const tinygltf::Texture& texture = model_.textures[static_cast<size_t>(texture_index)];
    use.image = decoded(texture.source, encoding);
    if (texture.sampler < 0) return use;
    const tinygltf::Sampler& sampler = model_.samplers[static_cast<size_t>(texture.sampler)];
    use.wrap_u = wrap(sampler.wrapS);
    use.wrap_v = wrap(sampler.wrapT);
    use.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    return use;
  }
  const std::string& fault() const { return fault_; }

 private:
  static TextureWrap wrap(int mode) {
    if (mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return TextureWrap::ClampToEdge;
    if (mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return TextureWrap::MirroredRepeat;
    return TextureWrap::Repeat;
  }

  int decoded(int source, ColorEncoding encoding) {
    const auto [entry, is_new] = indices_.try_emplace({source, encoding}, -1);
    if (!is_new) return entry->second;
    const tinygltf::Image& image = model_.images[static_cast<size_t>(source)];
    const std::string where =
        fmt::format("{}: image {}{}", scene_.path.string(), source,
                    image.name.empty() ? "" : fmt::format(" \"{}\"", printable(image.name)));
    ImageLimits limits = limits_;
    limits.max_pixels = std::min<uint64_t>(limits.max_pixels, bytes_left_ / 4);
    Result<ImageData> data = decodeImage(image.image, where, encoding, limits);
    if (!data.ok()) {
      fault_ = data.error();
      return -1;
    }
    for (float value : data->floats)
      if (!std::isfinite(value)) {
        fault_ = fmt::format("{}: pixels: {}; a texture must be finite", where, value);
        return -1;
      }
    data->name = image.name;
    const uint64_t bytes = data->bytes.size() + data->floats.size() * 4;
    bytes_left_ -= std::min(bytes_left_, bytes);
    scene_.images.push_back(std::move(*data));
    return entry->second = static_cast<int>(scene_.images.size()) - 1;
  }

  const tinygltf::Model& model_;
  SceneData& scene_;
  ImageLimits limits_;
  uint64_t bytes_left_;
  std::map<std::pair<int, ColorEncoding>, int> indices_;
  std::string fault_;
};

float emissiveStrength(const tinygltf::Material& material) {
  const auto extension = material.extensions.find("KHR_materials_emissive_strength");
  if (extension == material.extensions.end() || !extension->second.Has("emissiveStrength"))
    return 1;
  return static_cast<float>(extension->second.Get("emissiveStrength").GetNumberAsDouble());
}

}  // namespace

Status convertMaterials(const tinygltf::Model& model, const GltfLimits& limits, SceneData& scene) {
  Images images(model, limits, scene);
  for (const tinygltf::Material& source : model.materials) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    MaterialData material;
    material.name = source.name;
    for (int c = 0; c < 4; ++c)
      material.base_color[c] = static_cast<float>(pbr.baseColorFactor[static_cast<size_t>(c)]);
    for (int c = 0; c < 3; ++c)
      material.emissive[c] = static_cast<float>(source.emissiveFactor[static_cast<size_t>(c)]);
    material.emissive *= emissiveStrength(source);
    material.metallic = static_cast<float>(pbr.metallicFactor);
    material.roughness = static_cast<float>(pbr.roughnessFactor);
    material.normal_scale = static_cast<float>(source.normalTexture.scale);
    material.base_color_map = images.use(pbr.baseColorTexture.index, ColorEncoding::Srgb);
    material.metallic_roughness_map =
        images.use(pbr.metallicRoughnessTexture.index, ColorEncoding::Linear);
    material.normal_map = images.use(source.normalTexture.index, ColorEncoding::Linear);
    material.emissive_map = images.use(source.emissiveTexture.index, ColorEncoding::Srgb);
    if (!images.fault().empty()) return Error{images.fault()};
    material.alpha_mode = source.alphaMode == "MASK"    ? AlphaMode::Mask
                          : source.alphaMode == "BLEND" ? AlphaMode::Blend
                                                        : AlphaMode::Opaque;
    material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
    material.double_sided = source.doubleSided;
    scene.materials.push_back(std::move(material));
  }
  return Done{};
}

}  // namespace scree::gltf
