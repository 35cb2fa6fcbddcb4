// Grains: spheres with mass, spin and friction that fall, roll, pile up and are pushed by colliders.
// Solver: projected Gauss-Seidel on velocities with contact impulses kept from substep to substep
// (Catto, "Iterative Dynamics with Temporal Coherence", 2005), small steps (Macklin et al., "Small
// Steps in Physics Simulation", 2019), and a separate position projection.
// In: grains, colliders with a Transform, blocks of grains, and what interplay.h lists. Out: moved
// grains, sensor readings.
// Cost: see README.md; with no grain in the world nothing runs and nothing is allocated.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "engine/core/math.h"
#include "engine/core/result.h"
#include "engine/ecs/world.h"
#include "modules/grains/clump.h"
#include "modules/grains/interplay.h"
#include "modules/grains/rigid_bodies.h"

namespace scree {

class App;

// ---- One grain: these components, always together (see spawnGrains).

// A sphere. `position` is relative to GrainField::origin, so that a heap 1e6 m from the world's
// origin keeps the precision of one at it.
struct Grain {
  vec3 position{0};
  float radius = 0.05f;
};
std::string fault(const Grain& value);
SCREE_COMPONENT(Grain, (position, "m"), (radius, "m"));

struct GrainVelocity {
  vec3 linear{0};
};
std::string fault(const GrainVelocity& value);
SCREE_COMPONENT(GrainVelocity, (linear, "m/s"));

// Angular velocity, world axes.
struct GrainSpin {
  vec3 angular{0};
};
std::string fault(const GrainSpin& value);
SCREE_COMPONENT(GrainSpin, (angular, "rad/s"));

// world_from_local rotation.
struct GrainOrientation {
  quat rotation{1, 0, 0, 0};
};
std::string fault(const GrainOrientation& value);
SCREE_COMPONENT(GrainOrientation, (rotation, ""));

// Position one tick ago, relative to the field's origin: interpolation and motion vectors.
struct GrainPrevious {
  vec3 position{0};
};
std::string fault(const GrainPrevious& value);
SCREE_COMPONENT(GrainPrevious, (position, "m"));

// Rest, which the solver keeps: see rest.h for when a grain falls asleep and what wakes it. An asleep
// grain keeps its place to the bit; it wakes if its position, velocity or spin is written to.
struct GrainRest {
  vec3 anchor{0};       // where the rest began
  float still = 0;      // time since the grain was last away from there
  bool asleep = false;
};
SCREE_COMPONENT(GrainRest, (anchor, "m"), (still, "s"), (asleep, ""));

// Two touching bodies use the geometric mean of their frictions and cohesions, and the larger of their
// restitutions and rolling frictions. Cohesion c holds them together up to the force 2 pi c R*,
// R* = r1 r2 / (r1 + r2), of a grain on a collider its radius: see cohesion.h. Friction and rolling
// friction are limited by what presses and this force together.
struct GrainMaterial {
  float density = 1500;        // more than 0
  float friction = 0.5f;       // Coulomb coefficient, at least 0
  float rolling_friction = 0;  // rolling torque / (normal force x radius), at least 0
  float restitution = 0;       // 0 to 1
  float cohesion = 0;          // 0 to 1e6
};
std::string fault(const GrainMaterial& value);
SCREE_COMPONENT(GrainMaterial, (density, "kg/m^3"), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"));

struct GrainLook {
  vec3 color{0.76f, 0.6f, 0.38f};  // linear albedo
  float roughness = 0.8f;
};
std::string fault(const GrainLook& value);
SCREE_COMPONENT(GrainLook, (color, ""), (roughness, ""));

// ---- The field: one entity of a world carries it; made with these defaults if there is none.

struct GrainField {
  // World position of the grains' coordinate origin. Left at `placed` = false, it becomes the
  // whole metre nearest to the first block of grains.
  dvec3 origin{0};
  bool placed = false;
  vec3 gravity{0, -9.81f, 0};
  int32_t substeps = 4;       // a tick, 1 to 64
  int32_t passes = 3;         // solver passes a substep, 1 to 64
  float damping = 0.05f;      // fraction of velocity and spin lost a second
  // A grain whose centre leaves this box, relative to the origin, is lost: destroyed and counted.
  vec3 bounds_min{-500, -50, -500};
  vec3 bounds_max{500, 500, 500};
  // Counted since the field was made.
  uint64_t lost = 0;     // grains that left the bounds
  uint64_t refused = 0;  // grains or blocks with a radius, density or other number not allowed
};
std::string fault(const GrainField& value);
std::string faultIn(World& world, Entity entity, const GrainField& value);
SCREE_COMPONENT(GrainField, (origin, "m"), (placed, ""), (gravity, "m/s^2"), (substeps, ""),
                (passes, ""), (damping, "1/s"), (bounds_min, "m"), (bounds_max, "m"), (lost, ""),
                (refused, ""));

// A box-shaped lattice of grains, spawned at the entity's Transform in the first tick that sees
// it; the component is then removed. Grains keep inside their lattice cell: they never overlap.
struct GrainBlock {
  std::array<int32_t, 3> count{10, 10, 10};  // along local x, y, z; product at most kMaxGrains
  float radius = 0.05f;
  float radius_jitter = 0;       // radius varies by up to this fraction, 0 to 0.9
  float spacing = 0;             // between lattice points; 0: 2.02 times the largest radius
  uint32_t seed = 1;
  float density = 1500;
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 color{0.76f, 0.6f, 0.38f};  // linear albedo
  float color_jitter = 0.15f;      // brightness varies by up to this fraction, 0 to 1
  float roughness = 0.8f;
};
std::string fault(const GrainBlock& value);
std::string faultIn(World& world, Entity entity, const GrainBlock& value);
SCREE_COMPONENT(GrainBlock, (count, ""), (radius, "m"), (radius_jitter, ""), (spacing, "m"),
                (seed, ""), (density, "kg/m^3"), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"), (color, ""), (color_jitter, ""), (roughness, ""));

// The most grains of a world; a block that would exceed it is refused.
inline constexpr uint32_t kMaxGrains = 4'000'000;

// ---- Colliders: on an entity with a Transform. They are kinematic: their velocity, linear and
// angular, is the change of the Transform since the last tick (a jump faster than
// kColliderTeleport counts as a teleport, without velocity; a turn takes the shorter way). The
// Transform's scale multiplies half_extent, a, b, center, points, triangles and thickness; a radius
// is multiplied by the scale's largest component, as thickness is.

// m/s; above it a collider's move between two ticks is a teleport.
inline constexpr float kColliderTeleport = 100;

// The half space below the local xz plane.
struct PlaneCollider {
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};  // local axes: a conveyor belt
};
std::string fault(const PlaneCollider& value);
SCREE_COMPONENT(PlaneCollider, (friction, ""), (rolling_friction, ""), (restitution, ""),
                (cohesion, "N/m"), (surface_velocity, "m/s"));

struct BoxCollider {
  vec3 half_extent{0.5f};
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const BoxCollider& value);
SCREE_COMPONENT(BoxCollider, (half_extent, "m"), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"), (surface_velocity, "m/s"));

// All points within `radius` of the segment from a to b (local); a = b is a sphere.
struct CapsuleCollider {
  vec3 a{0};
  vec3 b{0};
  float radius = 0.5f;
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const CapsuleCollider& value);
SCREE_COMPONENT(CapsuleCollider, (a, "m"), (b, "m"), (radius, "m"), (friction, ""),
                (rolling_friction, ""), (restitution, ""), (cohesion, "N/m"), (surface_velocity, "m/s"));

struct SphereCollider {
  vec3 center{0};  // local
  float radius = 0.5f;
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const SphereCollider& value);
SCREE_COMPONENT(SphereCollider, (center, "m"), (radius, "m"), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"), (surface_velocity, "m/s"));

// The convex hull of the vertices of the entity's MeshInstance.
struct HullCollider {
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const HullCollider& value);
std::string faultIn(World& world, Entity entity, const HullCollider& value);
SCREE_COMPONENT(HullCollider, (friction, ""), (rolling_friction, ""), (restitution, ""),
                (cohesion, "N/m"), (surface_velocity, "m/s"));

// The triangles of the entity's MeshInstance: a sheet with two sides, which a grain meets on the side
// where it is. With `solid` the mesh must be closed, and what is inside is pushed out.
struct MeshCollider {
  bool solid = false;
  float thickness = 0;  // of the sheet, or laid around the solid: half of it on each side, m
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const MeshCollider& value);
std::string faultIn(World& world, Entity entity, const MeshCollider& value);
SCREE_COMPONENT(MeshCollider, (solid, ""), (thickness, "m"), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"), (surface_velocity, "m/s"));

// A solid given by its distance field: the one that addDistanceField gave the number `field`, or, with
// field = 0, one sampled from the entity's MeshInstance, which must be closed.
struct SdfCollider {
  int32_t resolution = 48;  // cells along the mesh's longest side, 4 to 128
  uint32_t field = 0;
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;
  vec3 surface_velocity{0};
};
std::string fault(const SdfCollider& value);
std::string faultIn(World& world, Entity entity, const SdfCollider& value);
SCREE_COMPONENT(SdfCollider, (resolution, ""), (field, ""), (friction, ""), (rolling_friction, ""),
                (restitution, ""), (cohesion, "N/m"), (surface_velocity, "m/s"));

// Pose of a collider at the last tick; added to every collider when it is first seen.
struct ColliderPose {
  dvec3 position{0};
  quat rotation{1, 0, 0, 0};
};
std::string fault(const ColliderPose& value);
SCREE_COMPONENT(ColliderPose, (position, "m"), (rotation, ""));

// ---- Distance fields: surfaces that say how far they are. Hulls, meshes and grids are some; a program
// or another module may bring its own.

struct SurfacePoint {
  vec3 normal;     // outward, unit length
  float distance;  // to the nearest point of the surface, negative inside, m
  float flat;      // m: points that are nearer to the one asked for have the same nearest plane
};

// Local space, before the Transform's position and rotation. Every finite point has a finite answer.
// No answer may change while a collider uses the field; threads ask at the same time.
class DistanceField {
 public:
  static constexpr uint32_t kMostTouches = 4;

  virtual ~DistanceField() = default;
  // The nearest point of the surface. The distance must not change faster than the point moves; far
  // from the surface it may be less than the true one. flat = 0 is always right.
  virtual SurfacePoint nearest(vec3 p) const = 0;
  // The same distance, or anything not less than `most` if it is not less than that.
  virtual float distance(vec3 p, [[maybe_unused]] float most) const { return nearest(p).distance; }
  // Where a growing sphere around p touches, up to the radius `reach`: at most mostTouches() points,
  // the nearest first. Returns how many; farther ones may be among them. With one alone, a grain in a
  // groove leans on one side at a time.
  virtual uint32_t touches(vec3 p, [[maybe_unused]] float reach, std::span<SurfacePoint> out) const {
    out[0] = nearest(p);
    return 1;
  }
  virtual uint32_t mostTouches() const { return 1; }
  // Of a closed surface of triangles: three corners each, counter-clockwise seen from outside. Empty:
  // it is none, or not closed.
  virtual std::span<const vec3> corners() const { return {}; }
  // Corners of a box around the surface; may be infinite if it never turns.
  virtual std::array<vec3, 2> bounds() const = 0;
  virtual size_t memoryBytes() const { return 0; }
};

// A signed distance sampled at the corners of cubes `cell` m wide that fill the box from low to high,
// linear between them (exact for planes; what is thinner than two cells is lost). At most 2^26 samples.
Result<std::shared_ptr<const DistanceField>> sampleDistance(const std::function<float(vec3)>& distance,
                                                            vec3 low, vec3 high, float cell);

// Numbers the field, for SdfCollider::field; 1 is the first. The world keeps it.
uint32_t addDistanceField(World& world, std::shared_ptr<const DistanceField> field);

// World singleton, for tests and overlays: shapes made of meshes since the start. Each is made once
// for all colliders of one mesh, size and kind, and kept while one of them is there.
struct ColliderShapes {
  uint64_t hulls = 0, meshes = 0, fields = 0;
  uint64_t refused = 0;    // colliders whose mesh was missing or would not do
  uint32_t kept = 0;       // shapes at the moment
  size_t bytes = 0;        // of them
};

// ---- Sensors.

// On a collider's entity: what the grains did to it in the last tick. Force = impulse / tick
// length; at rest, -impulse.y / dt / g is the mass that lies on the collider.
struct LoadSensor {
  vec3 impulse{0};       // of all grains and bodies on this collider, world axes
  uint32_t contacts = 0;  // grains that press on it at the tick's end
};
std::string faultIn(World& world, Entity entity, const LoadSensor& value);
SCREE_COMPONENT(LoadSensor, (impulse, "N s"), (contacts, ""));

// On an entity with a Transform: grains whose centre is inside the oriented box at the tick's end.
struct RegionSensor {
  vec3 half_extent{0.5f};
  uint32_t count = 0;
  float mass = 0;
};
std::string fault(const RegionSensor& value);
SCREE_COMPONENT(RegionSensor, (half_extent, "m"), (count, ""), (mass, "kg"));

// World singleton, filled by grains.step: counts of the last tick, for tests, benches, overlays.
struct GrainStats {
  uint32_t grains = 0;
  uint32_t asleep = 0;          // of them
  uint32_t woken = 0;           // in the tick
  uint32_t visited = 0;         // in each pass: those awake and the sleepers near them
  uint32_t pairs = 0;           // neighbour pairs that the passes visit: not both asleep
  uint32_t contacts = 0;        // pairs and collider contacts that carry an impulse
  uint32_t rebuilds = 0;        // neighbour searches in the tick
  double kinetic_energy = 0;    // J, linear and angular
  float deepest_overlap = 0;    // of two grains or a grain and a collider, m
  uint64_t allocations = 0;     // times that the solver's memory grew, since the start
};

// ---- Functions.

// Everything that one grain starts with.
struct GrainSpec {
  Grain grain;
  GrainVelocity velocity;
  GrainSpin spin;
  GrainOrientation orientation;
  GrainMaterial material;
  GrainLook look;
};
// Spawns grains with all their components, in the order given. Bad numbers are refused in the
// next tick (GrainField::refused). Not during iteration of a query.
void spawnGrains(World& world, std::span<const GrainSpec> specs);

// Everything that a clump (clump.h) starts with.
struct ClumpSpec {
  std::array<Grain, kMostMembers> member;  // spheres, relative to any point, before the rotation
  int32_t count = 2;                       // of them, 2 to kMostMembers
  vec3 position{0};                        // of the centre of mass, relative to the field's origin
  quat rotation{1, 0, 0, 0};
  vec3 velocity{0};  // of the centre of mass, m/s
  vec3 spin{0};      // world axes, rad/s
  GrainMaterial material;  // density: of the solid that the spheres make up
  GrainLook look;
};
std::string fault(const ClumpSpec& value);
// Spawns the members as grains, clump by clump in the order given. Clumps with bad numbers are refused with
// one line, and counted (GrainField::refused). Not during iteration of a query.
void spawnClumps(World& world, std::span<const ClumpSpec> specs);

// The world's field; spawned with defaults on first use.
GrainField& grainField(World& world);

// Mass of a solid sphere, kg.
inline float grainMass(float radius, float density) {
  return 4.18879020f * radius * radius * radius * density;
}

// Registers the systems grains.spawn, grains.emit, grains.push, grains.step, grains.sink and
// grains.splat (Simulate) and grains.upload (Prepare), and the passes grains.visible and grains.draw
// (Geometry: who is seen, then the G-buffer) and grains.shadow (writes the shadow map).
// Call after addScene and addDeferred, and after the systems that move colliders.
void addGrains(App& app);

}  // namespace scree
