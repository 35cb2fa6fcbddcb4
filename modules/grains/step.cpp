// grains.step: one tick of the solver over the world's grains and colliders.
#include "engine/app/app.h"
#include "engine/core/log.h"
#include "modules/grains/state.h"

namespace scree::grains {
namespace {

// The first of these entities, and why, as a line for the user.
void reportRefused(World& world, const std::vector<Entity>& refused) {
  const Entity first = refused.front();
  const Grain& grain = *world.peek<Grain>(first);
  const GrainMaterial& material = *world.peek<GrainMaterial>(first);
  logWarning(
      "grains.step: {} grains refused and removed; the first is entity {}: radius {} m (allowed {} "
      "to {}), density {} kg/m^3 (allowed {} to {}), position, velocity and the rest must be finite",
      refused.size(), first.index, grain.radius, kLeastRadius, kMostRadius, material.density,
      kLeastDensity, kMostDensity);
}

void step(GrainsState& state) {
  World& world = state.world;
  GrainField& field = grainField(world);
  StepParameters parameters;
  parameters.dt = static_cast<float>(world.singleton<const Tick>().dt_s);
  parameters.gravity = field.gravity;
  parameters.substeps = field.substeps;
  parameters.passes = field.passes;
  parameters.damping = field.damping;
  parameters.bounds_min = field.bounds_min;
  parameters.bounds_max = field.bounds_max;
  const dvec3 origin = field.origin;
  parameters.forces = state.forces;
  parameters.blows = state.blows;
  const GrainStrikes& asked = world.singleton<const GrainStrikes>();
  parameters.strikes = {asked.least_impulse, asked.least_speed};

  gatherColliders(state, origin, parameters.dt);
  gatherBodies(state, origin);
  parameters.bodies = state.body_rows;
  parameters.origin = origin;
  // Sleepers that nobody touched: their columns are not even opened for writing.
  if (state.grains.version() == state.rows_seen &&
      state.solver.sleepOn(state.colliders, parameters)) {
    world.singleton<GrainStats>() = state.solver.stats();
    writeBodies(state, origin);
    senseLoads(state);
    senseRegions(state, origin, true);
    keepColliderPoses(state);
    tellStrikes(state, origin);
    return;
  }
  // Opening the columns counts as writing to them: ask before.
  const RowsAre rows =
      state.grains.version() == state.rows_seen ? RowsAre::AsLeft : RowsAre::Unknown;
  state.tables.clear();
  state.grains.spans([&](std::span<const Entity> entities, std::span<Grain> grain,
                         std::span<GrainVelocity> velocity, std::span<GrainSpin> spin,
                         std::span<GrainOrientation> orientation,
                         std::span<GrainPrevious> previous, std::span<GrainRest> rest,
                         std::span<const GrainMaterial> material) {
    state.tables.push_back(
        {entities, grain, velocity, spin, orientation, previous, material, rest, {}});
  });
  if (!state.members.empty())
    state.members.spans([&](std::span<const Entity> entities, std::span<const GrainClump> clump) {
      for (GrainRows& rows_of_table : state.tables)
        if (rows_of_table.entity.data() == entities.data()) rows_of_table.clump = clump;
    });
  state.solver.step(state.tables, state.colliders, parameters, rows);
  state.stepped = !state.tables.empty() || !state.body_rows.empty();
  world.singleton<GrainStats>() = state.solver.stats();

  const std::vector<Entity>& lost = state.solver.lost();
  const std::vector<Entity>& refused = state.solver.refused();
  for (const Entity entity : state.solver.broken()) world.remove<GrainClump>(entity);
  if (!refused.empty()) reportRefused(world, refused);
  if (!lost.empty() || !refused.empty()) {
    world.destroyMany(lost);
    world.destroyMany(refused);
    GrainField& counted = grainField(world);
    counted.lost += lost.size();
    counted.refused += refused.size();
  }
  senseLoads(state);
  writeBodies(state, origin);
  senseRegions(state, origin, false);
  keepColliderPoses(state);
  tellStrikes(state, origin);
  state.rows_seen = state.grains.version();
}

}  // namespace

SystemDesc stepSystem(const SharedState& state) {
  return {.name = "grains.step",
          .phase = Phase::Simulate,
          // Once more after the last grain or body has gone, so that the sensors read zero.
          .needs = [state] { return !state->grains.empty() || !state->bodies.empty() || state->stepped; },
          .run =
              [state](World&) {
                step(*state);
                // grains.push fills them again if there are any.
                state->forces.clear();
                state->blows.clear();
              }};
}

}  // namespace scree::grains
