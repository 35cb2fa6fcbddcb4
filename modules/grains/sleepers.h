// Grains asleep: where they lie, how they lean on each other and on colliders, and what they bear.
//
// Nothing here is visited while nothing happens: a search looks up the few that lie near a grain
// awake, and those take part in the contact lists as bodies that do not move. Contacts between two
// sleepers are kept here, from the moment both sleep to the moment that one wakes; sums are taken in
// the order of the other's entity, so that no result depends on the order of events.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "engine/core/bytes.h"
#include "modules/grains/bodies.h"
#include "modules/grains/collider.h"
#include "modules/grains/contacts.h"

namespace scree::grains {

// A sum of up to 2^22 floats that does not depend on their order: fixed point with 2^-60 N s. What is
// beyond 2^44 N s counts as that.
class ExactSum {
 public:
  void add(float value) {
    constexpr double kMost = 0x1p44;
    // NaN counts as nothing.
    const double held = value == value ? std::clamp(static_cast<double>(value), -kMost, kMost) : 0.0;
    sum_ += static_cast<Int128>(held * kScale);
  }
  double value() const { return static_cast<double>(sum_) / kScale; }

 private:
  __extension__ using Int128 = __int128;
  static constexpr double kScale = 0x1p60;
  Int128 sum_ = 0;
};

struct Sleeper {
  vec3 position{0};
  float radius = 0;  // 0: nobody's berth
  uint32_t slot = kNoSlot;  // among the solver's bodies, if it lies near a grain awake
  uint32_t slot_before = kNoSlot;  // working memory of the solver
  bool propped = false;  // a contact with a grain awake presses on it
  uint32_t pairs = kNoSlot, walls = kNoSlot;  // first contacts in the lists of Sleepers
  uint32_t row = 0;
  uint32_t ring = kNoSlot, member = 0;  // of a clump: the next member's berth; its number
  Entity entity;
  uint32_t material = 0;  // among those of Sleepers
  Load load;  // of gravity, of other sleepers and of colliders, a substep
  uint32_t booked_on = kNoSlot;  // key of a collider: see book()
  vec3 booked{0};                // N s
};

// A contact as a sleeper feels it.
struct Touch {
  uint32_t berth = 0;  // the sleeper, or the member of its clump
  vec3 normal{0};    // from there to the centre
  vec3 impulse{0};   // on the sleeper, a substep, N s
  float friction = 0;
  float pull = 0;    // force that parts it, N
  vec3 arm{0};       // working memory of Sleepers::balance()
};

// Of a contact: from the other's centre to the sleeper's.
inline vec3 normalOf(const Sleeper& own, const Sleeper& other) {
  const vec3 d = own.position - other.position;
  return d * (1 / std::sqrt(std::max(glm::dot(d, d), 1e-37f)));
}

// What those who woke take along.
struct WokenPair {
  Entity a, b;
  vec3 impulse, rolling;  // on a
};
struct WokenWall {
  Entity grain;
  uint32_t key;  // of the collider
  vec3 impulse, rolling, normal;
};

// What becomes of a sleeper out of balance.
enum class Balance : uint32_t { Held, Lost, Struck };

class Sleepers {
 public:
  uint32_t count() const { return count_; }
  uint32_t contacts() const { return contacts_; }
  // Counts each that falls asleep or wakes.
  uint64_t changes() const { return changes_; }
  // A berth is a sleeper's place in here; it keeps it until it wakes.
  Sleeper& operator[](uint32_t berth) { return sleeper_[berth]; }
  const Sleeper& operator[](uint32_t berth) const { return sleeper_[berth]; }
  const GrainMaterial& materialOf(uint32_t berth) const { return materials_[sleeper_[berth].material]; }
  // Where a sleeper lies, apart from all else that is known of it: most of those that a search looks
  // up turn out not to be near.
  struct Spot {
    vec3 position{0};
    float radius = 0;
    uint32_t next = kNoSlot;  // berth in its bucket; of a berth that is nobody's: the next such
    int32_t level = 0;
  };
  const Spot& spot(uint32_t berth) const { return spot_[berth]; }
  template <class Visit>
  void each(const Visit& visit) const {
    for (uint32_t berth = 0; berth < sleeper_.size(); ++berth)
      if (sleeper_[berth].radius > 0) visit(berth);
  }

  uint32_t lay(const Sleeper& sleeper, const GrainMaterial& material);
  // A contact of sleepers a and b; impulses on a.
  void lean(uint32_t a, uint32_t b, vec3 impulse, vec3 rolling);
  void leanOn(uint32_t berth, const ColliderContact& contact);
  // Calls visit(berth) for the sleeper and those of its clump, the first member first.
  template <class Visit>
  void eachOfClump(uint32_t berth, const Visit& visit) const {
    if (sleeper_[berth].ring == kNoSlot) return visit(berth);
    const uint32_t first = berth = firstOf(berth);
    do {
      visit(berth);
      berth = sleeper_[berth].ring;
    } while (berth != first);
  }
  // Sums what the sleeper bears. After its contacts have changed.
  void weigh(uint32_t berth, vec3 gravity_step);
  // The first member of the sleeper's clump, or the sleeper.
  uint32_t firstOf(uint32_t berth) const {
    if (sleeper_[berth].ring != kNoSlot)
      while (sleeper_[berth].member != 0) berth = sleeper_[berth].ring;
    return berth;
  }
  // What the contacts of a sleeper leave over, `pressed` being that of those with grains awake, is booked
  // on the collider that its strongest supports lead down to when it is first booked: what all press is
  // what they weigh. After weigh().
  void book(uint32_t berth, vec3 gravity_step, vec3 pressed);
  void unbook(uint32_t berth);
  // Of a collider that is no longer there; whose bookings these were go to `berths`.
  void unbookAll(uint32_t key, std::vector<uint32_t>& berths);

  // If the load of the sleeper, or of its clump, is out of balance, changes all its contacts as little as balances force and
  // moment: those with other sleepers and with colliders, and `outer`, those with grains awake. Lost
  // if contacts that press, or hold, within Coulomb's limit cannot balance it; Struck if it cannot wait for that:
  // it is struck, or hangs in the air. `touched`: partners asleep
  // that bear something else now, or the first members of their clumps. `h`: the substep, s.
  Balance balance(uint32_t berth, vec3 gravity_step, float h, std::span<Touch> outer,
               std::vector<uint32_t>& touched);

  // Takes the sleeper out; its contacts go to `pairs` and `walls`, and from the lists of those that
  // it leaned on, whose berths go to `partners`.
  void wake(uint32_t berth, std::vector<WokenPair>& pairs, std::vector<WokenWall>& walls,
            std::vector<uint32_t>& partners);

  // Calls visit(berth) for all whose spheres touch the box, and some others.
  template <class Visit>
  void near(vec3 low, vec3 high, const Visit& visit) const;
  // The same for those that press on a collider.
  template <class Visit>
  void pressing(uint32_t key, const Visit& visit) const;

  struct WallLoad {
    uint32_t key = 0;
    uint32_t contacts = 0;  // sleepers
    uint32_t bookings = 0;
    std::array<ExactSum, 3> impulse;  // on the grains, N s a substep
  };
  // Null: nothing sleeps on it.
  const WallLoad* loadOn(uint32_t key) const;

  // In solver saves (saved.h): sleepers are numbered from 0 on; saved_berth[berth] is the number.
  void save(ByteWriter& out, std::vector<uint32_t>& saved_berth) const;
  // Into an empty store, where the number is the berth. Returns what is wrong; empty: nothing.
  std::string restore(ByteReader& in, uint32_t handles);

  // Each search: gives back what nobody has slept in for long.
  void trim();
  size_t memoryBytes() const;

 private:
  std::string restorePairs(ByteReader& in);
  std::string restoreWalls(ByteReader& in);
  // A contact of two sleepers, in the lists of both.
  struct PairNode {
    uint32_t berth[2] = {0, 0};
    uint32_t next[2] = {kNoSlot, kNoSlot};  // in the list of each
    vec3 impulse{0};  // on the first
    uint32_t side(uint32_t owner) const { return berth[0] == owner ? 0 : 1; }
    uint32_t other(uint32_t owner) const { return berth[1 - side(owner)]; }
    uint32_t& nextOf(uint32_t owner) { return next[side(owner)]; }
    uint32_t nextOf(uint32_t owner) const { return next[side(owner)]; }
    vec3 impulseOn(uint32_t owner) const { return side(owner) == 0 ? impulse : -impulse; }
    uint32_t& freeLink() { return next[0]; }
  };
  struct WallNode {
    uint32_t key = 0;
    uint32_t next = kNoSlot;
    vec3 impulse{0}, rolling{0}, normal{0};
    float friction = 0, pull = 0;
    uint32_t& freeLink() { return next; }
  };
  template <class Node>
  struct Pool {
    std::vector<Node> node;
    uint32_t free = kNoSlot;
    uint32_t take();
    void give(uint32_t at);
  };

  static int levelOf(float radius);
  // Of the cells along x: bucket_[(bucketRow + x) & mask].
  static uint32_t bucketRow(int level, int32_t y, int32_t z);
  uint32_t bucketOf(const Spot& spot) const;
  void putInBucket(uint32_t berth);
  void growTable();
  // Whether a node of a sleeper's list of walls, from this one on, is of a collider.
  bool leansOn(uint32_t node, uint32_t key) const;
  void insertPair(uint32_t owner, uint32_t at);
  vec3 rollingOn(uint32_t owner, uint32_t at) const;
  // On the first.
  void setRolling(uint32_t at, vec3 rolling);
  // Keys of colliders, kNoSlot if no way leads down to one.
  uint32_t groundUnder(uint32_t berth, vec3 up) const;
  WallLoad& wallLoad(uint32_t key);
  void dropIfIdle(WallLoad& load);
  void pressWall(WallNode& node, vec3 impulse);

  float massOf(uint32_t berth) const {
    return grainMass(sleeper_[berth].radius, materialOf(berth).density);
  }
  float pullBetween(uint32_t a, uint32_t b) const;

  std::vector<Sleeper> sleeper_;
  Materials materials_;
  std::vector<Spot> spot_;
  uint32_t free_ = kNoSlot, count_ = 0, contacts_ = 0;
  uint64_t changes_ = 0;
  Need need_;
  Pool<PairNode> pair_;
  std::vector<vec3> rolling_;  // of pair_.node[k], on the first; empty: no contact of sleepers has ever rolled
  Pool<WallNode> wall_;
  std::vector<WallLoad> wall_load_;  // by key
  std::vector<Touch> touches_;       // working memory of balance()
  std::vector<uint32_t> bucket_;     // first berth
  std::vector<uint64_t> occupied_;   // a bit a bucket: not empty
  // Cells of level l are 2^(l + kLowestLevel) m wide: at least a diameter of those in them.
  static constexpr int kLowestLevel = -16, kLevels = 32;
  std::array<uint32_t, kLevels> members_{};
};

template <class Visit>
void Sleepers::near(vec3 low, vec3 high, const Visit& visit) const {
  if (count_ == 0) return;
  for (int level = 0; level < kLevels; ++level) {
    const uint32_t members = members_[static_cast<size_t>(level)];
    if (members == 0) continue;
    const double cell = std::ldexp(1.0, level + kLowestLevel), inverse = 1 / cell;
    const float half = static_cast<float>(0.5 * cell);
    int32_t from[3], to[3];
    double cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = cellOf(low[axis] - half, inverse);
      to[axis] = cellOf(high[axis] + half, inverse);
      cells *= static_cast<double>(to[axis]) - from[axis] + 1;
    }
    if (!(cells <= 2.0 * members + 64)) {
      each([&](uint32_t berth) {
        if (spot_[berth].level == level) visit(berth);
      });
      continue;
    }
    const uint32_t mask = static_cast<uint32_t>(bucket_.size() - 1);
    for (int32_t z = from[2]; z <= to[2]; ++z)
      for (int32_t y = from[1]; y <= to[1]; ++y) {
        // Most cells are empty: whole words of them are passed over at once.
        uint32_t bucket = bucketRow(level, y, z) + static_cast<uint32_t>(from[0]);
        uint32_t left = static_cast<uint32_t>(to[0] - from[0]) + 1;
        while (left > 0) {
          bucket &= mask;
          const uint32_t shift = bucket % 64, run = std::min(left, 64 - shift);
          uint64_t full = occupied_[bucket / 64] >> shift;
          if (run < 64) full &= (uint64_t{1} << run) - 1;
          for (; full != 0; full &= full - 1)
            for (uint32_t berth = bucket_[bucket + static_cast<uint32_t>(std::countr_zero(full))];
                 berth != kNoSlot; berth = spot_[berth].next)
              if (spot_[berth].level == level) visit(berth);
          bucket += run;
          left -= run;
        }
      }
  }
}

template <class Visit>
void Sleepers::pressing(uint32_t key, const Visit& visit) const {
  if (loadOn(key) == nullptr) return;
  each([&](uint32_t berth) {
    for (uint32_t at = sleeper_[berth].walls; at != kNoSlot; at = wall_.node[at].next)
      if (colliderKey(wall_.node[at].key) == key) visit(berth);
  });
}

}  // namespace scree::grains
