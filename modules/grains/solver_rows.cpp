// The solver's input and output: table rows to bodies and back, neighbour searches, counts.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/core/parallel.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

bool finite(vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool allowed(const Grain& grain, const GrainVelocity& velocity, const GrainSpin& spin,
             const GrainOrientation& orientation, const GrainMaterial& material) {
  const vec3 p = grain.position;
  const float q = glm::dot(orientation.rotation, orientation.rotation);
  return grain.radius >= kLeastRadius && grain.radius <= kMostRadius &&
         material.density >= kLeastDensity && material.density <= kMostDensity &&
         material.friction >= 0 && material.friction <= 1e3f && material.rolling_friction >= 0 &&
         material.rolling_friction <= 1e3f && material.restitution >= 0 &&
         material.restitution <= 1 && finite(p) && std::abs(p.x) <= kMostDistance &&
         std::abs(p.y) <= kMostDistance && std::abs(p.z) <= kMostDistance && q > 0.25f && q < 4 &&
         glm::dot(velocity.linear, velocity.linear) <= kMostSpeed * kMostSpeed &&
         glm::dot(spin.angular, spin.angular) * grain.radius * grain.radius <=
             kMostSpeed * kMostSpeed;
}

}  // namespace

// Gives every allowed row a slot. True if grains came or went since the last tick.
bool GrainSolver::adopt(std::span<const GrainRows> tables) {
  // The same entities in the same rows, all allowed as before: nothing to do.
  size_t row = 0;
  bool same = true;
  uint32_t allowed_rows = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      const bool good = allowed(table.grain[k], table.velocity[k], table.spin[k],
                                table.orientation[k], table.material[k]);
      if (!good) refused_.push_back(table.entity[k]);
      allowed_rows += good;
      same = same && row < row_entity_.size() && row_entity_[row] == table.entity[k] &&
             (slot_of_row_[row] != kNoSlot) == good;
    }
  }
  std::sort(refused_.begin(), refused_.end());  // whatever the order of the rows
  if (same && row == row_entity_.size()) return false;

  // Where each entity is now.
  uint32_t highest = 0;
  for (uint32_t k = 0; k < bodies_.count; ++k)
    highest = std::max(highest, bodies_.entity[k].index);
  slot_of_index_.assign(bodies_.count > 0 ? size_t{highest} + 1 : 0, kNoSlot);
  for (uint32_t k = 0; k < bodies_.count; ++k) slot_of_index_[bodies_.entity[k].index] = k;
  const auto slotOf = [&](Entity entity) {
    const uint32_t slot =
        entity.index < slot_of_index_.size() ? slot_of_index_[entity.index] : kNoSlot;
    return slot != kNoSlot && bodies_.entity[slot] == entity ? slot : kNoSlot;
  };
  row_entity_.resize(row);
  slot_of_row_.resize(row);
  row = 0;
  uint32_t known = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      row_entity_[row] = table.entity[k];
      const bool good = allowed(table.grain[k], table.velocity[k], table.spin[k],
                                table.orientation[k], table.material[k]);
      slot_of_row_[row] = good ? slotOf(table.entity[k]) : kNoSlot;
      known += slot_of_row_[row] != kNoSlot;
    }
  }
  // The same grains in another order of rows.
  if (known == allowed_rows && known == bodies_.count) return false;

  wakeNeighboursOfRemoved(tables);
  old_history_.swap(history_);
  bodies_.count = allowed_rows;
  bodies_.body.resize(allowed_rows);
  bodies_.entity.resize(allowed_rows);
  bodies_.material.resize(allowed_rows);
  bodies_.reference.assign(allowed_rows, Reference{});
  bodies_.asleep.assign(allowed_rows, Sleep::Awake);
  history_.resize(allowed_rows);
  row = 0;
  uint32_t slot = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      if (!allowed(table.grain[k], table.velocity[k], table.spin[k], table.orientation[k],
                   table.material[k]))
        continue;
      const uint32_t was = slot_of_row_[row];
      history_[slot] = was != kNoSlot ? old_history_[was] : kNoSlot;
      bodies_.entity[slot] = table.entity[k];
      bodies_.material[slot] = table.material[k];
      slot_of_row_[row] = slot++;
    }
  }
  return true;
}

void GrainSolver::readRows(std::span<const GrainRows> tables) {
  size_t row = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      const uint32_t slot = slot_of_row_[row];
      if (slot == kNoSlot) continue;
      Body& body = bodies_.body[slot];
      const Grain& grain = table.grain[k];
      if (std::memcmp(&bodies_.material[slot], &table.material[k], sizeof(GrainMaterial)) != 0) {
        bodies_.material[slot] = table.material[k];
        search_due_ = true;
      }
      if (body.radius != grain.radius) search_due_ = true;
      body.position = grain.position;
      body.radius = grain.radius;
      body.velocity = table.velocity[k].linear;
      body.spin = table.spin[k].angular;
      body.inverse_mass = 1 / grainMass(grain.radius, table.material[k].density);
      body.friction_root = std::sqrt(table.material[k].friction);
      body.gravity_scale = 1;
      if (table.rest.empty()) continue;
      GrainRest& rest = table.rest[k];
      if (rest.asleep && (rest.anchor != grain.position || body.velocity != vec3(0) ||
                          body.spin != vec3(0))) {
        rest = {grain.position, 0, false};
        ++stats_.woken;
      }
      const Sleep now = rest.asleep ? Sleep::Asleep : Sleep::Awake;
      if (bodies_.asleep[slot] != now) search_due_ = true;
      bodies_.asleep[slot] = now;
      if (rest.asleep) {
        body.inverse_mass = 0;
        body.gravity_scale = 0;
      }
    }
  }
}

void GrainSolver::writeRows(std::span<const GrainRows> tables, const StepParameters& parameters,
                            float dt) {
  size_t row = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      const uint32_t slot = slot_of_row_[row];
      if (slot == kNoSlot) continue;
      if (isAsleep(bodies_, slot)) {
        if (bodies_.asleep[slot] == Sleep::Waking) table.rest[k] = {table.grain[k].position, 0, false};
        table.previous[k].position = table.grain[k].position;
        continue;
      }
      const Body& body = bodies_.body[slot];
      Grain& grain = table.grain[k];
      table.previous[k].position = grain.position;
      grain.position = body.position;
      table.velocity[k].linear = body.velocity;
      table.spin[k].angular = body.spin;
      // Rotation by 2 atan(|spin| dt / 2) about the spin: no libm, and the drawing code undoes it
      // in the same way for the previous orientation.
      quat& q = table.orientation[k].rotation;
      const vec3 half = body.spin * (0.5f * dt);
      q = glm::normalize(q + quat(0, half.x, half.y, half.z) * q);
      const vec3 p = body.position;
      const bool inside = p.x >= parameters.bounds_min.x && p.x <= parameters.bounds_max.x &&
                          p.y >= parameters.bounds_min.y && p.y <= parameters.bounds_max.y &&
                          p.z >= parameters.bounds_min.z && p.z <= parameters.bounds_max.z;
      if (!inside) lost_.push_back(table.entity[k]);
    }
  }
  std::sort(lost_.begin(), lost_.end());  // whatever the order of the rows
}

// Chooses each grain's margin: how far it may go before the next search. A wide margin makes
// searches rare and lists long; see kLifetimes.
void GrainSolver::chooseMargins(float h) {
  const uint32_t n = bodies_.count;
  margin_.resize(n);
  // Margins are measured from the mean motion, so that what falls together needs no search. Sums
  // are of integers: they do not depend on the order of the grains.
  constexpr float kScale = 1024;
  int64_t sum[3] = {0, 0, 0};
  for (uint32_t k = 0; k < n; ++k)
    for (int axis = 0; axis < 3; ++axis)
      sum[axis] += static_cast<int64_t>(bodies_.body[k].velocity[axis] * kScale);
  const auto mean = [&](int axis) {
    return static_cast<float>(static_cast<double>(sum[axis]) / (kScale * static_cast<double>(n)));
  };
  drift_ = asleep_ == 0 ? vec3(mean(0), mean(1), mean(2)) : vec3(0);
  if (glm::dot(drift_, drift_) < 0.25f) drift_ = vec3(0);
  drift_time_ = 0;

  // Substeps that a search should last, and the growth of the lists that is paid for it.
  constexpr float kLifetimes[] = {6, 4, 2.5f, 1.5f};
  constexpr uint64_t kMostGrowth = 2200;  // thousandths of the volume that the radii span
  for (const float lifetime : kLifetimes) {
    uint64_t volume = 0;
    for (uint32_t k = 0; k < n; ++k) {
      const Body& grain = bodies_.body[k];
      const vec3 relative = grain.velocity - drift_;
      const float speed = std::sqrt(glm::dot(relative, relative));
      margin_[k] = std::min(0.12f * grain.radius + lifetime * h * speed, 4 * grain.radius);
      const float growth = 1 + margin_[k] / grain.radius;
      volume += static_cast<uint64_t>(1000 * growth * growth * growth);
    }
    if (volume <= kMostGrowth * n) break;
  }
}

void GrainSolver::searchNeighbours(float h) {
  const uint32_t n = bodies_.count;
  chooseMargins(h);
  grid_.plan(bodies_, margin_, order_);
  sorted_.count = n;
  const size_t padded = size_t{n} + size_t{grid_.slabCount()} * kIdleBodies;
  sorted_.body.resize(padded);
  sorted_.entity.resize(n);
  sorted_.material.resize(n);
  sorted_.reference.resize(n);
  sorted_.asleep.resize(n);
  slot_moved_.resize(n);
  for (uint32_t k = 0; k < n; ++k) {
    const uint32_t from = order_[k];
    sorted_.body[k] = bodies_.body[from];
    sorted_.entity[k] = bodies_.entity[from];
    sorted_.material[k] = bodies_.material[from];
    sorted_.asleep[k] = bodies_.asleep[from];
    sorted_.reference[k] = {bodies_.body[from].position, margin_[from]};
    slot_moved_[from] = k;
  }
  for (size_t k = n; k < padded; ++k) {
    Body idle;
    idle.radius = 1;
    idle.position = vec3(1e6f * static_cast<float>((k - n) % kIdleBodies), 0, 0);
    sorted_.body[k] = idle;
  }
  std::swap(bodies_, sorted_);
  for (uint32_t& slot : slot_of_row_)
    if (slot != kNoSlot) slot = slot_moved_[slot];
  grid_.read(bodies_);
  pairs_.build(grid_, bodies_, pairs_, order_, history_);
  search_due_ = false;
  walls_due_ = true;
  searched_ = true;
  ++stats_.rebuilds;
}

// Lists the grains near colliders; impulses are kept across this and across searches.
void GrainSolver::listColliders(std::span<const Collider> colliders, float dt) {
  // Grains move by their margin and by the drift until the lists are made again, next tick.
  const float extra = std::sqrt(glm::dot(drift_, drift_)) * dt;
  walls_.build(grid_, bodies_, colliders, extra, searched_, order_, history_);
  if (searched_) {
    for (uint32_t k = 0; k < bodies_.count; ++k) order_[k] = k;
    history_.resize(bodies_.count);
    for (uint32_t k = 0; k < bodies_.count; ++k) history_[k] = k;
    searched_ = false;
  }
  walls_due_ = false;
}

void GrainSolver::measure() {
  stats_.pairs = static_cast<uint32_t>(pairs_.pair_count);
  stats_.pairs_solved = static_cast<uint32_t>(pairs_.active_count);
  uint32_t contacts = 0;
  float deepest = 0;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& pairs = pairs_.slab[s];
    contacts += pairs.carried + pairs.carried_asleep;
    for (const ColliderContact& contact : walls_.slab[s].contact)
      contacts += contact.impulse != vec3(0);
    deepest = std::max({deepest, pairs.deepest, walls_.slab[s].deepest});
  }
  stats_.contacts = contacts;
  stats_.deepest_overlap = deepest;
  double energy = 0;
  for (uint32_t k = 0; k < bodies_.count; ++k) {
    const Body& b = bodies_.body[k];
    const float mass = grainMass(b.radius, bodies_.material[k].density);
    energy += 0.5 * static_cast<double>(mass) *
              static_cast<double>(glm::dot(b.velocity, b.velocity) +
                                  0.4f * b.radius * b.radius * glm::dot(b.spin, b.spin));
  }
  stats_.kinetic_energy = energy;
  const size_t memory = memoryBytes();
  if (memory > memory_) ++stats_.allocations;
  memory_ = std::max(memory_, memory);
}

std::vector<std::pair<uint32_t, uint32_t>> GrainSolver::neighbourPairs() const {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c) {
      if (slab.i[c] >= bodies_.count) continue;
      const uint32_t a = bodies_.entity[slab.i[c]].index, b = bodies_.entity[slab.j[c]].index;
      pairs.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

size_t GrainSolver::memoryBytes() const {
  const auto bodies = [](const Bodies& b) {
    return b.body.capacity() * sizeof(Body) + b.entity.capacity() * sizeof(Entity) +
           b.material.capacity() * sizeof(GrainMaterial) +
           b.reference.capacity() * sizeof(Reference) + b.asleep.capacity();
  };
  return bodies(bodies_) + bodies(sorted_) + grid_.memoryBytes() + pairs_.memoryBytes() +
         walls_.memoryBytes() +
         4 * (order_.capacity() + history_.capacity() + old_history_.capacity() +
              slot_of_index_.capacity() + slot_of_row_.capacity() + slot_moved_.capacity() +
              margin_.capacity()) +
         sizeof(Entity) * row_entity_.capacity() +
         sizeof(Load) * (load_.capacity() + load_asleep_.capacity()) +
         posed_.capacity() * sizeof(PosedCollider) + chunk_flags_.capacity();
}

}  // namespace scree::grains
