// grains.sink: regions swallow the grains in them.
#include <algorithm>

#include "modules/grains/region.h"

namespace scree::grains {
namespace {

bool byEntity(const Swallowed& a, const Swallowed& b) { return a.entity < b.entity; }

void swallow(GrainsState& state) {
  World& world = state.world;
  const dvec3 origin = fieldOrigin(world);
  state.entities.clear();
  state.sinks.each([&](Entity entity, const Transform&, const GrainSink& sink) {
    if (sink.on && (sink.most == 0 || sink.count < sink.most)) state.entities.push_back(entity);
  });
  std::sort(state.entities.begin(), state.entities.end());
  std::vector<Entity>& doomed = state.doomed;  // sorted
  std::vector<Swallowed>& inside = state.inside;
  doomed.clear();
  for (const Entity entity : state.entities) {
    const Transform& transform = *world.peek<Transform>(entity);
    const GrainSink& sink = *world.peek<GrainSink>(entity);
    std::string wrong = fault(sink);
    if (wrong.empty()) wrong = faultOf(transform, origin, glm::max(sink.half_extent, sink.radius));
    if (!wrong.empty()) {
      refuse(state.refused_sinks, world, "grains.sink", "GrainSink", entity, wrong);
      continue;
    }
    const Region region = regionOf(transform, sink.half_extent, sink.radius, origin);
    inside.clear();
    eachGrainNear(state, region.low, region.high, [&](const SeenGrain& grain) {
      if (region.holds(grain.position) &&
          !std::binary_search(doomed.begin(), doomed.end(), grain.entity))
        inside.push_back({grain.entity, volumeOf(grain.radius) * static_cast<double>(grain.density)});
    });
    if (inside.empty()) continue;
    std::sort(inside.begin(), inside.end(), byEntity);
    if (sink.most > 0) inside.resize(std::min<size_t>(inside.size(), sink.most - sink.count));
    GrainSink& counted = *world.find<GrainSink>(entity);
    counted.count += inside.size();
    for (const Swallowed& grain : inside) {
      counted.mass += grain.mass;
      doomed.push_back(grain.entity);
    }
    std::sort(doomed.begin(), doomed.end());
  }
  closeRefusals(state.refused_sinks);
  if (!doomed.empty()) world.destroyMany(doomed);
}

}  // namespace

SystemDesc sinkSystem(const SharedState& state) {
  return {.name = "grains.sink",
          .phase = Phase::Simulate,
          .needs = [state] { return !state->sinks.empty() && !state->grains.empty(); },
          .run = [state](World&) { swallow(*state); }};
}

}  // namespace scree::grains
