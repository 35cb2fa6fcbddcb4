// Material constants on the GPU, and which program a material needs.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/gpu/objects.h"
#include "modules/scene/scene.h"
#include "shaders/shared/mesh_instance.h"

namespace scree {

// Bits that select the program of deferred.opaque or deferred.emissive.
enum MaterialFeature : uint32_t {
  kFeatureBaseColorMap = 1,
  kFeatureMetallicRoughnessMap = 2,
  kFeatureNormalMap = 4,
  kFeatureEmissiveMap = 8,
  kFeatureAlphaMask = 16,
  kFeatureDoubleSided = 32,
  kFeatureEmission = 64,
};
inline constexpr uint32_t kFeatureMaps = 15;
inline constexpr uint32_t kFeatureSets = 128;

// The constants of a material, with values that the shading does not allow (not finite, out of
// range) replaced by the nearest that it does; `where` names the material in the warning.
rules::MaterialConstants checkedConstants(const MaterialData& material, std::string_view where);

class MaterialBlock {
 public:
  // Takes in what was added to the store since the last call; uploads all constants if anything was.
  void update(const MaterialStore& store);
  uint32_t features(uint32_t material) const { return features_[material]; }
  // Binds the constants of one material to kDrawBinding.
  void bind(uint32_t material) const;

 private:
  gpu::Buffer buffer_;
  size_t stride_ = 0;
  std::vector<rules::MaterialConstants> constants_;
  std::vector<uint32_t> features_;
};

}  // namespace scree
