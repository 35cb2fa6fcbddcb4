// lod.give_back: memory of the GPU that frames with swarms need, and frames without do not.
#include "modules/lod/state.h"
#include "modules/lod/sun_map.h"

namespace scree::lod {
namespace {

// Whether something is kept that no frame will use before a swarm casts, or is drawn, again.
bool keepsMap(const SwarmsDrawn::State& state) { return !state.casts && state.sun_map->depth; }
bool keepsCandidates(const SwarmsDrawn::State& state) { return state.parts.empty() && state.candidates; }

}  // namespace

SystemDesc giveBackSystem(const SharedState& state) {
  return {.name = "lod.give_back",
          .phase = Phase::Prepare,
          .needs = [state] { return keepsMap(*state) || keepsCandidates(*state); },
          .run = [state](World&) {
            if (keepsMap(*state)) *state->sun_map = {};
            if (keepsCandidates(*state)) state->candidates = {};
          }};
}

}  // namespace scree::lod
