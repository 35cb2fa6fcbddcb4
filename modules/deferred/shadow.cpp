// deferred.shadow: fits the sun's view to all casters and draws casting meshes. The depth of what
// stands still is kept between frames.
#include "engine/core/log.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/mesh_array.h"
#include "modules/deferred/shadow_fit.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

// What a map of still casters shows.
struct Shown {
  ShadowFit fit;
  uint64_t still_version = 0;  // 0: nothing yet
  bool operator==(const Shown&) const = default;
};

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
  Shown kept;      // by kept_map
  Shown complete;  // by the shadow map, if it shows still casters and nothing else
  int side = 0;    // of the shadow map's used part, in the last run; around it the map is empty

  void clear(PassContext& context);
  void run(DeferredState& state, PassContext& context);
  void drawStill(DeferredState& state, const ShadowFit& fit, PassContext& context);
  void draw(DeferredState& state, const ShadowFit& fit, bool still);
};

void ShadowPass::clear(PassContext& context) {
  context.framebuffer->clearDepth(0);
  complete = Shown();
}

ShadowFit fit(DeferredState& state, int output_height) {
  World& world = state.world;
  const ShadowSettings& settings = state.shadow_settings;
  const dvec3 camera = world.singleton<const View>().position;
  const ShadowFit fit =
      fitShadow(world.singleton<const ShadowCasters>().spheres, camera,
                world.singleton<const Sun>().to_sun, shadowMapSide(settings, output_height),
                settings.max_distance_m);
  ShadowView& view = world.singleton<ShadowView>();
  if (view.version == 0 || !(fit == state.shadow_fit)) ++view.version;
  state.shadow_fit = fit;
  view.block = shadowViewBlock(fit, camera);
  state.blocks.write(view.block).bindUniform(rules::kShadowViewBinding);
  return fit;
}

void ShadowPass::draw(DeferredState& state, const ShadowFit& fit, bool still) {
  const MeshBatches& batches = state.batches;
  const size_t count = batches.castingCount(still);
  if (count == 0 || !fit.enabled) return;
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

// Copies the kept map over the shadow map's used part, after drawing it anew if need be.
void ShadowPass::drawStill(DeferredState& state, const ShadowFit& fit, PassContext& context) {
  if (!kept_map) {
    kept_map = gpu::Texture("deferred.kept_shadows", {.format = GL_DEPTH_COMPONENT16,
                                                      .size = ivec2(rules::kShadowMapSize)});
    kept_target = gpu::Framebuffer("deferred.kept_shadows");
    kept_target.attachDepth(kept_map);
    if (Status done = kept_target.finish(); !done.ok()) fail("deferred.shadow: " + done.error());
  }
  const Shown wanted{fit, state.batches.stillVersion()};
  if (kept != wanted) {
    kept_target.bind();
    kept_target.clearDepth(0);
    draw(state, fit, true);
    context.framebuffer->bind();
    kept = wanted;
  }
  glCopyImageSubData(kept_map.id(), GL_TEXTURE_2D, 0, 0, 0, 0,
                     context.frame.texture(kShadowMap).id(), GL_TEXTURE_2D, 0, 0, 0, 0, fit.side,
                     fit.side, 1);
}

void ShadowPass::run(DeferredState& state, PassContext& context) {
  const ShadowFit now = fit(state, context.input.size.y);
  const MeshBatches& batches = state.batches;
  const size_t still = batches.castingCount(true), moving = batches.castingCount(false);
  const bool others = state.world.singleton<const ShadowCasters>().spheres.size() > still + moving;
  if (context.first_run_after_off || side != now.side) clear(context);
  side = now.side;
  if (still > 0 && (moving > 0 || others)) {
    complete = Shown();
    drawStill(state, now, context);
    draw(state, now, false);
    return;
  }
  const Shown wanted{now, batches.stillVersion()};
  if (still > 0 && complete == wanted) return;
  clear(context);
  draw(state, now, still > 0);
  if (still > 0) complete = wanted;
}

}  // namespace

PassDesc shadowPass(const SharedState& state) {
  const auto pass = std::make_shared<ShadowPass>();
  return {.name = "deferred.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a sun and a shadow caster",
          .needs = [state] { return shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, pass](PassContext& context) { pass->run(*state, context); }};
}

}  // namespace scree
