// impostors.visible, impostors.visible_late, impostors.resolve.
#include <memory>

#include "engine/app/app.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/impostors/impostors.h"
#include "modules/lod/lod.h"

namespace scree {
namespace {

constexpr const char* kTiles = "impostors.tiles";

struct Impostors {
  explicit Impostors(App& app) : world(app.world()) {}

  World& world;
  gpu::Program visible = visibleProgram("visible", {}), counting = visibleProgram("visible", {"OVERDRAW 1"});
  gpu::Program small = visibleProgram("small", {}), small_counting = visibleProgram("small", {"OVERDRAW 1"});
  MarkedTiles tiles{kTiles};
  gpu::Program still = resolveProgram({}), moving = resolveProgram({"MOTION"});
  gpu::Program empty{{.name = "impostors.empty_tiles", .compute = "lib/empty_tiles.comp"}};

  static gpu::Program visibleProgram(const std::string& what, std::vector<std::string> defines) {
    return gpu::Program({.name = "impostors." + what + (defines.empty() ? "" : "_counting"),
                         .vertex = "impostors/" + what + ".vert",
                         .fragment = "impostors/" + what + ".frag",
                         .defines = std::move(defines)});
  }
  static gpu::Program resolveProgram(std::vector<std::string> defines) {
    return gpu::Program({.name = defines.empty() ? "impostors.resolve" : "impostors.resolve_motion",
                         .vertex = "impostors/resolve.vert",
                         .fragment = "impostors/resolve.frag",
                         .defines = std::move(defines)});
  }
  const SwarmsDrawn& swarms() { return world.singleton<const SwarmsDrawn>(); }
  // Calls each(part) with its grains and its shape's atlas bound.
  template <class Each>
  void eachPart(const Each& each) {
    const SwarmsDrawn& drawn = swarms();
    ImpostorStore& store = world.singleton<ImpostorStore>();
    for (size_t k = 0; k < drawn.size(); ++k) {
      const SwarmPart& part = drawn.part(k);
      if (store.find(part.shape) == nullptr) continue;
      drawn.bind(k);
      store.bind(part.shape);
      each(part);
    }
  }
  // `first`: rules::kFirst, or 0.
  void drawVisible(const Frame& frame, uint32_t first) {
    const bool counts = frame.isRead(kSwarmOverdraw);
    // Numbers of grains are whole, and never blended.
    gpu::apply({.cull = gpu::Cull::None, .blend = counts ? gpu::Blend::Add : gpu::Blend::None, .program_point_size = true});
    tiles.bind();
    // Where one vertex of many is clipped, llvmpipe takes all of them through a slower path.
    const float guard = gpu::widenViewport();
    const auto draw = [&](gpu::Program& program, unsigned mode, uint32_t representation) {
      if (!swarms().mayBe(representation) || !program.use()) return;
      program.set(0, guard);
      const size_t command =
          offsetof(rules::SwarmCommands, impostors) + (representation + first) * sizeof(rules::DrawArraysCommand);
      eachPart([&](const SwarmPart& part) { gpu::drawVertexlessIndirect(mode, *part.commands, command); });
    };
    draw(counts ? counting : visible, GL_TRIANGLES, rules::kImpostor);
    draw(counts ? small_counting : small, GL_POINTS, rules::kSmallImpostor);
    gpu::setViewport(gpu::viewport());
  }
  void resolve(PassContext& context) {
    if (!(context.frame.isRead(kGbufferMotion) ? moving : still).use()) return;
    context.frame.texture(kSwarmVisible).bind(rules::kPassTextureUnit);
    // Behind what is nearer than the grain's surface it stays hidden, whatever was drawn since.
    gpu::apply({.depth_func = gpu::Compare::GreaterEqual, .cull = gpu::Cull::None});
    eachPart([this](const SwarmPart&) { tiles.draw(); });
    if (empty.use()) tiles.empty();
  }
};

}  // namespace

void addImpostors(App& app) {
  app.world().singleton<ImpostorStore>();
  const auto impostors = std::make_shared<Impostors>(app);
  const auto needs = [impostors] { return impostors->swarms().mayBe(rules::kImpostor) || impostors->swarms().mayBe(rules::kSmallImpostor); };
  constexpr const char* kNeeds = "a swarm that may be impostors";
  const std::string visible(kSwarmVisible), overdraw(kSwarmOverdraw), depth(kGbufferDepth), lists(kSwarmLists), late_lists(kSwarmLateLists);
  app.frame().addExternal(kTiles);
  app.addSystem({.name = "impostors.give_back",
                 .phase = Phase::Prepare,
                 .needs = [impostors] { return impostors->tiles.held() && impostors->swarms().size() == 0; },
                 .run = [impostors](World&) { impostors->tiles.giveBack(); }});

  app.addPass({.name = "impostors.visible",
               .stage = Stage::Geometry,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {lists},
               .uses = {{visible, Access::Color},
                        {overdraw, Access::Color},
                        {depth, Access::Depth},
                        {lists, Access::Indirect},
                        {lists, Access::StorageRead},
                        {kTiles, Access::StorageWrite}},
               .run = [impostors](PassContext& context) {
                 impostors->tiles.ready(context.input.size);
                 impostors->drawVisible(context.frame, rules::kFirst);
               }});
  app.addPass({.name = "impostors.visible_late",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {late_lists, visible},
               .uses = {{visible, Access::Color},
                        {overdraw, Access::Color},
                        {depth, Access::Depth},
                        {late_lists, Access::Indirect},
                        {late_lists, Access::StorageRead},
                        {kTiles, Access::StorageWrite}},
               .run = [impostors](PassContext& context) { impostors->drawVisible(context.frame, 0); }});
  app.addPass({.name = "impostors.resolve",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {visible},
               .uses = gbufferUses({{visible, Access::Sampled},
                                    {std::string(kSwarmRoutes), Access::StorageRead},
                                    {std::string(kGbufferSpread), Access::StorageWrite},
                                    {kTiles, Access::Indirect},
                                    {kTiles, Access::StorageWrite}}),
               .run = [impostors](PassContext& context) { impostors->resolve(context); }});
}

}  // namespace scree
