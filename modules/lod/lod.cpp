// Registration: the systems and passes of the module, in the order of the frame.
#include "modules/lod/lod.h"

#include "engine/app/app.h"
#include "engine/gpu/gl.h"
#include "modules/lod/state.h"
#include "modules/lod/sun_map.h"

namespace scree {

SwarmsDrawn::State::State(World& world_in)
    : world(world_in), swarms(world_in.query<const Swarm, const Transform>()), sun_map(std::make_shared<lod::SunMap>()) {}

size_t SwarmsDrawn::size() const { return state->parts.size(); }
uint64_t SwarmsDrawn::grainCount() const { return state->grain_count; }
const SwarmPart& SwarmsDrawn::part(size_t index) const { return state->parts[index]; }
bool SwarmsDrawn::mayBe(uint32_t representation) const {
  return (state->possible >> representation & 1) != 0;
}
void SwarmsDrawn::bind(size_t index) const {
  const lod::Part& part = state->parts[index];
  part.late.bindUniform(rules::kPassBinding);
  part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
  part.chunk->runs.bindStorage(rules::kSwarmRunsBinding);
  part.routes->order.bindStorage(rules::kSwarmOrderBinding);
  part.routes->representations.bindStorage(rules::kSwarmRepresentationsBinding);
  part.routes->seen.bindStorage(rules::kSwarmSeenBinding);
  part.routes->list.bindStorage(rules::kSwarmListBinding);
  part.routes->commands.bindStorage(rules::kSwarmCommandsBinding);
}

void addLod(App& app) {
  World& world = app.world();
  const auto state = std::make_shared<SwarmsDrawn::State>(world);
  world.singleton<SwarmStore>();
  world.singleton<LodSettings>();
  world.singleton<SwarmsDrawn>().state = state;

  for (const std::string_view resource : {kSwarmRoutes, kSwarmLists, kSwarmLateLists})
    app.frame().addExternal(std::string(resource));

  app.addSystem(lod::uploadSystem(state));
  app.addSystem(lod::giveBackSystem(state));

  app.addTarget(std::string(kSwarmVisible), {.format = GL_R32UI});
  // Counts up to 2,048.
  app.addTarget(std::string(kSwarmOverdraw), {.format = GL_R16F});
  app.addTarget(std::string(kPointOverdraw), {.format = GL_R32UI});
  app.frame().addExternal(lod::kSeen);
  app.frame().keep(lod::kSeen, true);  // by the next frame

  app.addPass(lod::classifyPass(state));
  app.addPass(lod::listPass(state));
  app.addPass({.name = "lod.clear",
               .stage = Stage::Geometry,
               .uses = {{std::string(kSwarmVisible), Access::Clear},
                        {std::string(kSwarmOverdraw), Access::Clear},
                        {std::string(kPointOverdraw), Access::Clear}}});
  app.addPass(lod::shadowPass(state));
  app.addPass(lod::meshPass(state));
  app.addPass(lod::lateListPass(state));
  app.addPass(lod::lateMeshPass(state));
  app.addPass(lod::seePass(state));
  app.addPass(lod::viewRoutesPass(state));
  app.addPass(lod::viewTurnsPass(state));
  app.addPass(lod::viewOverdrawPass(state));
}

}  // namespace scree
