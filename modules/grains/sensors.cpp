// Sensors: loads on colliders, and grains inside boxes.
#include <algorithm>
#include <cmath>

#include "modules/grains/region.h"

namespace scree::grains {

void senseLoads(GrainsState& state) {
  state.loads.each([&](Entity entity, LoadSensor& sensor) {
    sensor.impulse = vec3(0);
    sensor.contacts = 0;
    const auto first = std::lower_bound(
        state.colliders.begin(), state.colliders.end(), firstKeyOf(entity),
        [](const Collider& collider, uint32_t key) { return collider.key < key; });
    for (auto it = first; it != state.colliders.end() && it->key / kKeysOfEntity == entity.index; ++it) {
      sensor.impulse += vec3(it->load);
      sensor.contacts += it->load_contacts;
    }
  });
}

namespace {

// Nanograms as integers: a sum that does not depend on the order of the grains.
struct Sum {
  uint32_t count = 0;
  int64_t mass = 0;
  void add(float radius, float density) {
    ++count;
    const double grain_mass = grainMass(radius, density);
    mass += static_cast<int64_t>(std::min(grain_mass, 1e6) * 1e9);
  }
};

// Kept until a sleeper wakes, one falls asleep, or the sensor changes.
Sum sumOfSleepers(GrainsState& state, const Region& region, const RegionOfSleepers& now, size_t at) {
  if (at >= state.regions_of_sleepers.size()) state.regions_of_sleepers.resize(at + 1);
  RegionOfSleepers& kept = state.regions_of_sleepers[at];
  const Transform &a = kept.transform, &b = now.transform;
  if (kept.entity == now.entity && kept.changes == now.changes && kept.origin == now.origin &&
      kept.half_extent == now.half_extent && a.position == b.position &&
      a.rotation == b.rotation && a.scale == b.scale)
    return {kept.count, kept.mass};
  Sum sum;
  eachSleeperNear(state, region.low, region.high, [&](uint32_t berth) {
    const Sleeper& sleeper = state.solver.sleepers()[berth];
    if (region.holds(sleeper.position)) sum.add(sleeper.radius, state.solver.sleepers().materialOf(berth).density);
  });
  kept = now;
  kept.count = sum.count;
  kept.mass = sum.mass;
  return sum;
}

}  // namespace

void senseRegions(GrainsState& state, const dvec3& origin, bool asleep) {
  if (state.regions.empty() || (asleep && state.regions.version() == state.regions_seen)) return;
  const bool solver_knows = state.solver.current();
  size_t at = 0;
  state.regions.each([&](Entity entity, const Transform& transform, RegionSensor& sensor) {
    const Region region = regionOf(transform, sensor.half_extent, 0, origin);
    Sum sum;
    if (solver_knows) {
      sum = sumOfSleepers(state, region,
                          {entity, transform, sensor.half_extent, origin,
                           state.solver.sleepers().changes(), 0, 0},
                          at++);
      state.solver.eachAwake([&](Entity, const Body& body, const GrainMaterial& material) {
        if (region.holds(body.position)) sum.add(body.radius, material.density);
      });
    } else {
      state.world.query<const Grain, const GrainMaterial>().each(
          [&](const Grain& grain, const GrainMaterial& material) {
            if (region.holds(grain.position)) sum.add(grain.radius, material.density);
          });
    }
    sensor.count = sum.count;
    sensor.mass = static_cast<float>(static_cast<double>(sum.mass) * 1e-9);
  });
  state.regions_seen = state.regions.version();
}

}  // namespace scree::grains
