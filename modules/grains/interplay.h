// What a level or a game has grains do, and what it is told of them: emitters and sinks, forces and
// blows; strikes and grids. Part of grains.h, which includes it.
// Components go on an entity with a Transform (or in a glTF node's extras); regions are oriented
// boxes around it, whose half extents its scale multiplies. Values that are not allowed are refused
// with one line in the log. A world with none of these pays nothing for them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/math.h"
#include "engine/ecs/world.h"

namespace scree {

// ---- Where grains come from and go.

// A mouth from which grains stream. A grain that is due comes out at a random point of a disc across
// the local y axis, as if at its own moment within the tick, unless all of a few points that it tries
// are taken by a grain or a collider: then it is held back for good, so that what was jammed does not
// come in a burst. The first one places a field without grains, as a GrainBlock does.
struct GrainEmitter {
  bool on = true;
  float rate = 50;          // grains/s, at most 1e5; a mass flow divided by the mean grain's mass
  uint64_t most = 0;        // stops when it has emitted so many; 0: never
  float mouth = 0.25f;      // of the disc in which centres appear; the scale's x and z multiply it
  vec3 velocity{0, -1, 0};  // local axes
  float spread = 0;         // velocities differ by up to this, equally in all directions
  uint32_t seed = 1;
  // The grains, as of a GrainBlock.
  float radius = 0.05f;
  float radius_jitter = 0;  // radius varies by up to this fraction, 0 to 0.9
  float density = 1500;
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 color{0.76f, 0.6f, 0.38f};  // linear albedo
  float color_jitter = 0.15f;      // brightness varies by up to this fraction, 0 to 1
  float roughness = 0.8f;
  // Kept by the simulation. emitted + held_back + due = rate x time.
  double due = 0;          // of the next grain, 0 to 1
  uint64_t emitted = 0;
  uint64_t held_back = 0;  // no free place, or no room in the world (kMaxGrains)
};
std::string fault(const GrainEmitter& value);
std::string faultIn(World& world, Entity entity, const GrainEmitter& value);
SCREE_COMPONENT(GrainEmitter, (on, ""), (rate, "1/s"), (most, ""), (mouth, "m"), (velocity, "m/s"),
                (spread, "m/s"), (seed, ""), (radius, "m"), (radius_jitter, ""),
                (density, "kg/m^3"), (friction, ""), (rolling_friction, ""), (restitution, ""),
                (cohesion, "N/m"), (color, ""), (color_jitter, ""), (roughness, ""), (due, ""), (emitted, ""),
                (held_back, ""));

// Destroys the grains whose centre is inside at a tick's end; those with the lowest entities first
// when its limit is near. Of overlapping sinks the lowest entity takes a grain.
struct GrainSink {
  bool on = true;
  vec3 half_extent{0.5f};
  float radius = 0;   // above 0: a sphere instead; the scale's largest component multiplies it
  uint64_t most = 0;  // stops when it has swallowed so many; 0: never
  // Kept by the simulation.
  uint64_t count = 0;  // swallowed
  double mass = 0;
};
std::string fault(const GrainSink& value);
SCREE_COMPONENT(GrainSink, (on, ""), (half_extent, "m"), (radius, "m"), (most, ""), (count, ""),
                (mass, "kg"));

// ---- What pushes them.

// Accelerates the grains whose centre is inside the box, whatever their size:
//   a = acceleration - attraction falloff^2 x / (|x|^2 + falloff^2)^(3/2) + drag (air - v)
// where x leads from the Transform's position to the grain: inverse square far away, GM = attraction
// falloff^2, and smooth at the centre (Plummer, 1911). The air moves with `flow` and turns about the
// local y axis at the speed swirl 2 s / (1 + s^2), s = (distance from the axis) / falloff: fastest,
// `swirl`, at `falloff` (Kaufmann, 1962). All of it adds up over the forces that hold a grain.
struct GrainForce {
  bool on = true;
  vec3 half_extent{1};
  vec3 acceleration{0};  // local axes
  float attraction = 0;  // below 0 it repels
  float falloff = 1;     // 1e-3 or more
  float drag = 0;        // share of the velocity against the air that is lost in a second
  vec3 flow{0};          // local axes
  float swirl = 0;
  // Sleepers that it would accelerate by more wake, and none that it does fall asleep; others sleep.
  float wake_above = 1;
};
std::string fault(const GrainForce& value);
SCREE_COMPONENT(GrainForce, (on, ""), (half_extent, "m"), (acceleration, "m/s^2"),
                (attraction, "m/s^2"), (falloff, "m"), (drag, "1/s"), (flow, "m/s"), (swirl, "m/s"),
                (wake_above, "m/s^2"));

// One blow in the next tick, then the component is removed: each grain whose centre is nearer than
// `radius` gets the impulse  strength (1 - distance / radius) pi r^2  away from the Transform's
// position (below 0: towards it): that of a pressure wave on its cross section, so that small grains
// fly farthest. No grain gains more than kMostBlow, and one at the very centre nothing. Sleepers wake.
struct GrainBlow {
  float radius = 1;
  float strength = 100;
  bool fleeting = false;  // the entity goes with it: see impulseInSphere()
};
std::string fault(const GrainBlow& value);
SCREE_COMPONENT(GrainBlow, (radius, "m"), (strength, "N s/m^2"), (fleeting, ""));

inline constexpr float kMostBlow = 1000;  // m/s

// The same as a call: in the next tick, around a point of the world. Not during iteration of a query.
void impulseInSphere(World& world, const dvec3& centre, float radius, float strength);

// ---- What is told of them.

// One contact of a tick in which a grain was struck.
struct GrainStrike {
  dvec3 position{0};  // of the contact, world
  vec3 normal{0};     // from b to a
  float impulse = 0;  // along the normal, N s, from the substep in which it was noticed to the tick's end
  float speed = 0;    // with which the two approached each other at most, m/s
  Entity a, b;        // a is a grain; b another one of a higher index, or a collider
  bool collider = false;
};

// World singleton, filled by grains.step: contacts that passed a limit in the last tick, strongest
// impulse first, then by entities. A contact is noticed in the substep in which its approach is
// faster than least_speed, or its impulse greater than least_impulse / substeps. An impact whose end
// falls into the next tick is told in two parts.
struct GrainStrikes {
  // Set by the game; 0, NaN: not asked for. With neither, nothing is looked at.
  float least_impulse = 0;  // N s
  float least_speed = 0;    // m/s
  uint32_t most = 256;      // the strongest that are kept, at most kMostStrikes
  // Out.
  std::vector<GrainStrike> list;
  uint64_t left_out = 0;  // of the tick, beyond `most`
};

inline constexpr uint32_t kMostStrikes = 65536;

// Asks for the grains in a box as fields on a grid, in GrainGrids: see there.
struct GrainGrid {
  vec3 half_extent{1};                   // more than 0
  std::array<int32_t, 3> cells{8, 8, 8};  // along local x, y, z; product at most kMostGridCells
  int32_t every = 1;                     // ticks between two of them, 1 to 3600
};
std::string fault(const GrainGrid& value);
SCREE_COMPONENT(GrainGrid, (half_extent, "m"), (cells, ""), (every, ""));

inline constexpr uint32_t kMostGridCells = 1u << 20;

// Grains whose centre is in a GrainGrid's box, each shared among the eight nearest cell centres by
// trilinear weights (cloud in cell: Hockney & Eastwood, "Computer Simulation Using Particles", ch. 5);
// what would fall to a cell outside goes to its neighbour inside. Cell (x, y, z) is at
// x + cells[0] (y + cells[1] z). The sum of fraction x cell volume is the volume of these grains.
struct GrainGridValues {
  Entity entity;  // that asked
  uint64_t tick = 0;
  std::array<int32_t, 3> cells{0, 0, 0};
  double cell_volume = 0;         // m^3
  std::vector<double> fraction;   // volume of grains / volume of the cell
  std::vector<vec3> velocity;     // mean by volume, world axes, m/s; 0 where there is no grain
};

// World singleton, filled by grains.splat; by entity.
struct GrainGrids {
  std::vector<GrainGridValues> grids;
  // Null: none is there (yet).
  const GrainGridValues* of(Entity entity) const {
    for (const GrainGridValues& values : grids)
      if (values.entity == entity) return &values;
    return nullptr;
  }
};

}  // namespace scree
