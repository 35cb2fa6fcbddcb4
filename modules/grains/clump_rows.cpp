// Clumps and the solver: who belongs to one, and that they sleep, wake and are lost together.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "modules/grains/rest.h"
#include "modules/grains/saved.h"
#include "modules/grains/solver.h"

namespace scree::grains {

// Finds the clumps anew from the rows: all that is known of them is there. Members that sleep are linked;
// where only some do, these are to wake.
void GrainSolver::adoptClumps(std::span<const GrainRows> tables) {
  clump_rows_.clear();
  for (size_t t = 0; t < tables.size(); ++t)
    for (size_t k = 0; k < tables[t].clump.size(); ++k)
      clump_rows_.push_back({tables[t].clump[k], tables[t].entity[k], static_cast<uint32_t>(t), k});
  if (clump_rows_.empty() && clumps_.empty()) return;
  std::sort(clump_rows_.begin(), clump_rows_.end(), [](const ClumpRow& a, const ClumpRow& b) {
    return std::tie(a.clump.first, a.clump.member, a.entity) <
           std::tie(b.clump.first, b.clump.member, b.entity);
  });
  clumps_.clear();
  const std::span<const ClumpRow> rows(clump_rows_);
  for (size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    while (end < rows.size() && rows[end].clump.first == rows[begin].clump.first) ++end;
    const std::span<const ClumpRow> group = rows.subspan(begin, end - begin);
    if (takeClump(group, tables)) continue;
    for (const ClumpRow& row : group) {
      const uint32_t place = placeOf(row.entity);
      if (place != kNoSlot && (place & kBerthBit) != 0) waking_.push_back(place & ~kBerthBit);
      broken_.push_back(row.entity);
    }
  }
  std::sort(broken_.begin(), broken_.end());
  clumps_.mark(bodies_);
}

// False if these are not the members of one clump, each once.
bool GrainSolver::takeClump(std::span<const ClumpRow> rows, std::span<const GrainRows> tables) {
  if (rows.size() < 2 || rows.size() > kMostMembers || rows[0].entity != rows[0].clump.first) return false;
  const size_t n = rows.size();
  std::array<Entity, kMostMembers> entity;
  std::array<vec3, kMostMembers> arm;
  std::array<float, kMostMembers> radius, mass;
  std::array<uint32_t, kMostMembers> place;
  uint32_t asleep = 0;
  for (size_t k = 0; k < n; ++k) {
    const GrainClump& clump = rows[k].clump;
    if (clump.member != k || clump.count != n || !finite(clump.arm) ||
        glm::dot(clump.arm, clump.arm) > 4e4f * kMostRadius * kMostRadius)
      return false;
    const GrainRows& table = tables[rows[k].table];
    entity[k] = rows[k].entity;
    arm[k] = clump.arm;
    place[k] = placeOf(entity[k]);
    // Refused, now or of old.
    if (place[k] == kNoSlot || (place[k] < settled_.size() && settled_[place[k]] == 0)) return false;
    if ((place[k] & kBerthBit) != 0 && sleepers_[place[k] & ~kBerthBit].row == kNoSlot) return false;
    asleep += (place[k] & kBerthBit) != 0;
    radius[k] = table.grain[rows[k].row].radius;
    mass[k] = grainMass(radius[k], table.material[rows[k].row].density);
  }
  Clump clump = makeClump(std::span(entity).first(n), std::span(arm).first(n), std::span(radius).first(n),
                          std::span(mass).first(n));
  quat q = tables[rows[0].table].orientation[rows[0].row].rotation;
  if (std::abs(glm::dot(q, q) - 1) > 1e-5f) q = glm::normalize(q);  // else to the bit
  clump.rotation = q;
  const uint32_t at = clumps_.add(clump);
  if (asleep == n) {
    linkSleepers(clump);
  } else if (asleep > 0) {
    for (size_t k = 0; k < n; ++k)
      if ((place[k] & kBerthBit) != 0) waking_.push_back(place[k] & ~kBerthBit);
  } else {
    clumps_.rouse(at, place);
  }
  return true;
}

// The members, all asleep, as a ring of berths.
void GrainSolver::linkSleepers(const Clump& clump) {
  for (uint32_t k = 0; k < clump.count; ++k) {
    Sleeper& sleeper = sleepers_[placeOf(clump.entity[k]) & ~kBerthBit];
    sleeper.ring = placeOf(clump.entity[(k + 1) % clump.count]) & ~kBerthBit;
    sleeper.member = k;
  }
}

// Clumps of which all are awake now; those who woke are in awake_ from `first_awake` on.
void GrainSolver::rouseClumps(size_t first_awake) {
  if (clumps_.empty()) return;
  for (size_t k = first_awake; k < awake_.size(); ++k) {
    const uint32_t at = clumps_.of(bodies_.entity[awake_[k].slot]);
    if (at == kNoSlot || clumps_[at].moving) continue;
    std::array<uint32_t, kMostMembers> slot{};
    bool whole = true;
    for (uint32_t m = 0; m < clumps_[at].count; ++m) {
      slot[m] = placeOf(clumps_[at].entity[m]);
      whole = whole && (slot[m] & kBerthBit) == 0;  // as kNoSlot has, too
    }
    if (whole) clumps_.rouse(at, slot);
  }
  clumps_.mark(bodies_);
}

// After grains have been laid to sleep, whole clumps with them.
void GrainSolver::layClumps() {
  clumps_.rest([&](const Clumps::Moving& m) {
    const Clump& clump = clumps_[m.clump];
    if ((placeOf(clump.entity[0]) & kBerthBit) == 0) return false;
    linkSleepers(clump);
    return true;
  });
}

// What loses a member is lost whole.
void GrainSolver::loseClumps() {
  const size_t lost = lost_.size();
  for (size_t k = 0; k < lost; ++k) {
    const uint32_t at = clumps_.of(lost_[k]);
    if (at == kNoSlot) continue;
    const Clump& clump = clumps_[at];
    lost_.insert(lost_.end(), clump.entity.begin(), clump.entity.begin() + clump.count);
  }
  if (lost_.size() == lost) return;
  std::sort(lost_.begin(), lost_.end());
  lost_.erase(std::unique(lost_.begin(), lost_.end()), lost_.end());
}

// Of the bodies in met_: all belong to the clump of this one.
bool GrainSolver::meetsOwnOnly(uint32_t slot) const {
  if (bodies_.clump.empty() || bodies_.clump[slot] == kNoSlot) return false;
  return std::all_of(met_.begin(), met_.end(), [&](uint32_t met) {
    return bodies_.clump[met & ~kNearBit] == bodies_.clump[slot];
  });
}

// Of settled_: what one member lacks all lack, and what marks one marks all.
void GrainSolver::settleClumps(uint8_t still) {
  for (const Clumps::Moving& m : clumps_.moving()) {
    const uint32_t n = clumps_[m.clump].count;
    uint8_t all = still, any = 0;
    for (uint32_t k = 0; k < n; ++k) {
      all &= settled_[m.slot[k]];
      any |= settled_[m.slot[k]];
    }
    for (uint32_t k = 0; k < n; ++k)
      settled_[m.slot[k]] = static_cast<uint8_t>(all | (any & ~still));
  }
}

// Of a member: mass and load are those of the whole clump, and the same for all members.
void GrainSolver::loadOfClump(uint32_t slot, float& mass, Load& load) const {
  const uint32_t at = bodies_.clump[slot];
  if (at == kNoSlot) return;
  const Clump& clump = clumps_[at];
  mass = clump.total;
  load = {};
  for (uint32_t k = 0; k < clump.count; ++k) {
    const Load& own = load_[placeOf(clump.entity[k])];
    load.impulse += own.impulse;
    load.carried += own.carried;
  }
}

void GrainSolver::mend(std::span<const Collider> colliders, float t1) {
  // A clump that goes back from one wall may come to another.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds && clumps_.mend(bodies_); ++round)
    if (round + 1 < kRounds) guard(colliders, t1);
}

}  // namespace scree::grains
