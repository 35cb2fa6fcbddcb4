// Contact lists: neighbour pairs in batches of four for the pair passes, and grains near colliders.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/bodies.h"
#include "modules/grains/collider.h"
#include "modules/grains/grid.h"

namespace scree::grains {

inline constexpr uint32_t kNoSlot = 0xffffffffu;
// Idle bodies a slab: the unused lanes of a batch write to them.
inline constexpr uint32_t kIdleBodies = 8;

// What one pass over contacts needs to know.
struct PassSettings {
  float h = 0;          // substep, s
  float inverse_h = 0;  // 1/s
  vec3 gravity_step{0};  // velocity that gravity adds in the substep, m/s
  float bounce_speed = 0;  // m/s: a slower approach does not bounce
  bool first_pass = false;
  float tolerated = 0;  // m/s: a collider's contact that is violated by less is left as it is
  bool rolling = false;  // some grain or collider has rolling friction
  bool bouncing = false;  // some grain or collider has restitution
};

// A contact that bounced in this substep: how far to move its grains so that they end where the
// impact inside the substep leaves them.
struct Bounce {
  uint32_t i, j;  // j = kNoSlot: against a collider
  vec3 shift;     // of i relative to j, m
};

// One value a lane of each contact, `count` long (a multiple of four).
enum class Lane : uint32_t {
  ImpulseX, ImpulseY, ImpulseZ,  // on grain i, N s
  MomentX, MomentY, MomentZ,     // (distance / sum of radii) normal x impulse
  Friction,
  Trust,     // 0: the contact is a substep old, its impulse is not kept
  LastPlain = Trust,
  RollingX, RollingY, RollingZ,  // angular impulse on grain i, N m s
  RollingFriction,
  LastRolling = RollingFriction,
  Restitution,
  Approach,  // separation speed that a bounce asks for, m/s; 0: none
  Count
};

struct PairSlab {
  // Found pairs, in the order of the finder (a grain of this slab).
  std::vector<uint32_t> found_i, found_j;
  std::vector<uint32_t> found_at;  // contact in the owner's batches
  uint32_t found_below = 0;        // pairs that the slab below owns
  // Batches: contacts whose grain pairs are disjoint within each four.
  std::vector<uint32_t> i, j;
  std::vector<float> lanes;
  uint32_t count = 0;
  std::vector<Bounce> bounces;
  float deepest = 0;  // overlap, m

  float* lane(Lane which) { return lanes.data() + size_t{count} * static_cast<size_t>(which); }
  const float* lane(Lane which) const {
    return lanes.data() + size_t{count} * static_cast<size_t>(which);
  }

  // Working memory of the build.
  std::vector<uint32_t> pending, again, colour_count;
  std::vector<uint32_t> colour;
};

struct PairLists {
  std::vector<PairSlab> slab;
  uint32_t slab_count = 0;
  std::vector<uint32_t> slab_of, found_begin, found_end;  // by slot
  std::vector<uint64_t> mask[2];                          // colours taken, by parity of the slab
  bool rolling = false, bouncing = false;
  uint64_t pair_count = 0;

  // Finds all pairs of the grid and batches them; impulses are taken over from `old`, whose slot
  // of new slot k is history[order[k]] (kNoSlot: none).
  void build(const Grid& grid, const Bodies& bodies, const PairLists& old,
             std::span<const uint32_t> order, std::span<const uint32_t> history);
  size_t memoryBytes() const;

 private:
  void find(const Grid& grid, uint32_t s);
  void batch(const Grid& grid, uint32_t s);
  void fill(uint32_t s, const Bodies& bodies, const PairLists& old, std::span<const uint32_t> order,
            std::span<const uint32_t> history);
};

// Velocities take up the impulses kept from the last substep.
void applyKeptPairs(PairSlab& slab, Body* body, const PassSettings& settings);
// One pass: impulses that stop approach and sliding, then a shift that undoes overlap.
void relaxPairs(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings);

// One grain near one collider.
struct ColliderContact {
  uint32_t grain = 0;
  uint32_t collider = 0;
  uint32_t key = 0;  // of the collider
  vec3 impulse{0};   // on the grain, N s
  vec3 moment{0};    // normal x impulse
  vec3 rolling{0};   // angular impulse on the grain, N m s
  float friction = 0, rolling_friction = 0, restitution = 0;
  float trust = 0;
  float approach = 0;  // separation speed that a bounce asks for, m/s
  // Of the substep: the surface as a plane, n . x = offset, and its velocity.
  vec3 normal{0};
  float offset = 0;
  vec3 surface_velocity{0};
  vec3 surface_spin{0};
};

struct ColliderSlab {
  std::vector<ColliderContact> contact;  // by grain, then collider
  std::vector<Bounce> bounces;
  vec3 low{0}, high{0};  // bounds of the slab's grains with their reach
  float deepest = 0;
};

struct ColliderLists {
  std::vector<ColliderSlab> slab;
  uint32_t slab_count = 0;
  std::vector<Bounds> bounds;   // of each collider over the tick
  std::vector<float> motion;    // motionBound of each collider
  std::vector<PosedCollider> begin;  // poses at the tick's begin

  // Grains within their margin, plus `extra` m, of a collider's surface during the tick.
  void build(const Grid& grid, const Bodies& bodies, std::span<const Collider> colliders,
             float extra, const ColliderLists& old, const PairLists& old_pairs,
             std::span<const uint32_t> order, std::span<const uint32_t> history);
  size_t memoryBytes() const;

 private:
  void fill(uint32_t s, const Grid& grid, const Bodies& bodies,
            std::span<const Collider> colliders, float extra, const ColliderLists& old,
            const PairLists& old_pairs, std::span<const uint32_t> order,
            std::span<const uint32_t> history);
};

// The colliders' surfaces near each contact's grain at the substep's begin.
void placeSurfaces(ColliderSlab& slab, const Body* body, std::span<const PosedCollider> posed);
void applyKeptColliders(ColliderSlab& slab, Body* body);
void relaxColliders(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                    const PassSettings& settings);

// Share of the overlap that one pass undoes.
inline constexpr float kProjection = 0.2f;
// Overlap that is left alone, as a share of the sum of radii: contacts at rest keep touching.
inline constexpr float kSlop = 1e-5f;

}  // namespace scree::grains
