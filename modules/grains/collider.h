// Shapes that grains collide with, as the solver sees them: poses of one tick, relative to the
// field's origin, and the distance query that every shape answers.
#pragma once

#include <cstdint>
#include <memory>

#include "engine/core/math.h"
#include "modules/grains/grains.h"

namespace scree::grains {

// What a collider's surface is computed from; a sphere is a capsule whose ends meet.
enum class Shape : uint32_t { Plane, Box, Capsule, Field };

// Keys of colliders are less than this; the bits above tell a grain's contacts with one field apart.
inline constexpr uint32_t kKeyLimit = 1u << 30;
inline uint32_t partKey(uint32_t key, uint32_t part) { return key | part * kKeyLimit; }
inline uint32_t colliderKey(uint32_t part_key) { return part_key & (kKeyLimit - 1); }

// Of a collider that is no rigid body.
inline constexpr uint32_t kNoRigid = 0xffffffffu;

// One collider over one tick: it moves from pose 0 (tick's begin) to pose 1 (tick's end).
struct Collider {
  uint32_t key = 0;  // identifies it from tick to tick; unique, less than kKeyLimit
  Shape shape = Shape::Plane;
  vec3 position0{0}, position1{0};  // m, relative to the field's origin
  quat rotation0{1, 0, 0, 0}, rotation1{1, 0, 0, 0};
  vec3 half_extent{0};  // box, m
  vec3 a{0}, b{0};      // capsule, local, m
  float radius = 0;     // capsule, m
  std::shared_ptr<const DistanceField> field;  // of Shape::Field
  uint64_t field_identity = 0;  // equal for equal fields, in any process; 0: not known
  float friction = 0.5f;
  float rolling_friction = 0;
  float restitution = 0;
  float cohesion = 0;        // N/m
  vec3 surface_velocity{0};  // local, m/s
  // Of a rigid body: poses 0 and 1 are where it was last listed, and no point of it is farther than
  // `slack` m from there.
  float slack = 0;
  uint32_t rigid = kNoRigid;  // among the solver's bodies
  bool sensed = false;       // collect load: impulse and contacts
  // Out, of the tick: impulse of the grains on the collider, N s, and contacts that press at its
  // end.
  glm::dvec3 load{0};
  uint32_t load_contacts = 0;

  bool moves() const { return position0 != position1 || rotation0 != rotation1; }
};

// A collider at one moment, with its motion over the substep that begins then.
struct PosedCollider {
  Shape shape = Shape::Plane;
  vec3 position{0};
  mat3 world_from_local{1};
  vec3 half_extent{0};
  vec3 a{0}, b{0};  // world axes, relative to the field's origin
  float radius = 0;
  const DistanceField* field = nullptr;
  bool gives = false;        // a rigid body awake: not solved in the slabs
  vec3 velocity{0};          // of `position`, m/s
  vec3 spin{0};              // rad/s
  vec3 surface_velocity{0};  // world axes

  bool moves() const { return velocity != vec3(0) || spin != vec3(0); }
};

// Pose at `t0` and motion from t0 to t1, fractions of the tick that are `h` seconds apart.
PosedCollider poseCollider(const Collider& collider, float t0, float t1, float h);

// Signed distance from p to the surface, negative inside, and the outward unit normal there.
// Always finite; at the centre of symmetry the normal is one of the nearest.
SurfacePoint nearestSurface(const PosedCollider& collider, vec3 p);
// The same distance, or anything not less than `most` if it is not less than that.
float distanceTo(const PosedCollider& collider, vec3 p, float most);

// Share of the straight way from `from` to `to`, 0 to 1, that a point goes before it is `core` from
// the surface; `distance` is that of `from`, more than `core`. Safe for any shape: never too much.
float freeWay(const PosedCollider& collider, vec3 from, vec3 to, float distance, float core);

// The plane with outward unit normal n that touches a plane, box or capsule: n . x = offset.
float supportOffset(const PosedCollider& collider, vec3 n);

// Velocity of the collider's material at the world point p, without its surface velocity.
vec3 velocityAt(const PosedCollider& collider, vec3 p);

// Axis-aligned bounds of the whole motion of the tick; infinite for a plane.
struct Bounds {
  vec3 min, max;
};
Bounds sweptBounds(const Collider& collider);

// The farthest that any point of the collider moves over the tick, m (an upper bound).
float motionBound(const Collider& collider);

// How far the surface is from the surface on the other side, m (a lower bound; a field's may be 0).
float thicknessOf(const Collider& collider);

}  // namespace scree::grains
