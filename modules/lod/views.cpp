// lod.view_routes, lod.view_turns, lod.view_overdraw: what a debug view shows in place of the picture.
#include "engine/gpu/draw.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"

namespace scree::lod {
namespace {

bool shows(const SharedState& state, SwarmView view) {
  return !state->parts.empty() && state->world.singleton<const LodSettings>().view == view;
}

PassDesc routesPass(const SharedState& state, const char* name, SwarmView view, std::vector<std::string> defines) {
  const auto program = std::make_shared<gpu::Program>(gpu::ProgramDesc{.name = name,
                                                                       .vertex = "lib/full_screen.vert",
                                                                       .fragment = "lod/view_routes.frag",
                                                                       .defines = std::move(defines)});
  return {.name = name,
          .stage = Stage::Present,
          .needs_text = "a swarm and a debug view of it",
          .needs = [state, view] { return shows(state, view); },
          .uses = {{std::string(Frame::kOutput), Access::Color},
                   {std::string(kGbufferId), Access::Sampled},
                   {std::string(kGbufferNormal), Access::Sampled},
                   {std::string(kSwarmRoutes), Access::StorageRead}},
          .run = [state, program](PassContext& context) {
            if (!program->use()) return;
            context.frame.texture(kGbufferId).bind(rules::kGbufferIdUnit);
            context.frame.texture(kGbufferNormal).bind(rules::kGbufferNormalUnit);
            for (const Part& part : state->parts) {
              part.late.bindUniform(rules::kPassBinding);
              part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
              part.routes->representations.bindStorage(rules::kSwarmRepresentationsBinding);
              gpu::drawFullScreen();
            }
          }};
}

}  // namespace

PassDesc viewRoutesPass(const SharedState& state) {
  return routesPass(state, "lod.view_routes", SwarmView::Representation, {});
}

PassDesc viewTurnsPass(const SharedState& state) {
  return routesPass(state, "lod.view_turns", SwarmView::Frozen, {"TURNS"});
}

PassDesc viewOverdrawPass(const SharedState& state) {
  const auto program = std::make_shared<gpu::Program>(gpu::ProgramDesc{
      .name = "lod.view_overdraw", .vertex = "lib/full_screen.vert", .fragment = "lod/view_overdraw.frag"});
  return {.name = "lod.view_overdraw",
          .stage = Stage::Present,
          .needs_text = "a swarm and a debug view of it",
          .needs = [state] { return shows(state, SwarmView::Overdraw); },
          .uses = {{std::string(Frame::kOutput), Access::Color},
                   {std::string(kSwarmOverdraw), Access::Sampled},
                   {std::string(kPointOverdraw), Access::Sampled}},
          .run = [program](PassContext& context) {
            if (!program->use()) return;
            context.frame.bindSampled(kSwarmOverdraw, rules::kPassTextureUnit);
            context.frame.bindSampled(kPointOverdraw, rules::kGbufferIdUnit);
            gpu::drawFullScreen();
          }};
}

}  // namespace scree::lod
