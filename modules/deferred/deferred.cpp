// Registration: the targets, systems and passes of the module, in the order of the frame.
#include "modules/deferred/deferred.h"

#include "engine/app/app.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/shadow_map.h"
#include "modules/deferred/state.h"

namespace scree {

DeferredState::DeferredState(App& app)
    : world(app.world()),
      frame(app.frame()),
      lights(world.query<const Light, const Transform>()),
      batches(world) {}

std::vector<Use> gbufferUses(std::vector<Use> extra) {
  std::vector<Use> uses = {{std::string(kGbufferAlbedo), Access::Color},
                           {std::string(kGbufferNormal), Access::Color},
                           {std::string(kGbufferMotion), Access::Color},
                           {std::string(kGbufferId), Access::Color},
                           {std::string(kGbufferDepth), Access::Depth}};
  uses.insert(uses.end(), extra.begin(), extra.end());
  return uses;
}

std::vector<Use> shadowUses(std::vector<Use> extra) {
  std::vector<Use> uses = {{std::string(kShadowMap), Access::Depth}};
  uses.insert(uses.end(), extra.begin(), extra.end());
  return uses;
}

gpu::DrawState shadowDrawState() {
  // Both sides cast: the filter's bias lies with the receiver, and thin sheets have one side only.
  return {.depth_clamp = true, .cull = gpu::Cull::None, .color_write = false};
}

gpu::Program fullScreenProgram(std::string name, std::vector<std::string> defines, std::string vertex) {
  gpu::ProgramDesc desc;
  desc.vertex = std::move(vertex);
  desc.fragment = "deferred/" + name.substr(name.find('.') + 1) + ".frag";
  desc.name = std::move(name);
  desc.defines = std::move(defines);
  return gpu::Program(std::move(desc));
}

void addDeferred(App& app) {
  const auto state = std::make_shared<DeferredState>(app);
  World& world = app.world();
  world.singleton<ShadowCasters>();
  world.singleton<ShadowSettings>();
  world.singleton<ShadowView>();
  world.singleton<ShadowMap>();
  world.singleton<Sun>();
  world.singleton<Exposure>();

  app.addTarget(std::string(kGbufferAlbedo), {.format = GL_RGBA8});
  app.addTarget(std::string(kGbufferNormal), {.format = GL_RGBA8});
  app.addTarget(std::string(kGbufferEmissive), {.format = GL_R11F_G11F_B10F});
  app.addTarget(std::string(kGbufferMotion), {.format = GL_RG16F});
  app.addTarget(std::string(kGbufferId), {.format = GL_R32UI});
  app.addTarget(std::string(kGbufferDepth), {.format = GL_DEPTH_COMPONENT32F});
  app.frame().addExternal(std::string(kGbufferSpread));
  app.addTarget(std::string(kShadowMap),
                {.format = GL_DEPTH_COMPONENT16,
                 .fixed_size = ivec2(rules::kShadowMapSize),
                 .sampling = {.filter = gpu::Filter::Linear, .shadow = true}});
  app.addTarget(std::string(kRadiance), {.format = GL_RGBA16F});
  app.addTarget(std::string(kTruth), {.format = GL_RGBA32F});

  app.addSystem(lightSystem(state));
  app.addSystem(gatherSystem(state));

  app.addPass({.name = "deferred.clear",
               .stage = Stage::Geometry,
               .uses = {{std::string(kGbufferEmissive), Access::Clear},
                        {std::string(kGbufferId), Access::Clear},
                        {std::string(kGbufferDepth), Access::Clear}}});
  // Before the opaque pass: copying the kept shadows waits for the draws before it where a CPU draws.
  app.addPass(shadowPass(state));
  app.addPass(opaquePass(state));
  app.addPass(emissivePass(state));
  app.addPass(lightPass(state, ShadesInto::Radiance));
  app.addPass(skyPass(state, ShadesInto::Radiance));
  app.addPass(accumulatePass(state));
  app.addPass(lightPass(state, ShadesInto::Display));
  app.addPass(skyPass(state, ShadesInto::Display));
  app.addPass(presentPass(state));
}

}  // namespace scree
