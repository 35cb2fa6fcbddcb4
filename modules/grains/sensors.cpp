// Sensors: loads on colliders, and grains inside boxes.
#include <algorithm>
#include <cmath>

#include "modules/grains/state.h"

namespace scree::grains {

void senseLoads(GrainsState& state) {
  state.loads.each([&](Entity entity, LoadSensor& sensor) {
    sensor.impulse = vec3(0);
    sensor.contacts = 0;
    // An entity's colliders of several shapes have consecutive keys.
    const auto first = std::lower_bound(
        state.colliders.begin(), state.colliders.end(), entity.index * 4,
        [](const Collider& collider, uint32_t key) { return collider.key < key; });
    for (auto it = first; it != state.colliders.end() && it->key / 4 == entity.index; ++it) {
      sensor.impulse += vec3(it->load);
      sensor.contacts += it->load_contacts;
    }
  });
}

void senseRegions(GrainsState& state, const dvec3& origin, bool asleep) {
  if (state.regions.empty() || (asleep && state.regions.version() == state.regions_seen)) return;
  state.regions.each([&](const Transform& transform, RegionSensor& sensor) {
    const mat3 world_from_local = glm::mat3_cast(glm::normalize(transform.rotation));
    const vec3 centre = vec3(transform.position - origin);
    const vec3 half = sensor.half_extent * glm::abs(transform.scale);
    uint32_t count = 0;
    // Nanograms as integers: a sum that does not depend on the order of the grains.
    int64_t mass = 0;
    state.world.query<const Grain, const GrainMaterial>().each(
        [&](const Grain& grain, const GrainMaterial& material) {
          const vec3 local = (grain.position - centre) * world_from_local;
          if (!(std::abs(local.x) <= half.x && std::abs(local.y) <= half.y &&
                std::abs(local.z) <= half.z))
            return;
          ++count;
          const double grain_mass = grainMass(grain.radius, material.density);
          mass += static_cast<int64_t>(std::min(grain_mass, 1e6) * 1e9);
        });
    sensor.count = count;
    sensor.mass = static_cast<float>(static_cast<double>(mass) * 1e-9);
  });
  state.regions_seen = state.regions.version();
}

}  // namespace scree::grains
