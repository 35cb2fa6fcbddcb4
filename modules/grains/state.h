// What the module keeps between ticks and frames, and the parts that grains.cpp registers.
#pragma once

#include <memory>
#include <vector>

#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/frame/frame.h"
#include "modules/grains/clump_shape.h"
#include "modules/grains/crowd.h"
#include "modules/grains/draw_state.h"
#include "modules/grains/grains.h"
#include "modules/grains/shapes.h"
#include "modules/grains/solver.h"
#include "modules/scene/scene.h"

namespace scree::grains {

using GrainRowsQuery = Query<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious,
                             GrainRest, const GrainMaterial>;

// Components that a system refuses: their number in the last tick, and so far in this one.
struct Refusals {
  size_t before = 0, now = 0;
};

// What a RegionSensor reads of the sleepers, as long as none wakes or falls asleep and it stays.
struct RegionOfSleepers {
  Entity entity;
  Transform transform;
  vec3 half_extent{0};
  dvec3 origin{0};
  uint64_t changes = 0;  // of Sleepers
  uint32_t count = 0;
  int64_t mass = 0;  // ng
};

// A grain inside a sink.
struct Swallowed {
  Entity whole;  // first member of its clump, or the grain itself
  Entity entity;
  double mass;  // kg
};

// A grain inside a GrainGrid's box.
struct Splat {
  dvec3 place;      // in cells, from the centre of cell (0, 0, 0)
  double volume;    // in cells
  vec3 velocity;
  uint32_t layer;   // of cells along z, the lower of the two that it touches
};

// Owned by the systems and passes that addGrains registers, so that its GL objects die with them.
struct GrainsState {
  explicit GrainsState(World& world_in);

  World& world;
  Query<const GrainBlock> blocks;
  GrainRowsQuery grains;
  Query<const GrainClump> members;
  Query<const Transform, const PlaneCollider> planes;
  Query<const Transform, const BoxCollider> boxes;
  Query<const Transform, const CapsuleCollider> capsules;
  Query<const Transform, const SphereCollider> spheres;
  Query<const Transform, const HullCollider> hulls;
  Query<const Transform, const MeshCollider> meshes;
  Query<const Transform, const SdfCollider> fields;
  Query<const Transform, RegionSensor> regions;
  Query<LoadSensor> loads;
  Query<const Grain, const GrainVelocity, const GrainMaterial> seen;
  Query<const Transform, const GrainEmitter> emitters;
  Query<const Transform, const GrainSink> sinks;
  Query<const Transform, const GrainForce> force_query;
  Query<const Transform, const GrainBlow> blow_query;
  Query<const Transform, const GrainGrid> grids;
  Query<const Transform, const RigidBody> bodies;

  GrainSolver solver;
  // Working memory of the step.
  std::vector<GrainRows> tables;
  std::vector<Collider> colliders;
  Shapes shapes;  // of hull, mesh and SDF colliders
  std::vector<Entity> collider_entities;  // of all collider components
  size_t refused_colliders = 0;  // in the last tick
  std::vector<RigidRow> body_rows, body_rows_before;  // before the step
  std::vector<Entity> body_entities;                  // of the rows
  Refusals refused_bodies;
  Version rows_seen = 0;  // of the grains, after the last step
  Version regions_seen = 0;
  bool stepped = false;  // with grains, in the last tick: sensors hold what they did

  // Of what interplay.h lists: for the step, then working memory.
  std::vector<Force> forces;
  std::vector<Blow> blows;
  std::vector<RegionOfSleepers> regions_of_sleepers;
  std::vector<Entity> entities;  // with the component at hand, sorted
  std::vector<GrainSpec> emitted;
  ClumpForms forms;  // of blocks and emitters
  std::vector<ClumpSpec> emitted_clumps;  // of one emitter
  std::vector<float> clump_scale;
  std::vector<Entity> swallowed_clumps;  // their first members
  Crowd crowd;
  std::vector<PosedCollider> walls;
  std::vector<Swallowed> inside;
  std::vector<Entity> doomed;
  std::vector<uint32_t> berths;
  std::vector<uint8_t> berth_met;  // by berth
  std::vector<Splat> splats, splats_by_layer;
  std::vector<uint32_t> layer_begin, strike_order;
  std::vector<int64_t> cell_sums;
  Refusals refused_emitters, refused_sinks, refused_forces, refused_blows, refused_grids;

  DrawState draw;
};
using SharedState = std::shared_ptr<GrainsState>;

// One system or pass each, in the file of that name.
SystemDesc spawnSystem(const SharedState& state);   // spawn.cpp
SystemDesc emitSystem(const SharedState& state);    // emit.cpp
SystemDesc pushSystem(const SharedState& state);    // push.cpp
SystemDesc stepSystem(const SharedState& state);    // step.cpp
SystemDesc sinkSystem(const SharedState& state);    // sink.cpp
SystemDesc splatSystem(const SharedState& state);   // splat.cpp
SystemDesc uploadSystem(const SharedState& state);  // upload.cpp
PassDesc visiblePass(const SharedState& state);     // draw.cpp
PassDesc drawPass(const SharedState& state);        // draw.cpp
PassDesc shadowPass(const SharedState& state);      // draw.cpp

// Makes the solver's memory a part of the world's saves.
void addToSaves(const SharedState& state);  // save.cpp

// An entity's colliders have the keys from firstKeyOf on, kKeysOfEntity of them.
inline constexpr uint32_t kKeysOfEntity = 8;
inline uint32_t firstKeyOf(Entity entity) { return entity.index * kKeysOfEntity; }

// The field and its origin, without making the field; null: there is none.
const GrainField* peekField(World& world);  // spawn.cpp
dvec3 fieldOrigin(World& world);
// An entity as a message names it: by its Name if it has one.
std::string nameOf(const World& world, Entity entity);  // spawn.cpp
// What a block or an emitter says of its grains' matter.
template <class Maker>
GrainMaterial materialOf(const Maker& m) {
  return {m.density, m.friction, m.rolling_friction, m.restitution, m.cohesion};
}
// What is wrong with clumps of these scales, spawn_clumps.cpp; empty: nothing.
std::string faultOfClumps(const ClumpShape& shape, float smallest, float largest);
// The same of a block of them, spawn.cpp.
std::string faultOfClumps(const GrainBlock& block, const ClumpShape& shape, ClumpForms& forms);
// Between a block's lattice points; `bound`: of a ball around what is spawned there, in radii.
inline float spacingOf(const GrainBlock& block, float bound) {
  return block.spacing > 0 ? block.spacing : 2.02f * (block.radius * (1 + block.radius_jitter)) * bound;
}
// Spawns clumps of one form, by its scale; only what the specs say of place, motion and matter counts.
void spawnClumpsOf(World& world, const ClumpForm& form, std::span<const float> scale,
                   std::span<const ClumpSpec> specs);
// Fills state.colliders with the world's colliders over the tick, by key; `origin`: the field's.
void gatherColliders(GrainsState& state, const dvec3& origin, float dt);  // gather_colliders.cpp
// Notes where the colliders are, for the next tick.
void keepColliderPoses(GrainsState& state);
// Fills state.body_rows, after gatherColliders(); writes them back, after the solver's step.
void gatherBodies(GrainsState& state, const dvec3& origin);  // gather_bodies.cpp
void writeBodies(GrainsState& state, const dvec3& origin);
// Fills the RegionSensors, after the solver's step; if the grains all sleep, only when the sensors
// have changed.
void senseRegions(GrainsState& state, const dvec3& origin, bool asleep);  // sensors.cpp
// Fills the LoadSensors from state.colliders.
void senseLoads(GrainsState& state);
// Fills GrainStrikes from the solver's, after keepColliderPoses().
void tellStrikes(GrainsState& state, const dvec3& origin);  // tell_strikes.cpp

}  // namespace scree::grains
