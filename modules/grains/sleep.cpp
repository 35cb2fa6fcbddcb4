// Falling asleep and waking: see rest.h for the rules.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/rest.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

float length(vec3 v) { return std::sqrt(glm::dot(v, v)); }

}  // namespace

// Calls visit(table, row of it, slot) for the rows that may sleep.
template <class Visit>
void GrainSolver::eachRest(std::span<const GrainRows> tables, const Visit& visit) const {
  size_t row = 0;
  for (const GrainRows& table : tables)
    for (size_t k = 0; k < table.entity.size(); ++k, ++row)
      if (slot_of_row_[row] != kNoSlot && !table.rest.empty()) visit(table, k, slot_of_row_[row]);
}

// Impulse of gravity on a grain in a substep, N s.
float GrainSolver::weight(uint32_t slot, vec3 gravity_step) const {
  const float mass = grainMass(bodies_.body[slot].radius, bodies_.material[slot].density);
  return mass * length(gravity_step);
}

// What disturbs sleepers before the tick: colliders, another gravity or tick length.
void GrainSolver::wakeDisturbed(std::span<const GrainRows> tables,
                                std::span<const Collider> colliders,
                                const StepParameters& parameters, float h) {
  asleep_ = static_cast<uint32_t>(
      std::count(bodies_.asleep.begin(), bodies_.asleep.end(), Sleep::Asleep));
  stats_.asleep = asleep_;
  if (asleep_ == 0) return;
  const bool first = last_h_ == 0;
  if (!first && (h != last_h_ || parameters.gravity != last_gravity_)) {
    for (Sleep& sleep : bodies_.asleep)
      if (sleep == Sleep::Asleep) sleep = Sleep::Waking;
  } else if (!first && !walls_.rest(colliders)) {
    walls_.wakeDisturbed(bodies_, colliders);
  }
  // What is about to be struck takes part in the impact. Slots are those of the lists unless grains
  // came or went.
  if (!adopted_) {
    for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
      for (const uint32_t c : pairs_.slab[s].border) {
        uint32_t sleeper = pairs_.slab[s].i[c], other = pairs_.slab[s].j[c];
        if (!isAsleep(bodies_, sleeper)) std::swap(sleeper, other);
        if (!isAsleep(bodies_, sleeper) || isAsleep(bodies_, other)) continue;
        const Body &a = bodies_.body[sleeper], &b = bodies_.body[other];
        const vec3 d = a.position - b.position;
        const float distance = length(d), closing = glm::dot(b.velocity, d) / distance;
        if (closing > kStrike && distance - a.radius - b.radius < closing * parameters.dt)
          bodies_.asleep[sleeper] = Sleep::Waking;
      }
    }
  }
  eachRest(tables, [&](const GrainRows& table, size_t k, uint32_t slot) {
    if (bodies_.asleep[slot] != Sleep::Waking) return;
    table.rest[k] = {table.grain[k].position, 0, false};
    bodies_.asleep[slot] = Sleep::Awake;
    Body& body = bodies_.body[slot];
    body.inverse_mass = 1 / grainMass(body.radius, bodies_.material[slot].density);
    body.gravity_scale = 1;
    search_due_ = true;
    --asleep_;
    ++stats_.woken;
  });
  stats_.asleep = asleep_;
}

// After rows have gone: sleepers that one of the removed grains pressed on. Rows still name the
// slots of before.
void GrainSolver::wakeNeighboursOfRemoved(std::span<const GrainRows> tables) {
  if (asleep_ == 0 || pairs_.slab_count == 0) return;
  std::vector<Sleep>& now = bodies_.asleep;
  std::vector<uint8_t> stays(now.size(), 0);
  for (const uint32_t slot : slot_of_row_)
    if (slot != kNoSlot) stays[slot] = 1;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c) {
      const uint32_t i = slab.i[c], j = slab.j[c];
      if (i >= stays.size() || stays[i] == stays[j] || !slab.carriesImpulse(c)) continue;
      now[stays[i] != 0 ? i : j] = Sleep::Waking;
    }
  }
  eachRest(tables, [&](const GrainRows& table, size_t k, uint32_t slot) {
    if (now[slot] != Sleep::Waking || !table.rest[k].asleep) return;
    table.rest[k] = {table.grain[k].position, 0, false};
    ++stats_.woken;
  });
}

void GrainSolver::addPairLoad(std::vector<Load>& load, const PairSlab& slab,
                              uint32_t contact) const {
  const vec3 impulse = slab.impulseAt(contact);
  const float size = length(impulse);
  Load &i = load[slab.i[contact]], &j = load[slab.j[contact]];
  i.impulse += impulse;
  i.carried += size;
  j.impulse -= impulse;
  j.carried += size;
}

// What gravity, the colliders and the contacts among sleepers leave over on each sleeper: constant
// until the lists are made again.
void GrainSolver::loadSleepers(vec3 gravity_step) {
  if (asleep_ == 0) return;
  refill(load_asleep_, bodies_.count, Load{});
  for (uint32_t k = 0; k < bodies_.count; ++k)
    if (isAsleep(bodies_, k))
      load_asleep_[k].impulse =
          grainMass(bodies_.body[k].radius, bodies_.material[k].density) * gravity_step;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = slab.active; c < slab.count; ++c)
      if (slab.i[c] < bodies_.count) addPairLoad(load_asleep_, slab, c);
    for (const ColliderContact& contact : walls_.slab[s].contact) {
      if (!isAsleep(bodies_, contact.grain)) continue;
      load_asleep_[contact.grain].impulse += contact.impulse;
      load_asleep_[contact.grain].carried += length(contact.impulse);
    }
  }
  load_ = load_asleep_;
}

// Marks sleepers on which those awake press harder, or less, than the others can bear.
void GrainSolver::wakeUnbalanced(vec3 gravity_step) {
  if (asleep_ == 0) return;
  const auto eachBorder = [&](const auto& visit) {
    for (uint32_t s = 0; s < pairs_.slab_count; ++s)
      for (const uint32_t c : pairs_.slab[s].border) {
        const PairSlab& slab = pairs_.slab[s];
        visit(slab, c, isAsleep(bodies_, slab.i[c]) ? slab.i[c] : slab.j[c]);
      }
  };
  eachBorder([&](const PairSlab& slab, uint32_t c, uint32_t) { addPairLoad(load_, slab, c); });
  eachBorder([&](const PairSlab&, uint32_t, uint32_t sleeper) {
    if (bodies_.asleep[sleeper] == Sleep::Waking) return;
    const Load& load = load_[sleeper];
    if (length(load.impulse) <=
        kUnbalanced * weight(sleeper, gravity_step) + kUnbalancedShare * load.carried)
      return;
    bodies_.asleep[sleeper] = Sleep::Waking;
    ++stats_.woken;
    --stats_.asleep;
  });
  eachBorder([&](const PairSlab& slab, uint32_t c, uint32_t) {
    load_[slab.i[c]] = load_asleep_[slab.i[c]];
    load_[slab.j[c]] = load_asleep_[slab.j[c]];
  });
}

// Counts how long each grain has been still, and lets those fall asleep that are due.
void GrainSolver::settle(std::span<const GrainRows> tables, vec3 gravity_step, float dt) {
  uint32_t awake = 0, due = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.rest.size(); ++k) {
      GrainRest& rest = table.rest[k];
      if (rest.asleep) continue;
      const float radius = table.grain[k].radius;
      const vec3 way = table.grain[k].position - rest.anchor, v = table.velocity[k].linear,
                 w = table.spin[k].angular * radius;
      const float most = kStillWay * radius;
      ++awake;
      if (!(glm::dot(way, way) <= most * most) ||
          !(glm::dot(v, v) + glm::dot(w, w) <= kStillSpeed * kStillSpeed)) {
        rest = {table.grain[k].position, 0, false};
        continue;
      }
      rest.still += dt;
      due += rest.still >= kFallAsleep;
    }
  }
  if (due == 0 || static_cast<float>(due) < kTogether * static_cast<float>(awake)) return;

  refill(load_, bodies_.count, Load{});
  for (uint32_t k = 0; k < bodies_.count; ++k)
    load_[k].impulse = grainMass(bodies_.body[k].radius, bodies_.material[k].density) * gravity_step;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c)
      if (slab.i[c] < bodies_.count) addPairLoad(load_, slab, c);
    for (const ColliderContact& contact : walls_.slab[s].contact) {
      load_[contact.grain].impulse += contact.impulse;
      load_[contact.grain].carried += length(contact.impulse);
    }
  }
  eachRest(tables, [&](const GrainRows& table, size_t k, uint32_t slot) {
    GrainRest& rest = table.rest[k];
    if (rest.asleep || rest.still < kFallAsleep) return;
    const float most =
        kBalanced * weight(slot, gravity_step) + kBalancedShare * load_[slot].carried;
    if (length(load_[slot].impulse) > most) return;
    rest = {table.grain[k].position, rest.still, true};
    table.velocity[k].linear = vec3(0);
    table.spin[k].angular = vec3(0);
    table.previous[k].position = table.grain[k].position;
    ++stats_.asleep;
  });
}

// Loads of colliders on a tick of nothing but sleepers.
void GrainSolver::passLoads(std::span<Collider> colliders, int substeps) {
  stats_.rebuilds = stats_.pairs_solved = 0;
  stats_.kinetic_energy = 0;
  for (int substep = 0; substep < substeps; ++substep)
    collectLoads(colliders, substep + 1 == substeps);
}

bool GrainSolver::sleepOn(std::span<Collider> colliders, const StepParameters& parameters) {
  const int substeps = std::clamp(parameters.substeps, 1, 64);
  const float h = std::min(parameters.dt, kLongestTick) / static_cast<float>(substeps);
  if (bodies_.count == 0 || stats_.asleep != bodies_.count || !refused_.empty() || !lost_.empty() ||
      h != last_h_ || parameters.gravity != last_gravity_ || !walls_.rest(colliders))
    return false;
  stats_.woken = 0;
  for (Collider& collider : colliders) {
    collider.load = glm::dvec3(0);
    collider.load_contacts = 0;
  }
  passLoads(colliders, substeps);
  return true;
}

}  // namespace scree::grains
