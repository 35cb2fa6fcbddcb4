// Falling asleep and waking: see rest.h for the rules.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "modules/grains/cohesion.h"
#include "modules/grains/rest.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

using glm::length;

bool apart(vec3 low, vec3 high, const Bounds& bounds) {
  return high.x < bounds.min.x || bounds.max.x < low.x || high.y < bounds.min.y ||
         bounds.max.y < low.y || high.z < bounds.min.z || bounds.max.z < low.z;
}

// Of settled_: has been still for long; a neighbour that it leans on has not; falls asleep now.
constexpr uint8_t kStill = 1, kHeldUp = 2, kFalling = 4;

}  // namespace

// What disturbs sleepers before the tick: another gravity or tick length, and colliders that are
// new, changed or moving, or that were there and have changed or gone.
void GrainSolver::findDisturbed(std::span<const Collider> colliders,
                                const StepParameters& parameters) {
  if (sleepers_.count() == 0 || last_h_ == 0) return;
  if (substepOf(parameters) != last_h_ || parameters.gravity != last_gravity_) {
    sleepers_.each([&](uint32_t berth) { waking_.push_back(berth); });
    return;
  }
  // Nobody awake, who could hold them.
  if (awake_.empty()) waking_.insert(waking_.end(), waiting_.begin(), waiting_.end());
  findPushed(parameters);
  size_t staying = 0;
  for (const Collider& collider : colliders) {
    const bool same = walls_.sweptLast(collider) != nullptr;
    staying += same;
    const bool gives = rigids_.awake(collider);
    if (same && !collider.moves() && !gives) continue;
    // A body is where it is, not where it was listed.
    const Collider swept = gives ? rigids_.overTick(collider, parameters.gravity, parameters.dt) : collider;
    const Bounds bounds = sweptBounds(swept);
    const float motion = motionBound(swept);
    const PosedCollider begin = poseCollider(swept, 0, 0, 0);
    sleepers_.near(bounds.min, bounds.max, [&](uint32_t berth) {
      const Sleeper& sleeper = sleepers_[berth];
      const float reach = (sleepers_.materialOf(berth).cohesion > 0 ? 1.01f + kReach : 1.01f) * sleeper.radius;
      if (!apart(sleeper.position - reach, sleeper.position + reach, bounds) &&
          nearestSurface(begin, sleeper.position).distance < reach + motion)
        waking_.push_back(berth);
    });
  }
  if (staying == walls_.swept().size()) return;
  for (const ColliderLists::Swept& swept : walls_.swept()) {
    const auto now = std::lower_bound(
        colliders.begin(), colliders.end(), swept.collider.key,
        [](const Collider& collider, uint32_t key) { return collider.key < key; });
    if (now == colliders.end() || now->key != swept.collider.key ||
        walls_.sweptLast(*now) == nullptr) {
      sleepers_.pressing(swept.collider.key, [&](uint32_t berth) { waking_.push_back(berth); });
      sleepers_.unbookAll(swept.collider.key, to_book_);
    }
  }
}

// Sleepers that are about to be struck take part in the impact.
void GrainSolver::findStruck(const StepParameters& parameters) {
  if (sleepers_.count() == 0) return;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    for (const uint32_t c : pairs_.slab[s].border) {
      uint32_t sleeper = pairs_.slab[s].i[c], other = pairs_.slab[s].j[c];
      if (!isAsleep(bodies_, sleeper)) std::swap(sleeper, other);
      if (!isAsleep(bodies_, sleeper) || !isAwake(bodies_, other)) continue;
      const Body &a = bodies_.body[sleeper], &b = bodies_.body[other];
      const vec3 d = a.position - b.position;
      const float distance = length(d), closing = glm::dot(b.velocity, d) / distance;
      if (closing > kStrike && distance - a.radius - b.radius < closing * parameters.dt)
        waking_.push_back(bodies_.berth[sleeper]);
    }
  }
}

void GrainSolver::addPairLoad(const PairSlab& slab, uint32_t contact) {
  const vec3 impulse = slab.impulseAt(contact);
  const float size = length(impulse);
  Load &i = load_[slab.i[contact]], &j = load_[slab.j[contact]];
  i.impulse += impulse;
  i.carried += size;
  j.impulse -= impulse;
  j.carried += size;
}

// Wakes those in waking_.
void GrainSolver::wake(std::span<const GrainRows> tables, vec3 gravity_step) {
  if (waking_.empty()) return;
  if (!clumps_.empty())
    for (size_t k = waking_.size(); k-- > 0;)
      sleepers_.eachOfClump(waking_[k], [&](uint32_t berth) { waking_.push_back(berth); });
  std::sort(waking_.begin(), waking_.end());
  waking_.erase(std::unique(waking_.begin(), waking_.end()), waking_.end());
  partners_.clear();
  for (const uint32_t berth : waking_) {
    const Sleeper sleeper = sleepers_[berth];
    const GrainMaterial material = sleepers_.materialOf(berth);
    sleepers_.wake(berth, woken_pairs_, woken_walls_, partners_);
    const uint32_t slot = sleeper.slot != kNoSlot ? sleeper.slot
                                                  : appendBody(sleeper.entity, material,
                                                               sleeper.position, sleeper.radius);
    bodies_.berth[slot] = kAwake;
    setPlace(sleeper.entity, slot);
    append(awake_, {sleeper.row, slot});
  }
  for (const uint32_t berth : partners_)
    if (sleepers_[berth].radius > 0) {
      sleepers_.weigh(berth, gravity_step);
      sleepers_.eachOfClump(berth, [&](uint32_t member) {
        sleepers_.unbook(member);
        append(to_book_, member);
      });
    }
  partners_.clear();
  // The rows of those that are new in awake_.
  std::sort(awake_.begin() + static_cast<std::ptrdiff_t>(awake_sorted_), awake_.end(), beforeRow);
  eachRow(tables, std::span(awake_).subspan(awake_sorted_),
          [](const GrainRows& table, size_t k, uint32_t) {
            if (!table.rest.empty()) table.rest[k] = {table.grain[k].position, 0, false};
          });
  rouseClumps(awake_sorted_);
  sortAwake();
  stats_.woken += static_cast<uint32_t>(waking_.size());
  std::erase_if(waiting_, [&](uint32_t berth) { return sleepers_[berth].radius == 0; });
  waking_.clear();
  search_due_ = true;
}

// Counts how long each grain has been still, and lets those fall asleep that are due.
void GrainSolver::settle(std::span<const GrainRows> tables, const StepParameters& parameters,
                         vec3 gravity_step, float dt) {
  settled_.assign(bodies_.count, kStill);  // as sleepers are
  size_t due = 0;
  eachRow(tables, awake_, [&](const GrainRows& table, size_t k, uint32_t slot) {
    settled_[slot] = 0;
    if (table.rest.empty()) return;
    GrainRest& rest = table.rest[k];
    const float radius = table.grain[k].radius;
    const vec3 way = table.grain[k].position - rest.anchor, v = table.velocity[k].linear,
               w = table.spin[k].angular * radius;
    const float most = kStillWay * radius;
    if (!(glm::dot(way, way) <= most * most) ||
        !(glm::dot(v, v) + glm::dot(w, w) <= kStillSpeed * kStillSpeed) ||
        wakesAny(parameters.forces, table.grain[k].position)) {
      rest = {table.grain[k].position, 0, false};
      return;
    }
    rest.still += dt;
    if (rest.still < kFallAsleep) return;
    settled_[slot] = kStill;
    ++due;
  });
  settleClumps(kStill);
  if (due == 0 || !mayChangeSleepers()) return;
  const uint32_t listed = pairs_.bodyCount();
  const auto eachContact = [&](const auto& visit) {
    for (uint32_t s = 0; s < pairs_.slab_count; ++s)
      for (uint32_t c = 0; c < pairs_.slab[s].count; ++c)
        if (pairs_.slab[s].i[c] < listed && pairs_.slab[s].carriesImpulse(c))
          visit(pairs_.slab[s], c);
  };
  eachContact([&](const PairSlab& slab, uint32_t c) {
    uint8_t &i = settled_[slab.i[c]], &j = settled_[slab.j[c]];
    if ((i & kStill) == 0) j |= kHeldUp;
    if ((j & kStill) == 0) i |= kHeldUp;
  });
  // Who leans on a body awake may be moved by it.
  if (rigids_.anyAwake())
    for (const ColliderSlab& slab : slabsInUse())
      for (const ColliderContact& contact : slab.contact)
        if (contact.gives && contact.impulse != vec3(0)) settled_[contact.grain] |= kHeldUp;
  settleClumps(kStill);
  const Workspace::Mark before = workspace_.mark();
  load_ = workspace_.take<Load>(bodies_.count, Load{});
  eachContact([&](const PairSlab& slab, uint32_t c) { addPairLoad(slab, c); });
  for (uint32_t s = 0; s < walls_.slab_count; ++s)
    for (const ColliderContact& contact : walls_.slab[s].contact) {
      load_[contact.grain].impulse += contact.impulse;
      load_[contact.grain].carried += length(contact.impulse);
    }
  size_t falling = 0;
  for (const AwakeRow& awake : awake_) {
    uint8_t& settled = settled_[awake.slot];
    if (settled != kStill) continue;
    const Body& body = bodies_.body[awake.slot];
    float mass = grainMass(body.radius, bodies_.materialOf(awake.slot).density);
    Load load = load_[awake.slot];
    if (!bodies_.clump.empty()) loadOfClump(awake.slot, mass, load);
    if (length(load.impulse + mass * gravity_step) >
        kBalanced * mass * length(gravity_step) + kBalancedShare * load.carried)
      continue;
    settled |= kFalling;
    ++falling;
  }
  workspace_.giveBack(before);
  // Each time costs a search.
  if (falling == 0 || kTogether * falling < awake_.size()) return;
  layToSleep(tables, gravity_step);
}

bool GrainSolver::mayChangeSleepers() const { return calm_ >= kCalm || search_due_; }

bool GrainSolver::isStill(uint32_t slot) const { return (settled_[slot] & kStill) != 0; }

// Makes sleepers of those that fall asleep.
void GrainSolver::layToSleep(std::span<const GrainRows> tables, vec3 gravity_step) {
  const auto falls = [&](uint32_t slot) { return (settled_[slot] & kFalling) != 0; };
  size_t stay = 0;
  const std::span<AwakeRow> all(awake_);
  eachRow(tables, all, [&](const GrainRows& table, size_t k, uint32_t slot) {
    if (!falls(slot)) return;
    table.rest[k] = {table.grain[k].position, table.rest[k].still, true};
    table.velocity[k].linear = vec3(0);
    table.spin[k].angular = vec3(0);
    table.previous[k].position = table.grain[k].position;
  });
  falling_.clear();
  for (const AwakeRow& awake : all) {
    if (!falls(awake.slot)) {
      awake_[stay++] = awake;
      continue;
    }
    Body& body = bodies_.body[awake.slot];
    const uint32_t berth = sleepers_.lay({.position = body.position,
                                          .radius = body.radius,
                                          .slot = awake.slot,
                                          .row = awake.row,
                                          .entity = bodies_.entity[awake.slot]},
                                         bodies_.materialOf(awake.slot));
    body.velocity = body.spin = vec3(0);
    body.inverse_mass = body.gravity_scale = 0;
    bodies_.berth[awake.slot] = berth;
    setPlace(bodies_.entity[awake.slot], berth | kBerthBit);
    append(falling_, berth);
  }
  awake_.resize(stay);
  awake_sorted_ = stay;
  layClumps();

  const uint32_t listed = pairs_.bodyCount();
  for (uint32_t k = 0; k < bodies_.count; ++k)
    if (isAsleep(bodies_, k) && std::exchange(sleepers_[bodies_.berth[k]].propped, false))
      append(falling_, bodies_.berth[k]);
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c) {
      const uint32_t i = slab.i[c], j = slab.j[c];
      if (i >= listed || !slab.carriesImpulse(c)) continue;
      if (!isAsleep(bodies_, i) || !isAsleep(bodies_, j)) {
        for (const uint32_t slot : {i, j})
          if (isAsleep(bodies_, slot)) sleepers_[bodies_.berth[slot]].propped = true;
        continue;
      }
      if (!falls(i) && !falls(j)) continue;
      sleepers_.lean(bodies_.berth[i], bodies_.berth[j], slab.impulseAt(c), slab.rollingAt(c));
      for (const uint32_t slot : {i, j})
        if (!falls(slot)) append(falling_, bodies_.berth[slot]);
    }
    for (const ColliderContact& contact : walls_.slab[s].contact)
      if (falls(contact.grain) && contact.impulse != vec3(0))
        sleepers_.leanOn(bodies_.berth[contact.grain], contact);
  }
  bookLeftOver(gravity_step);
  search_due_ = true;
  calm_ = 0;
  stats_.asleep = sleepers_.count();
}

// Of the sleepers in falling_, whose contacts have changed.
void GrainSolver::bookLeftOver(vec3 gravity_step) {
  std::sort(falling_.begin(), falling_.end());
  falling_.erase(std::unique(falling_.begin(), falling_.end()), falling_.end());
  for (const uint32_t berth : falling_) sleepers_.weigh(berth, gravity_step);
  // Of the others, those awake press on them: findUnbalanced() knows how much.
  for (const uint32_t berth : falling_)
    if (!sleepers_[berth].propped) sleepers_.book(berth, gravity_step, vec3(0));
}

void GrainSolver::bookRest(vec3 gravity_step) {
  if (to_book_.empty()) return;
  falling_.swap(to_book_);
  to_book_.clear();
  bookLeftOver(gravity_step);
}

// What sleepers press on sensed colliders, over a tick.
void GrainSolver::addSleepersLoads(std::span<Collider> colliders, int substeps) const {
  for (Collider& collider : colliders) {
    if (!collider.sensed) continue;
    const Sleepers::WallLoad* load = sleepers_.loadOn(collider.key);
    if (load == nullptr) continue;
    for (int axis = 0; axis < 3; ++axis)
      collider.load[axis] -= substeps * load->impulse[static_cast<size_t>(axis)].value();
    collider.load_contacts += load->contacts;
  }
}

bool GrainSolver::sleepOn(std::span<Collider> colliders, const StepParameters& parameters) {
  if (!awake_.empty() || sleepers_.count() == 0 || adopt_due_ || !refused_.empty() || !lost_.empty())
    return false;
  strikes_.begin(parameters.strikes, parameters.substeps);
  rigids_.begin(parameters.bodies, colliders);
  if (rigids_.anyAwake()) return false;
  findDisturbed(colliders, parameters);
  if (!rigids_.empty() && wakeRigids(colliders, parameters)) {
    waking_.clear();
    return false;
  }
  if (!waking_.empty()) {
    waking_.clear();  // step() finds them again
    return false;
  }
  walls_.sweep(colliders);
  for (Collider& collider : colliders) {
    collider.load = glm::dvec3(0);
    collider.load_contacts = 0;
  }
  bookRest(parameters.gravity * substepOf(parameters));
  addSleepersLoads(colliders, std::clamp(parameters.substeps, 1, 64));
  if (!rigids_.empty()) stepRigids(colliders, parameters);
  stats_.rebuilds = stats_.woken = 0;
  measure();
  return true;
}

}  // namespace scree::grains
