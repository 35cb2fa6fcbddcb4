// deferred.light, deferred.display_light: shades what the G-buffer holds.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/lobe_table.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

gpu::Program lightProgram(std::vector<std::string> defines) {
  return fullScreenProgram("deferred.light", std::move(defines), "deferred/light.vert");
}

struct LightPass {
  explicit LightPass(ShadesInto target_in) : target(target_in) {}

  ShadesInto target;
  // One program a situation, so that a scene does not pay for a sun or shadows that it lacks.
  gpu::Program sky_only = lightProgram(shadedDefines(target));
  gpu::Program sun = lightProgram(shadedDefines(target, {"SUN"}));
  gpu::Program sun_and_shadows = lightProgram(shadedDefines(target, {"SUN", "SHADOWS"}));
  gpu::Program sun_and_hard_shadows =
      lightProgram(shadedDefines(target, {"SUN", "SHADOWS", "SHADOW_SINGLE_FETCH"}));
  gpu::Texture lobe_table;

  void draw(DeferredState& state, PassContext& context);
};

gpu::Texture uploadLobeTable() {
  gpu::Texture texture("deferred.lobe_table", {.format = GL_RGBA32F,
                                               .size = ivec2(rules::kLobeTableSize),
                                               .sampling = {.filter = gpu::Filter::Linear}});
  const std::vector<vec4> table = makeLobeTable();
  texture.upload(std::span(&table[0].x, table.size() * 4), 4);
  return texture;
}

void LightPass::draw(DeferredState& state, PassContext& context) {
  if (!lobe_table) lobe_table = uploadLobeTable();
  const bool shadows = context.frame.hasContent(kShadowMap) &&
                       state.world.singleton<const ShadowView>().block.enabled > 0;
  const bool shining = state.world.singleton<const Sun>().present;
  const bool hard = state.shadow_settings.single_fetch;
  gpu::Program& program = shadows ? (hard ? sun_and_hard_shadows : sun_and_shadows)
                          : shining ? sun
                                    : sky_only;
  if (!program.use()) return;
  setExposure(state, target, program);
  context.frame.bindSampled(kGbufferAlbedo, rules::kGbufferAlbedoUnit);
  context.frame.bindSampled(kGbufferNormal, rules::kGbufferNormalUnit);
  context.frame.bindSampled(kGbufferEmissive, rules::kGbufferEmissiveUnit);
  lobe_table.bind(rules::kLobeTableUnit);
  if (shadows) {
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
  for (const std::string_view read : {kGbufferAlbedo, kGbufferNormal, kGbufferEmissive, kGbufferDepth, kShadowMap})
    desc.uses.push_back({std::string(read), Access::Sampled});
  desc.uses.push_back({std::string(kGbufferDepth), Access::DepthTest});
  desc.run = [state, pass](PassContext& context) { pass->draw(*state, context); };
  return desc;
}

}  // namespace scree
