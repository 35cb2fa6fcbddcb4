// grains.push: the world's forces and blows, for the step that follows; and impulseInSphere().
#include <algorithm>

#include "modules/grains/region.h"

namespace scree {
namespace grains {
namespace {

void gatherForces(GrainsState& state, const dvec3& origin) {
  World& world = state.world;
  state.entities.clear();
  state.force_query.each([&](Entity entity, const Transform&, const GrainForce& force) {
    if (force.on) state.entities.push_back(entity);
  });
  std::sort(state.entities.begin(), state.entities.end());
  for (const Entity entity : state.entities) {
    const Transform& transform = *world.peek<Transform>(entity);
    const GrainForce& force = *world.peek<GrainForce>(entity);
    std::string wrong = fault(force);
    if (wrong.empty()) wrong = faultOf(transform, origin, force.half_extent);
    if (!wrong.empty()) {
      refuse(state.refused_forces, world, "grains.push", "GrainForce", entity, wrong);
      continue;
    }
    const Region region = regionOf(transform, force.half_extent, 0, origin);
    state.forces.push_back({.centre = region.centre,
                            .world_from_local = region.world_from_local,
                            .half = region.half,
                            .low = region.low,
                            .high = region.high,
                            .acceleration = region.world_from_local * force.acceleration,
                            .attraction = force.attraction,
                            .falloff = force.falloff,
                            .drag = force.drag,
                            .flow = region.world_from_local * force.flow,
                            .swirl = force.swirl,
                            .wake_above = force.wake_above});
  }
  closeRefusals(state.refused_forces);
}

// Each blow once: refused ones, too, are gone afterwards.
void gatherBlows(GrainsState& state, const dvec3& origin) {
  World& world = state.world;
  state.entities.clear();
  state.blow_query.each([&](Entity entity, const Transform&, const GrainBlow&) {
    state.entities.push_back(entity);
  });
  std::sort(state.entities.begin(), state.entities.end());
  for (const Entity entity : state.entities) {
    const Transform& transform = *world.peek<Transform>(entity);
    const GrainBlow blow = *world.peek<GrainBlow>(entity);
    std::string wrong = fault(blow);
    if (wrong.empty()) wrong = faultOf(transform, origin, vec3(0));
    if (!wrong.empty()) {
      refuse(state.refused_blows, world, "grains.push", "GrainBlow", entity, wrong);
    } else {
      state.blows.push_back({vec3(transform.position - origin), blow.radius, blow.strength});
    }
    if (blow.fleeting) {
      world.destroy(entity);
    } else {
      world.remove<GrainBlow>(entity);
    }
  }
  closeRefusals(state.refused_blows);
}

void gather(GrainsState& state) {
  const dvec3 origin = fieldOrigin(state.world);
  state.forces.clear();
  state.blows.clear();
  gatherForces(state, origin);
  gatherBlows(state, origin);
}

}  // namespace

SystemDesc pushSystem(const SharedState& state) {
  return {.name = "grains.push",
          .phase = Phase::Simulate,
          // Once more after the last of them has gone: without grains, no step has used them up.
          .needs =
              [state] {
                return !state->force_query.empty() || !state->blow_query.empty() ||
                       !state->forces.empty() || !state->blows.empty();
              },
          .run = [state](World&) { gather(*state); }};
}

}  // namespace grains

void impulseInSphere(World& world, const dvec3& centre, float radius, float strength) {
  Transform transform;
  transform.position = centre;
  world.spawn(transform, GrainBlow{.radius = radius, .strength = strength, .fleeting = true});
}

}  // namespace scree
