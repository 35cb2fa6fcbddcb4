// Checks material factors and uploads them, one aligned block a material.
#include "modules/deferred/material_block.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/core/log.h"
#include "engine/gpu/load.h"
#include "shaders/shared/gbuffer.h"

namespace scree {
namespace {

// NaN becomes `low`.
float checked(float value, float low, float high, std::string_view where, const char* field) {
  if (value >= low && value <= high) return value;
  const float used = value > high ? high : low;
  logWarning("{}: {} is {}, allowed are {} to {}; {} is used", where, field, value, low, high, used);
  return used;
}

uint32_t featuresOf(const MaterialData& m, const rules::MaterialConstants& constants) {
  const bool emits = vec3(constants.emissive) != vec3(0);
  return (m.base_color_map.image >= 0 ? kFeatureBaseColorMap : 0u) |
         (m.metallic_roughness_map.image >= 0 ? kFeatureMetallicRoughnessMap : 0u) |
         (m.normal_map.image >= 0 ? kFeatureNormalMap : 0u) |
         (emits && m.emissive_map.image >= 0 ? kFeatureEmissiveMap : 0u) |
         (m.alpha_mode == AlphaMode::Mask ? kFeatureAlphaMask : 0u) |
         (m.double_sided ? kFeatureDoubleSided : 0u) | (emits ? kFeatureEmission : 0u);
}

}  // namespace

rules::MaterialConstants checkedConstants(const MaterialData& m, std::string_view where) {
  rules::MaterialConstants c{};
  for (int i = 0; i < 4; ++i) c.base_color[i] = checked(m.base_color[i], 0, 1, where, "base colour");
  for (int i = 0; i < 3; ++i)
    c.emissive[i] = checked(m.emissive[i], 0, rules::kMaxEmissive, where, "emissive");
  c.metallic = checked(m.metallic, 0, 1, where, "metallic");
  c.roughness = checked(m.roughness, 0, 1, where, "roughness");
  c.normal_scale = checked(m.normal_scale, -100, 100, where, "normal scale");
  c.alpha_cutoff = checked(m.alpha_cutoff, 0, 1e6f, where, "alpha cutoff");
  return c;
}

void MaterialBlock::update(const MaterialStore& store) {
  const size_t known = constants_.size();
  if (known == store.size()) return;
  for (size_t i = known; i < store.size(); ++i) {
    const MaterialData& material = store.material(static_cast<uint32_t>(i));
    const std::string where = fmt::format("deferred: material {} \"{}\"", i, material.name);
    constants_.push_back(checkedConstants(material, where));
    features_.push_back(featuresOf(material, constants_.back()));
    if (material.alpha_mode == AlphaMode::Blend)
      logWarning("{}: alpha mode BLEND is drawn as OPAQUE", where);
  }
  const size_t alignment = gpu::limits().uniform_alignment;
  stride_ = (sizeof(rules::MaterialConstants) + alignment - 1) / alignment * alignment;
  std::vector<std::byte> bytes(stride_ * constants_.size());
  for (size_t i = 0; i < constants_.size(); ++i)
    std::memcpy(&bytes[i * stride_], &constants_[i], sizeof constants_[i]);
  gpu::reserve(buffer_, "deferred.materials", bytes.size());
  buffer_.upload(bytes.data(), bytes.size());
}

void MaterialBlock::bind(uint32_t material) const {
  buffer_.bindUniform(rules::kDrawBinding, material * stride_, sizeof(rules::MaterialConstants));
}

}  // namespace scree
