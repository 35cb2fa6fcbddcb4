// deferred.opaque: draws mesh instances into the G-buffer.
#include <array>

#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

constexpr int kFirstInstance = 0;  // uniform location

gpu::Program opaqueProgram(uint32_t features) {
  gpu::ProgramDesc desc{.name = "deferred.opaque", .vertex = "deferred/opaque.vert", .fragment = "deferred/opaque.frag"};
  const auto define = [&](uint32_t bits, const char* name) {
    if (features & bits) desc.defines.push_back(name);
  };
  define(kFeatureMaps, "TEXTURED");
  define(kFeatureBaseColorMap, "BASE_COLOR_MAP");
  define(kFeatureMetallicRoughnessMap, "METALLIC_ROUGHNESS_MAP");
  define(kFeatureNormalMap, "NORMAL_MAP");
  define(kFeatureEmissiveMap, "EMISSIVE_MAP");
  define(kFeatureAlphaMask, "ALPHA_MASK");
  define(kFeatureDoubleSided, "DOUBLE_SIDED");
  return gpu::Program(std::move(desc));
}

struct OpaquePass {
  std::array<gpu::Program, kFeatureSets> programs;
  std::array<bool, kFeatureSets> made{};

  gpu::Program& program(uint32_t features) {
    if (!made[features]) programs[features] = opaqueProgram(features);
    made[features] = true;
    return programs[features];
  }
  void draw(DeferredState& state);
};

void OpaquePass::draw(DeferredState& state) {
  MeshStore& meshes = state.world.singleton<MeshStore>();
  MaterialStore& materials = state.world.singleton<MaterialStore>();
  meshes.vertexArray().bind();
  state.opaque_records.bindStorage(rules::kInstancesBinding);
  gpu::DrawState draw_state;
  for (const MeshBatch& batch : state.batches.opaque()) {
    for (const MeshPart& part : meshes.mesh(batch.mesh).parts) {
      const uint32_t material = batch.material == MeshInstance::kOwnMaterials ? part.material : batch.material;
      const uint32_t features = state.materials.features(material);
      gpu::Program& drawn_with = program(features);
      if (!drawn_with.use()) continue;
      draw_state.cull = features & kFeatureDoubleSided ? gpu::Cull::None
                        : batch.mirrored               ? gpu::Cull::Front
                                                       : gpu::Cull::Back;
      gpu::apply(draw_state);
      state.materials.bind(material);
      if (features & kFeatureMaps) materials.bind(material);
      drawn_with.set(kFirstInstance, batch.first);
      gpu::drawElementsInstanced(GL_TRIANGLES, static_cast<int>(part.index_count), GL_UNSIGNED_INT,
                                 size_t{part.first_index} * sizeof(uint32_t),
                                 static_cast<int>(batch.count), part.base_vertex);
    }
  }
}

}  // namespace

PassDesc opaquePass(const SharedState& state) {
  const auto pass = std::make_shared<OpaquePass>();
  return {.name = "deferred.opaque",
          .stage = Stage::Geometry,
          .needs_text = "a mesh instance in view",
          .needs = [state] { return state->batches.any() && state->batches.opaqueCount() > 0; },
          .uses = gbufferUses(),
          .run = [state, pass](PassContext&) { pass->draw(*state); }};
}

}  // namespace scree
