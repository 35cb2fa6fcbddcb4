// What the module keeps between ticks and frames, and the parts that grains.cpp registers.
#pragma once

#include <memory>
#include <vector>

#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/frame/frame.h"
#include "modules/grains/draw_state.h"
#include "modules/grains/grains.h"
#include "modules/grains/solver.h"
#include "modules/scene/scene.h"

namespace scree::grains {

using GrainRowsQuery = Query<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious,
                             GrainRest, const GrainMaterial>;

// Owned by the systems and passes that addGrains registers, so that its GL objects die with them.
struct GrainsState {
  explicit GrainsState(World& world_in);

  World& world;
  Query<const GrainBlock> blocks;
  GrainRowsQuery grains;
  Query<const Transform, const PlaneCollider> planes;
  Query<const Transform, const BoxCollider> boxes;
  Query<const Transform, const CapsuleCollider> capsules;
  Query<const Transform, RegionSensor> regions;
  Query<LoadSensor> loads;

  GrainSolver solver;
  // Working memory of the step.
  std::vector<GrainRows> tables;
  std::vector<Collider> colliders;
  std::vector<Entity> collider_entities;  // of all collider components
  size_t refused_colliders = 0;  // in the last tick
  Version rows_seen = 0;  // of the grains, after the last step
  Version regions_seen = 0;
  bool stepped = false;  // with grains, in the last tick: sensors hold what they did

  DrawState draw;
};
using SharedState = std::shared_ptr<GrainsState>;

// One system or pass each, in the file of that name.
SystemDesc spawnSystem(const SharedState& state);   // spawn.cpp
SystemDesc stepSystem(const SharedState& state);    // step.cpp
SystemDesc uploadSystem(const SharedState& state);  // upload.cpp
PassDesc visiblePass(const SharedState& state);     // draw.cpp
PassDesc drawPass(const SharedState& state);        // draw.cpp
PassDesc shadowPass(const SharedState& state);      // draw.cpp

// Makes the solver's memory a part of the world's saves.
void addToSaves(const SharedState& state);  // save.cpp
// The field's origin, without making the field.
dvec3 fieldOrigin(World& world);  // spawn.cpp
// An entity as a message names it: by its Name if it has one.
std::string nameOf(const World& world, Entity entity);  // spawn.cpp
// Fills state.colliders with the world's colliders over the tick, by key; `origin`: the field's.
void gatherColliders(GrainsState& state, const dvec3& origin, float dt);  // gather_colliders.cpp
// Notes where the colliders are, for the next tick.
void keepColliderPoses(GrainsState& state);
// Fills the RegionSensors; if the grains all sleep, only when the sensors have changed.
void senseRegions(GrainsState& state, const dvec3& origin, bool asleep);  // sensors.cpp
// Fills the LoadSensors from state.colliders.
void senseLoads(GrainsState& state);

}  // namespace scree::grains
