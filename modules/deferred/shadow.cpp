// deferred.shadow: fits the sun's view to all casters, clears the shadow map, draws casting meshes.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/shadow_fit.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

constexpr int kFirstInstance = 0;  // uniform location

struct ShadowPass {
  gpu::Program solid{{.name = "deferred.caster", .vertex = "deferred/caster.vert"}};
  gpu::Program masked{{.name = "deferred.caster_mask",
                       .vertex = "deferred/caster.vert",
                       .fragment = "deferred/caster_mask.frag",
                       .defines = {"ALPHA_MASK"}}};
  void draw(DeferredState& state);
};

void fit(DeferredState& state, int output_height) {
  World& world = state.world;
  const ShadowSettings& settings = world.singleton<const ShadowSettings>();
  ShadowView& view = world.singleton<ShadowView>();
  view.block = fitShadowView(world.singleton<const ShadowCasters>().spheres,
                             world.singleton<const View>().position, world.singleton<const Sun>().to_sun,
                             shadowMapSide(settings, output_height), settings.max_distance_m);
  state.blocks.write(view.block).bindUniform(rules::kShadowViewBinding);
}

void ShadowPass::draw(DeferredState& state) {
  if (state.batches.castingCount() == 0) return;
  MeshStore& meshes = state.world.singleton<MeshStore>();
  MaterialStore& materials = state.world.singleton<MaterialStore>();
  meshes.vertexArray().bind();
  state.caster_records.bindStorage(rules::kInstancesBinding);
  gpu::apply(shadowDrawState());
  for (const MeshBatch& batch : state.batches.casting()) {
    for (const MeshPart& part : meshes.mesh(batch.mesh).parts) {
      const uint32_t material = batch.material == MeshInstance::kOwnMaterials ? part.material : batch.material;
      const bool has_holes = (state.materials.features(material) & kFeatureAlphaMask) != 0;
      gpu::Program& program = has_holes ? masked : solid;
      if (!program.use()) continue;
      if (has_holes) {
        state.materials.bind(material);
        materials.bind(material);
      }
      program.set(kFirstInstance, batch.first);
      gpu::drawElementsInstanced(GL_TRIANGLES, static_cast<int>(part.index_count), GL_UNSIGNED_INT,
                                 size_t{part.first_index} * sizeof(uint32_t),
                                 static_cast<int>(batch.count), part.base_vertex);
    }
  }
}

}  // namespace

PassDesc shadowPass(const SharedState& state) {
  const auto pass = std::make_shared<ShadowPass>();
  return {.name = "deferred.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a sun and a shadow caster",
          .needs = [state] { return shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, pass](PassContext& context) {
            fit(*state, context.input.size.y);
            context.framebuffer->clearDepth(0);
            pass->draw(*state);
          }};
}

}  // namespace scree
