// deferred.shadow: draws casting meshes. The depth of those that stand still is kept between frames.
#include <algorithm>

#include "engine/core/log.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/mesh_array.h"
#include "modules/deferred/shadow_fit.h"
#include "modules/deferred/shadow_map.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

struct ShadowPass {
  gpu::Program solid{{.name = "deferred.caster", .vertex = "deferred/caster.vert"}};
  gpu::Program masked{{.name = "deferred.caster_mask",
                       .vertex = "deferred/caster.vert",
                       .fragment = "deferred/caster_mask.frag",
                       .defines = {"ALPHA_MASK"}}};
  MeshArray array{"deferred.shadow", 3, false, sizeof(rules::MeshCasterRecord)};
  // The still casters alone, as long as others are drawn into the shadow map itself.
  gpu::Texture kept_map;
  gpu::Framebuffer kept_target;
  uint64_t kept_view = 0, kept_version = 0;  // what kept_map shows; 0: nothing yet

  void run(DeferredState& state, PassContext& context);
  void drawStill(DeferredState& state, const ShadowFit& fit, PassContext& context);
  void draw(DeferredState& state, const ShadowFit& fit, bool still);
};

void ShadowPass::draw(DeferredState& state, const ShadowFit& fit, bool still) {
  const MeshBatches& batches = state.batches;
  const size_t count = batches.castingCount(still);
  if (count == 0) return;
  const gpu::StreamSlice records = state.instances.allocate(count * sizeof(rules::MeshCasterRecord));
  batches.writeCasting(still, fit, {static_cast<rules::MeshCasterRecord*>(records.data), count});
  MeshStore& meshes = state.world.singleton<MeshStore>();
  MaterialStore& materials = state.world.singleton<MaterialStore>();
  array.bind(meshes, records);
  gpu::apply(shadowDrawState());
  for (const MeshBatch& batch : batches.casting(still)) {
    for (const MeshPart& part : meshes.mesh(batch.mesh).parts) {
      const uint32_t material = materialOf(batch, part);
      const bool has_holes = (state.materials.features(material) & kFeatureAlphaMask) != 0;
      gpu::Program& program = has_holes ? masked : solid;
      if (!program.use()) continue;
      if (has_holes) {
        state.materials.bind(material);
        materials.bind(material);
      }
      gpu::drawElementsInstanced(GL_TRIANGLES, static_cast<int>(part.index_count), GL_UNSIGNED_INT,
                                 size_t{part.first_index} * sizeof(uint32_t),
                                 static_cast<int>(batch.count), part.base_vertex, batch.first);
    }
  }
}

// Copies the kept map over all of the shadow map that is read, after drawing it anew if need be.
void ShadowPass::drawStill(DeferredState& state, const ShadowFit& fit, PassContext& context) {
  if (!kept_map) {
    kept_map = gpu::Texture("deferred.kept_shadows", {.format = GL_DEPTH_COMPONENT16,
                                                      .size = ivec2(rules::kShadowMapSize)});
    kept_target = gpu::Framebuffer("deferred.kept_shadows");
    kept_target.attachDepth(kept_map);
    if (Status done = kept_target.finish(); !done.ok()) fail("deferred.shadow: " + done.error());
  }
  const uint64_t view = state.world.singleton<const ShadowView>().version;
  const uint64_t version = state.batches.stillVersion();
  if (kept_view != view || kept_version != version) {
    kept_target.bind();
    kept_target.clearDepth(0);
    draw(state, fit, true);
    context.framebuffer->bind();
    kept_view = view;
    kept_version = version;
  }
  // The filter reads past the used part.
  const int side = std::min(fit.side + static_cast<int>(rules::kShadowFilterTexels), rules::kShadowMapSize);
  glCopyImageSubData(kept_map.id(), GL_TEXTURE_2D, 0, 0, 0, 0,
                     context.frame.texture(kShadowMap).id(), GL_TEXTURE_2D, 0, 0, 0, 0, side, side, 1);
}

void ShadowPass::run(DeferredState& state, PassContext& context) {
  ShadowMap& map = state.world.singleton<ShadowMap>();
  bindShadowView(state);
  const MeshBatches& batches = state.batches;
  const size_t still = batches.castingCount(true), moving = batches.castingCount(false);
  const bool others = state.world.singleton<const ShadowCasters>().spheres.size() > still + moving;
  if (still > 0 && (moving > 0 || others)) {
    drawStill(state, map.fit, context);
    draw(state, map.fit, false);
  } else {
    context.framebuffer->clearDepth(0);
    draw(state, map.fit, still > 0);
  }
  map.shown = map.due;
}

}  // namespace

void bindShadowView(DeferredState& state) {
  state.blocks.write(state.world.singleton<const ShadowView>().block).bindUniform(rules::kShadowViewBinding);
}

PassDesc shadowPass(const SharedState& state) {
  const auto pass = std::make_shared<ShadowPass>();
  return {.name = "deferred.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a shadow that has changed",
          .needs = [state] { return shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, pass](PassContext& context) { pass->run(*state, context); }};
}

}  // namespace scree
