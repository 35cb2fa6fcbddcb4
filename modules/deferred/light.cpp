// deferred.light, deferred.display_light: shades what the G-buffer holds.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

gpu::Program lightProgram(std::vector<std::string> defines) {
  return fullScreenProgram("deferred.light", std::move(defines), "deferred/light.vert");
}

struct LightPrograms {
  gpu::Program sky_only, sun, sun_and_shadows, sun_and_hard_shadows;
};

struct LightPass {
  explicit LightPass(ShadesInto target_in) : target(target_in) {}

  ShadesInto target;
  // One program a situation, so that a scene does not pay for a sun, shadows or spread normals that it lacks.
  LightPrograms plain = programs({}), spread = programs({"GBUFFER_READ_SPREAD"});

  LightPrograms programs(const std::vector<std::string>& more) const;
  void draw(DeferredState& state, PassContext& context);
};

LightPrograms LightPass::programs(const std::vector<std::string>& more) const {
  const auto with = [&](std::vector<std::string> defines) {
    defines.insert(defines.end(), more.begin(), more.end());
    return lightProgram(shadedDefines(target, std::move(defines)));
  };
  return {with({}), with({"SUN"}), with({"SUN", "SHADOWS"}), with({"SUN", "SHADOWS", "SHADOW_SINGLE_FETCH"})};
}

void LightPass::draw(DeferredState& state, PassContext& context) {
  const bool shadows = state.world.singleton<const ShadowView>().block.enabled > 0;
  const bool shining = state.world.singleton<const Sun>().present;
  const bool hard = state.shadow_settings.single_fetch;
  const bool normals_spread = context.frame.hasContent(kGbufferSpread);
  LightPrograms& with = normals_spread ? spread : plain;
  gpu::Program& program = shadows ? (hard ? with.sun_and_hard_shadows : with.sun_and_shadows)
                          : shining ? with.sun
                                    : with.sky_only;
  if (!program.use()) return;
  setExposure(state, target, program);
  context.frame.bindSampled(kGbufferAlbedo, rules::kGbufferAlbedoUnit);
  context.frame.bindSampled(kGbufferNormal, rules::kGbufferNormalUnit);
  context.frame.bindSampled(kGbufferEmissive, rules::kGbufferEmissiveUnit);
  state.lobes.of(normals_spread).bind(rules::kLobeTableUnit);
  if (shadows) {
    // Where the map is kept, deferred.shadow, which else does it, is off.
    if (!context.frame.hasContent(kShadowMap)) bindShadowView(state);
    context.frame.bindSampled(kGbufferDepth, rules::kGbufferDepthUnit);
    context.frame.bindSampled(kShadowMap, rules::kShadowMapUnit);
  }
  // The triangle lies at depth 0: it passes where something nearer was drawn.
  gpu::apply({.depth_func = gpu::Compare::Less, .depth_write = false});
  gpu::drawFullScreen();
}

}  // namespace

PassDesc lightPass(const SharedState& state, ShadesInto target) {
  const auto pass = std::make_shared<LightPass>(target);
  PassDesc desc = shadePass(state, target, "light");
  desc.needs_content = {std::string(kGbufferId)};
  for (const std::string_view read : {kGbufferAlbedo, kGbufferNormal, kGbufferEmissive, kGbufferDepth, kShadowMap, kGbufferSpread})
    desc.uses.push_back({std::string(read), Access::Sampled});
  desc.uses.push_back({std::string(kGbufferDepth), Access::DepthTest});
  desc.run = [state, pass](PassContext& context) { pass->draw(*state, context); };
  return desc;
}

}  // namespace scree
