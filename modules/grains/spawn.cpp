// grains.spawn: blocks of grains become grains; and the functions that spawn grains.
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "engine/core/random.h"
#include "modules/grains/state.h"

namespace scree {
namespace grains {
namespace {

struct FoundBlock {
  Entity entity;
  GrainBlock block;
  Transform transform;
};

bool within(float value, float low, float high) { return value >= low && value <= high; }

// What is wrong with a block, with the value and what is allowed; empty: nothing.
std::string fault(const GrainBlock& block, size_t grains_so_far) {
  double total = 1;
  for (const int32_t n : block.count) {
    if (n < 0) return fmt::format("count {} is negative", n);
    total *= n;
  }
  if (total + static_cast<double>(grains_so_far) > kMaxGrains)
    return fmt::format("{} grains beside {}: a world holds {}", total, grains_so_far, kMaxGrains);
  if (!within(block.radius_jitter, 0, 0.9f))
    return fmt::format("radius_jitter {}: allowed 0 to 0.9", block.radius_jitter);
  if (!within(block.radius * (1 - block.radius_jitter), kLeastRadius, kMostRadius) ||
      !within(block.radius * (1 + block.radius_jitter), kLeastRadius, kMostRadius))
    return fmt::format("radius {}: allowed {} to {} m", block.radius, kLeastRadius, kMostRadius);
  const float diameter = 2 * block.radius * (1 + block.radius_jitter);
  if (block.spacing != 0 && !within(block.spacing, diameter, 1e6f))
    return fmt::format("spacing {}: allowed 0, or at least the largest diameter {} m",
                       block.spacing, diameter);
  if (!within(block.density, kLeastDensity, kMostDensity))
    return fmt::format("density {}: allowed {} to {} kg/m^3", block.density, kLeastDensity,
                       kMostDensity);
  if (!within(block.friction, 0, 1000) || !within(block.rolling_friction, 0, 1000))
    return fmt::format("friction {}, rolling_friction {}: allowed 0 to 1000", block.friction,
                       block.rolling_friction);
  if (!within(block.restitution, 0, 1))
    return fmt::format("restitution {}: allowed 0 to 1", block.restitution);
  if (!within(block.color_jitter, 0, 1))
    return fmt::format("color_jitter {}: allowed 0 to 1", block.color_jitter);
  return {};
}

void spawnBlock(World& world, const FoundBlock& found, const dvec3& origin) {
  const GrainBlock& block = found.block;
  const float largest = block.radius * (1 + block.radius_jitter);
  const float spacing = block.spacing > 0 ? block.spacing : 2.02f * largest;
  const vec3 base = vec3(found.transform.position - origin);
  const auto nx = static_cast<size_t>(block.count[0]), ny = static_cast<size_t>(block.count[1]),
             nz = static_cast<size_t>(block.count[2]);
  const size_t total = nx * ny * nz;
  if (total == 0) return;
  const GrainMaterial material{block.density, block.friction, block.rolling_friction,
                               block.restitution};
  const TableRows rows =
      world.spawnMany(total, Grain{}, GrainVelocity{}, GrainSpin{}, GrainOrientation{},
                      GrainPrevious{}, material, GrainLook{block.color, block.roughness});
  const std::span<Grain> grain = rows.column<Grain>();
  const std::span<GrainPrevious> previous = rows.column<GrainPrevious>();
  const std::span<GrainOrientation> orientation = rows.column<GrainOrientation>();
  const std::span<GrainLook> look = rows.column<GrainLook>();
  for (size_t k = 0; k < total; ++k) {
    const auto draw = [&](uint64_t which) { return randomUnit(block.seed, k, 0, which); };
    const auto spread = [&](uint64_t which) { return 2 * draw(which) - 1; };
    const float radius = block.radius * (1 + block.radius_jitter * spread(0));
    // Shaken within the cell, so that grains do not stand on one another like coins.
    const float slack = 0.5f * spacing - radius;
    const vec3 cell(static_cast<float>(k % nx), static_cast<float>(k / nx % ny),
                    static_cast<float>(k / nx / ny));
    const vec3 middle = 0.5f * vec3(static_cast<float>(nx - 1), static_cast<float>(ny - 1),
                                    static_cast<float>(nz - 1));
    const vec3 shaken = slack * vec3(spread(1), spread(2), spread(3));
    const vec3 local = (cell - middle) * spacing + shaken;
    grain[k].position = base + found.transform.rotation * local;
    grain[k].radius = radius;
    previous[k].position = grain[k].position;
    const quat turned(draw(4) + 0.01f, spread(5), spread(6), spread(7));
    orientation[k].rotation = glm::normalize(turned);
    look[k].color = block.color * (1 + block.color_jitter * spread(8));
  }
}

void spawnBlocks(GrainsState& state) {
  World& world = state.world;
  std::vector<FoundBlock> found;
  state.blocks.each([&](Entity entity, const GrainBlock& block) {
    const Transform* transform = world.peek<Transform>(entity);
    found.push_back({entity, block, transform != nullptr ? *transform : Transform{}});
  });
  std::sort(found.begin(), found.end(),
            [](const FoundBlock& a, const FoundBlock& b) { return a.entity < b.entity; });
  GrainField& field = grainField(world);
  uint64_t refused = 0;
  if (!field.placed) {
    field.origin = glm::round(found.front().transform.position);
    field.placed = true;
  }
  const dvec3 origin = field.origin;
  for (const FoundBlock& block : found) {
    if (const std::string wrong = fault(block.block, state.grains.count()); !wrong.empty()) {
      logWarning("grains.spawn: block of entity {} refused: {}", block.entity.index, wrong);
      ++refused;
    } else {
      spawnBlock(world, block, origin);
    }
    world.remove<GrainBlock>(block.entity);
  }
  grainField(world).refused += refused;
}

}  // namespace

SystemDesc spawnSystem(const SharedState& state) {
  return {.name = "grains.spawn",
          .phase = Phase::Simulate,
          .needs = [state] { return !state->blocks.empty(); },
          .run = [state](World&) { spawnBlocks(*state); }};
}

}  // namespace grains

void spawnGrains(World& world, std::span<const GrainSpec> specs) {
  if (specs.empty()) return;
  const TableRows rows =
      world.spawnMany<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious,
                      GrainMaterial, GrainLook>(specs.size());
  const std::span<Grain> grain = rows.column<Grain>();
  const std::span<GrainVelocity> velocity = rows.column<GrainVelocity>();
  const std::span<GrainSpin> spin = rows.column<GrainSpin>();
  const std::span<GrainOrientation> orientation = rows.column<GrainOrientation>();
  const std::span<GrainPrevious> previous = rows.column<GrainPrevious>();
  const std::span<GrainMaterial> material = rows.column<GrainMaterial>();
  const std::span<GrainLook> look = rows.column<GrainLook>();
  for (size_t k = 0; k < specs.size(); ++k) {
    grain[k] = specs[k].grain;
    velocity[k] = specs[k].velocity;
    spin[k] = specs[k].spin;
    orientation[k] = specs[k].orientation;
    previous[k].position = specs[k].grain.position;
    material[k] = specs[k].material;
    look[k] = specs[k].look;
  }
}

GrainField& grainField(World& world) {
  Entity first = Entity::kNone;
  world.query<const GrainField>().each([&](Entity entity, const GrainField&) {
    if (first == Entity::kNone || entity < first) first = entity;
  });
  if (first == Entity::kNone) first = world.spawn(GrainField{});
  return *world.find<GrainField>(first);
}

}  // namespace scree
