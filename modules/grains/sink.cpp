// grains.sink: regions swallow the grains in them.
#include <algorithm>
#include <tuple>

#include "modules/grains/region.h"

namespace scree::grains {
namespace {

// Clumps whole. By entity alone they would not be: handles used again come in any order.
bool byWhole(const Swallowed& a, const Swallowed& b) {
  return std::tie(a.whole, a.entity) < std::tie(b.whole, b.entity);
}

// The members of those clumps of which a member is inside. Their first member knows none of them, so all
// members are looked through.
void takeWholeClumps(GrainsState& state) {
  std::vector<Entity>& first = state.swallowed_clumps;
  first.clear();
  for (const Swallowed& grain : state.inside)
    if (const GrainClump* clump = state.world.peek<GrainClump>(grain.entity)) first.push_back(clump->first);
  if (first.empty()) return;
  std::sort(first.begin(), first.end());
  std::erase_if(state.inside,
                [&](const Swallowed& grain) { return state.world.peek<GrainClump>(grain.entity) != nullptr; });
  state.members.each([&](Entity entity, const GrainClump& clump) {
    if (!std::binary_search(first.begin(), first.end(), clump.first)) return;
    const Grain& grain = *state.world.peek<Grain>(entity);
    const GrainMaterial& material = *state.world.peek<GrainMaterial>(entity);
    state.inside.push_back({clump.first, entity, volumeOf(grain.radius) * static_cast<double>(material.density)});
  });
}

// How many of `inside`, sorted, a sink takes that has room for `room`: whole clumps.
size_t wholeUpTo(std::span<const Swallowed> inside, size_t room) {
  if (inside.size() <= room) return inside.size();
  while (room < inside.size() && inside[room].whole == inside[room - 1].whole) ++room;
  return room;
}

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
        inside.push_back({grain.entity, grain.entity,
                          volumeOf(grain.radius) * static_cast<double>(grain.density)});
    });
    if (inside.empty()) continue;
    if (!state.members.empty()) takeWholeClumps(state);
    std::sort(inside.begin(), inside.end(), byWhole);
    if (sink.most > 0) inside.resize(wholeUpTo(inside, sink.most - sink.count));
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
