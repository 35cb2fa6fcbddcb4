// Contact lists: neighbour pairs in batches of eight for the pair passes, and grains near colliders.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/bytes.h"
#include "modules/grains/bodies.h"
#include "modules/grains/collider.h"
#include "modules/grains/grid.h"
#include "modules/grains/room.h"

namespace scree::grains {

// Contacts a batch, whatever the instruction set: a step of the pair passes takes one, or two.
inline constexpr uint32_t kBatch = kMostLanes;
// Idle bodies a slab: the unused lanes of a batch write to them.
inline constexpr uint32_t kIdleBodies = 2 * kBatch;

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
  bool cohesive = false;  // some grain has cohesion
  bool standing = false;  // only contacts with colliders that do not move
};

// A contact that bounced in this substep: how far to move its grains so that they end where the
// impact inside the substep leaves them.
struct Bounce {
  uint32_t i, j;  // j = kNoSlot: against a collider
  vec3 shift;     // of i relative to j, m
};

// What the contacts of a batch carry from substep to substep, by component and lane.
struct ImpulseBatch {
  float impulse[3][kBatch];  // on grain i, N s
};
// The same for rolling friction.
struct RollingBatch {
  float impulse[3][kBatch];  // angular, on grain i, N m s
  float friction[kBatch];
};
struct BouncingBatch {
  float restitution[kBatch];
  float approach[kBatch];  // separation speed that a bounce asks for, m/s; 0: none
};

struct CohesionBatch {
  float pull[kBatch];  // force that parts the two, N
};

// The arrays are parts of those of PairLists.
struct PairSlab {
  // Batches: contacts whose grain pairs are disjoint within each, and within each colour.
  uint32_t count = 0;  // contacts with the unused lanes, a multiple of kBatch
  std::vector<uint32_t> colour_end;  // contacts up to each colour's last; its unused lanes come behind
  std::vector<uint32_t> border;  // contacts of which one grain sleeps
  std::span<uint32_t> i, j;
  std::span<ImpulseBatch> impulse;
  std::span<uint8_t> trust;  // a bit a lane; clear: a substep old, its impulse is not kept
  std::span<RollingBatch> rolling;    // empty: nothing rolls
  std::span<BouncingBatch> bouncing;  // empty: nothing bounces
  std::span<CohesionBatch> cohesion;  // empty: nothing holds
  std::vector<Bounce> bounces;
  float deepest = 0;     // overlap, m
  uint32_t carried = 0;  // contacts that carry an impulse after the last pass

  // Impulse on grain i.
  vec3 impulseAt(uint32_t contact) const {
    const ImpulseBatch& batch = impulse[contact / kBatch];
    const uint32_t lane = contact % kBatch;
    return {batch.impulse[0][lane], batch.impulse[1][lane], batch.impulse[2][lane]};
  }
  // N.
  float pullAt(uint32_t contact) const {
    return cohesion.empty() ? 0.0f : cohesion[contact / kBatch].pull[contact % kBatch];
  }
  void setImpulse(uint32_t contact, vec3 value) {
    for (int axis = 0; axis < 3; ++axis) impulse[contact / kBatch].impulse[axis][contact % kBatch] = value[axis];
  }
  vec3 rollingAt(uint32_t contact) const {
    if (rolling.empty()) return vec3(0);
    const RollingBatch& batch = rolling[contact / kBatch];
    const uint32_t lane = contact % kBatch;
    return {batch.impulse[0][lane], batch.impulse[1][lane], batch.impulse[2][lane]};
  }
  bool carriesImpulse(uint32_t contact) const {
    const ImpulseBatch& batch = impulse[contact / kBatch];
    const uint32_t lane = contact % kBatch;
    return batch.impulse[0][lane] != 0 || batch.impulse[1][lane] != 0 ||
           batch.impulse[2][lane] != 0;
  }

  // Working memory of the build.
  uint64_t found_begin = 0, colour_begin = 0;
  uint32_t found_count = 0, found_below = 0;  // pairs; of them with grains of the slab below
};

// A contact that takes its impulses along into the next lists, by their slots.
struct JoiningPair {
  uint32_t i, j;
  vec3 impulse, rolling;  // on i
};
struct JoiningWall {
  uint32_t grain;
  uint32_t key;  // of the collider
  vec3 impulse, rolling, normal;
};

// Impulses of contacts between two searches, listed by the grain of the lower slot. In the workspace.
struct KeptPairs {
  struct Contact {
    uint32_t other;    // slot of the other grain; the top bit says whether the impulse is trusted
    vec3 impulse;      // on the listed grain, N s
  };
  static constexpr uint32_t kTrusted = 0x80000000u;
  std::span<uint32_t> begin;  // by slot; when all are listed, the end
  std::span<Contact> contact;
  std::span<vec3> rolling;    // of contact[k]; empty: nothing rolled
};

// What PairLists has. A copy's slabs have still their parts of the other's arrays.
class PairArrays {
 public:
  std::vector<PairSlab> slab;
  uint32_t slab_count = 0;
  bool rolling = false, bouncing = false, cohesive = false;
  uint64_t pair_count = 0;

 protected:
  // Of a thread: the pairs that the grains of a slab find, and colours taken by grain of two slabs.
  struct Scratch {
    std::vector<uint32_t> found;
    Room<uint64_t> taken;
  };

  uint32_t listed_ = 0;
  // In the workspace, during the build.
  KeptPairs kept_;
  std::span<uint32_t> found_end_;  // by slot, in its slab
  std::vector<Scratch> scratch_;  // by thread
  size_t most_found_ = 0;         // by the grains of a slab, in the last build
  // Of all slabs, one after the other.
  Room<uint32_t> i_, j_;
  Room<uint8_t> trust_;
  Room<RollingBatch> rolling_;
  Room<BouncingBatch> bouncing_;
  Room<CohesionBatch> cohesion_;
  // The impulses' batches; before, during the build, the found pairs and then their colours.
  Room<std::byte> impulse_;
};

class PairLists : public PairArrays {
 public:
  PairLists() = default;
  PairLists(PairLists&&) = default;
  PairLists& operator=(PairLists&&) = default;
  PairLists(const PairLists& other);
  PairLists& operator=(const PairLists& other) { return *this = PairLists(other); }

  // Finds all pairs of the grid of which a grain is awake and batches them; impulses are taken over
  // from `old` (which may be these lists themselves), whose slot of new slot k is before[k]
  // (kNoSlot: none), and from `joining`.
  void build(const Grid& grid, const Bodies& bodies, const PairLists& old,
             std::span<const uint32_t> before, std::span<const JoiningPair> joining, Workspace& workspace);
  // Of solver saves (saved.h). `rolling`, `bouncing` and `cohesive` are set before; slab s has the bodies from
  // slab_begin[s] to slab_begin[s + 1]; `in_force`: the passes will use these lists. Returns what is
  // wrong; empty: nothing.
  void save(ByteWriter& out) const;
  std::string restore(ByteReader& in, std::span<const uint32_t> slab_begin, const Bodies& bodies,
                      bool in_force);
  // Grains that are listed.
  uint32_t bodyCount() const { return listed_; }
  size_t memoryBytes() const;

 private:
  void keep(const PairLists& old, std::span<const uint32_t> before,
            std::span<const JoiningPair> joining, Workspace& workspace);
  void find(const Grid& grid, const Bodies& bodies);
  void findOf(const Grid& grid, const Bodies& bodies, uint32_t s, std::vector<uint32_t>& found);
  template <class Visit>
  void eachPair(const Grid& grid, uint32_t s, const Visit& visit);
  void colour(const Grid& grid, uint32_t s);
  void place(const Grid& grid, const Bodies& bodies, uint32_t s);
  void fill(uint32_t s, const Bodies& bodies);
  // Shares out the arrays of the batches, whose counts are known: first who is in them, then the rest.
  void layOut(Contents contents);
  void layOutImpulses(Contents contents);
  template <class T>
  void share(std::span<T> all, std::span<T> PairSlab::* part, uint32_t a_batch);
  // Makes room for all lanes, none of them used.
  void fillIdle(uint32_t s);
  static void clearLanes(PairSlab& own);
  void mixMaterials(PairSlab& own, uint32_t contact, const Bodies& bodies) const;
  // Found pairs by slab and finder (a grain of the slab): the other grain, as Grid::neighbours() names
  // it. And their colours, by the slab whose batches they are for.
  uint32_t* found() { return reinterpret_cast<uint32_t*>(impulse_.data()); }
  uint32_t* colours() { return found() + pair_count; }
};

// One grain near one collider.
struct ColliderContact {
  uint32_t grain = 0;
  uint32_t collider = 0;
  uint32_t key = 0;  // of the collider; of one of the points where a field touches: partKey
  bool guarded = false;  // see Guard
  bool gives = false;    // with a rigid body awake: Rigids solves it
  vec3 impulse{0};   // on the grain, N s
  float trust = 0;
  vec3 rolling{0};   // angular impulse on the grain, N m s
  float approach = 0;  // separation speed that a bounce asks for, m/s
  float friction = 0, rolling_friction = 0, restitution = 0;
  float pull = 0;    // force that parts grain and collider, N
  // Of the substep: the surface as a plane, n . x = offset, and its velocity. Of the grain what is divided
  // once for all passes.
  vec3 normal{0};
  float offset = 0;
  vec3 surface_velocity{0};
  float mass = 0;
  vec3 surface_spin{0};
  float spin_factor = 0;
  float flat = 0;  // SurfacePoint::flat
};

// Where a grain is, as a collider sees it, at the substep's begin: it must not come to the surface by
// more than a contact's plane can tell. Of contacts with fields, with what is thin, and with what moves
// by more than half a radius in a substep.
struct Guard {
  uint32_t contact;
  vec3 local;      // m
  float distance;  // of the centre to the surface, m
};

struct ColliderSlab {
  std::span<ColliderContact> contact;  // by grain, then collider; a part of the array of ColliderLists
  std::vector<Bounce> bounces;
  std::vector<Guard> guards;
  bool driven = false;  // a guarded surface goes by more than a grain's radius in the substep
  uint32_t begin = 0, end = 0;  // slots of the slab's grains
  float deepest = 0;

  // As listed before: impulses are taken over from there. While they are listed.
  std::span<const ColliderContact> was;
  uint32_t was_begin = 0;
  size_t contact_begin = 0, contact_size = 0;  // in the array
};

// How far grains go until the colliders are listed again.
struct Going {
  float extra = 0;   // m, that all go together at most
  vec3 drifted{0};   // m, that all went together since the search
  vec3 drift{0};     // m/s, of that
  float h = 0;       // substep, s
  float share = 1;   // substep / tick
};

// What ColliderLists has. A copy's slabs have still their parts of the other's array.
class ColliderArrays {
 public:
  std::vector<ColliderSlab> slab;
  uint32_t slab_count = 0;
  size_t contact_count = 0;

  // A collider over the tick.
  struct Swept {
    Collider collider;
    Bounds bounds;
    float motion = 0;     // motionBound
    float thickness = 0;  // thicknessOf
    PosedCollider begin;  // pose at the tick's begin
    bool fresh = true;    // not as it was at the last listing
  };

 protected:
  // A contact to come: with a part of a collider; or, with this bit, the one of before that stays.
  struct Listed {
    uint32_t grain, collider, part;
  };
  static constexpr uint32_t kStays = 0x80000000u;
  // Of a thread.
  struct Scratch {
    std::vector<Listed> listed;  // of a slab
    std::vector<uint32_t> near;  // colliders that may touch it
  };

  std::vector<Swept> swept_;
  float extra_ = 0;
  bool lacking_ = false;  // fields, after restore()
  Room<ColliderContact> contact_;        // of all slabs
  std::vector<Scratch> scratch_;         // by thread
  size_t most_listed_ = 0;               // in a slab, last time
};

class ColliderLists : public ColliderArrays {
 public:
  ColliderLists() = default;
  ColliderLists(ColliderLists&&) = default;
  ColliderLists& operator=(ColliderLists&&) = default;
  ColliderLists(const ColliderLists& other);
  ColliderLists& operator=(const ColliderLists& other) { return *this = ColliderLists(other); }

  // Lists the grains awake that come within reach of a collider's surface during the tick from
  // wherever their margin lets them be (or, if they are faster, where a substep takes them): around
  // their reference, which the drift has carried by `drifted`, and carries by up to `extra` m more.
  // `searched`: slots have changed since the last listing, where slot k was before[k]
  // (kNoSlot: none); impulses are taken over from there, and from `joining`, sorted by grain. If they
  // have not, only colliders that changed are looked at: with none, nothing is done.
  void build(const Grid& grid, const Bodies& bodies, std::span<const Collider> colliders,
             const Going& going, bool searched, std::span<const uint32_t> before,
             std::span<const JoiningWall> joining, Workspace& workspace);
  // The first tick after restore(): colliders as they were saved get their fields back.
  void bringFields(std::span<const Collider> colliders);
  // Notes where the colliders go; true if any is not as it was. Part of build().
  bool sweep(std::span<const Collider> colliders);
  // Whether a grain of the slab comes within reach of a collider with which it is not listed.
  bool misses(uint32_t slot, uint32_t in_slab, vec3 position, float reach) const;
  // As swept last, by key.
  std::span<const Swept> swept() const { return swept_; }
  const Swept* sweptLast(const Collider& collider) const;  // null if it was not there, or different
  // As those of PairLists.
  void save(ByteWriter& out) const;
  std::string restore(ByteReader& in, std::span<const uint32_t> slab_begin, const Bodies& bodies,
                      bool in_force);
  size_t memoryBytes() const;

 private:
  static void place(Swept& swept);
  // How contacts come by their impulses of before.
  struct TakeOver {
    bool searched;
    std::span<const uint32_t> before;
    std::span<const JoiningWall> joining;
    uint32_t slabs;  // before
  };
  void list(uint32_t s, const Grid& grid, const Bodies& bodies, const Going& going, Scratch& scratch) const;
  ColliderContact contactOf(const Listed& listed, const ColliderSlab& own, const Bodies& bodies,
                            const Going& going) const;
  void takeOver(ColliderContact& contact, const TakeOver& over) const;
  // Lets the slabs have their parts of the array.
  void shareOut();
  const ColliderContact* formerly(uint32_t slot, uint32_t key, uint32_t slabs) const;
};

// The colliders' surfaces near each contact's grain at the substep's begin, and its guards.
void placeSurfaces(ColliderSlab& slab, const Body* body, std::span<const PosedCollider> posed, float h);
// The surfaces where a field touches a grain, for its contacts from `first` on; returns how many.
size_t placeField(ColliderSlab& slab, size_t first, const Body* body, const PosedCollider& collider,
                  float h);
void setSurface(ColliderContact& contact, const SurfacePoint& near, const Body& grain,
                const PosedCollider& collider);
// Whether a collider's material goes by more than the grain's radius in a substep.
bool drives(const PosedCollider& collider, const Body& grain, float h);
void applyKeptColliders(ColliderSlab& slab, Body* body);
void relaxContact(ColliderSlab& slab, ColliderContact& contact, Body& grain, std::span<const PosedCollider> posed,
                  const PassSettings& settings);
// One after the other, those with bodies awake left out. Kernels::relaxWalls does the same.
void relaxColliders(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                    const PassSettings& settings);

// At the substep's end: takes grains back to where their way through a guarded surface began. `begin`
// and `end`: the colliders then. With what moves, they go along from there.
void keepGuards(ColliderSlab& slab, Body* body, std::span<const PosedCollider> begin,
                std::span<const PosedCollider> end);
// The same for one grain that came from `from`, and one collider. True if it was stopped.
bool stopAt(const PosedCollider& begin, const PosedCollider& end, vec3 from, Body& grain);

// Share of the overlap that one pass undoes.
inline constexpr float kProjection = 0.2f;
// Overlap that is left alone, as a share of the sum of radii: contacts at rest keep touching.
inline constexpr float kSlop = 1e-5f;

}  // namespace scree::grains
