// The solver's input and output: table rows to bodies and back, neighbour searches, counts.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "modules/grains/solver.h"

namespace scree::grains {

bool allowed(float radius, const GrainMaterial& material) {
  return radius >= kLeastRadius && radius <= kMostRadius && material.density >= kLeastDensity &&
         material.density <= kMostDensity && material.friction >= 0 && material.friction <= 1e3f &&
         material.rolling_friction >= 0 && material.rolling_friction <= 1e3f &&
         material.restitution >= 0 && material.restitution <= 1 && material.cohesion >= 0 &&
         material.cohesion <= kMostCohesion;
}

namespace {

bool rowAllowed(const Grain& grain, const GrainVelocity& velocity, const GrainSpin& spin,
                const GrainOrientation& orientation, const GrainMaterial& material) {
  const vec3 p = grain.position;
  const float q = glm::dot(orientation.rotation, orientation.rotation);
  return allowed(grain.radius, material) && finite(p) && std::abs(p.x) <= kMostDistance &&
         std::abs(p.y) <= kMostDistance && std::abs(p.z) <= kMostDistance && q > 0.25f && q < 4 &&
         glm::dot(velocity.linear, velocity.linear) <= kMostSpeed * kMostSpeed &&
         glm::dot(spin.angular, spin.angular) * grain.radius * grain.radius <=
             kMostSpeed * kMostSpeed;
}

}  // namespace

uint32_t GrainSolver::placeOf(Entity entity) const {
  const uint32_t place = entity.index < place_.size() ? place_[entity.index] : kNoSlot;
  if (place == kNoSlot) return kNoSlot;
  const Entity there = (place & kBerthBit) != 0 ? sleepers_[place & ~kBerthBit].entity
                                                : bodies_.entity[place];
  return there == entity ? place : kNoSlot;
}

void GrainSolver::setPlace(Entity entity, uint32_t place) {
  if (entity.index >= place_.size())
    place_.resize(std::max<size_t>(entity.index + 1, roomFor(place_.size())), kNoSlot);
  place_[entity.index] = place;
}

// A body at rest, awake; behind those of the last search. Returns its slot.
uint32_t GrainSolver::appendBody(Entity entity, const GrainMaterial& material, vec3 position,
                                 float radius) {
  const uint32_t slot = bodies_.count++;
  bodies_.body.resize(slot);
  Body body;
  body.position = position;
  body.radius = radius;
  body.friction_root = std::sqrt(material.friction);
  append(bodies_.body, body);
  append(bodies_.entity, entity);
  append(bodies_.material, bodies_.materials.numberOf(material));
  append(bodies_.margin, 0);
  append(bodies_.berth, kAwake);
  return slot;
}

namespace {

// A sleeper's row as it was left.
bool sleepsOn(const GrainRows& table, size_t k, const Sleeper& sleeper, const GrainMaterial& material) {
  return !table.rest.empty() && table.rest[k].asleep &&
         table.grain[k].position == sleeper.position && table.grain[k].radius == sleeper.radius &&
         table.velocity[k].linear == vec3(0) && table.spin[k].angular == vec3(0) &&
         Materials::same(table.material[k], material);
}

}  // namespace

// Finds every row's grain: new ones become bodies (awake whatever their row says: how they lean is
// not known), those without a row go, and sleepers whose rows were written to, or that leaned on one
// that goes, are to wake.
void GrainSolver::adopt(std::span<const GrainRows> tables) {
  awake_.clear();
  const uint32_t bodies_before = bodies_.count;
  settled_.assign(bodies_before, 0);  // here: met
  sleepers_.each([&](uint32_t berth) { sleepers_[berth].row = sleepers_[berth].ring = kNoSlot; });
  uint32_t row = 0;
  for (const GrainRows& table : tables) {
    for (size_t k = 0; k < table.entity.size(); ++k, ++row) {
      const Entity entity = table.entity[k];
      if (!rowAllowed(table.grain[k], table.velocity[k], table.spin[k], table.orientation[k],
                      table.material[k])) {
        refused_.push_back(entity);
        continue;
      }
      uint32_t place = placeOf(entity);
      if (place == kNoSlot) {
        search_due_ = true;
        place = appendBody(entity, table.material[k], table.grain[k].position, table.grain[k].radius);
        setPlace(entity, place);
      } else if ((place & kBerthBit) != 0) {
        const uint32_t berth = place & ~kBerthBit;
        sleepers_[berth].row = row;
        if (!sleepsOn(table, k, sleepers_[berth], sleepers_.materialOf(berth))) waking_.push_back(berth);
        continue;
      } else {
        settled_[place] = 1;
      }
      append(awake_, {row, place});
    }
  }
  std::sort(refused_.begin(), refused_.end());  // whatever the order of the rows
  awake_sorted_ = awake_.size();
  adopt_due_ = false;
  adoptClumps(tables);

  const auto forget = [&](Entity entity, uint32_t place) {
    if (place_[entity.index] == place) place_[entity.index] = kNoSlot;
    search_due_ = true;
  };
  for (uint32_t slot = 0; slot < bodies_before; ++slot) {
    if (settled_[slot] != 0 || !isAwake(bodies_, slot)) continue;
    bodies_.berth[slot] = kGone;
    forget(bodies_.entity[slot], slot);
  }
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (const uint32_t c : slab.border) {
      uint32_t sleeper = slab.i[c], other = slab.j[c];
      if (!isAsleep(bodies_, sleeper)) std::swap(sleeper, other);
      if (isAsleep(bodies_, sleeper) && bodies_.berth[other] == kGone && slab.carriesImpulse(c))
        waking_.push_back(bodies_.berth[sleeper]);
    }
  }
  falling_.clear();
  sleepers_.each([&](uint32_t berth) {
    if (sleepers_[berth].row == kNoSlot) falling_.push_back(berth);
  });
  if (falling_.empty()) return;
  for (const uint32_t berth : falling_) {
    const Sleeper& gone = sleepers_[berth];
    if (gone.slot != kNoSlot) bodies_.berth[gone.slot] = kGone;
    forget(gone.entity, berth | kBerthBit);
    sleepers_.wake(berth, woken_pairs_, woken_walls_, waking_);
  }
  // A berth given up is nobody's; those that leaned on two are named twice.
  std::erase_if(waking_, [&](uint32_t berth) { return !(sleepers_[berth].radius > 0); });
}

// Brings awake_ in order, of which the tail is new.
void GrainSolver::sortAwake() {
  const auto tail = awake_.begin() + static_cast<std::ptrdiff_t>(awake_sorted_);
  std::sort(tail, awake_.end(), beforeRow);
  std::inplace_merge(awake_.begin(), tail, awake_.end(), beforeRow);
  awake_sorted_ = awake_.size();
}

void GrainSolver::readRows(std::span<const GrainRows> tables) {
  eachRow(tables, awake_, [&](const GrainRows& table, size_t k, uint32_t slot) {
    Body& body = bodies_.body[slot];
    const Grain& grain = table.grain[k];
    if (!Materials::same(bodies_.materialOf(slot), table.material[k])) {
      bodies_.material[slot] = bodies_.materials.numberOf(table.material[k]);
      body.friction_root = std::sqrt(table.material[k].friction);
      search_due_ = true;
    }
    if (body.radius != grain.radius) search_due_ = true;
    body.position = grain.position;
    body.radius = grain.radius;
    body.velocity = table.velocity[k].linear;
    body.spin = table.spin[k].angular;
    if (!table.rest.empty()) table.rest[k].asleep = false;
  });
}

void GrainSolver::writeRows(std::span<const GrainRows> tables, const StepParameters& parameters,
                            float dt) {
  eachRow(tables, awake_, [&](const GrainRows& table, size_t k, uint32_t slot) {
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
    const uint32_t clump = bodies_.clump.empty() ? kNoSlot : bodies_.clump[slot];
    q = clump != kNoSlot ? clumps_[clump].rotation
                         : glm::normalize(q + quat(0, half.x, half.y, half.z) * q);
    const vec3 p = body.position;
    const bool inside = p.x >= parameters.bounds_min.x && p.x <= parameters.bounds_max.x &&
                        p.y >= parameters.bounds_min.y && p.y <= parameters.bounds_max.y &&
                        p.z >= parameters.bounds_min.z && p.z <= parameters.bounds_max.z;
    if (!inside) lost_.push_back(table.entity[k]);
    // Beyond what is allowed: the next tick refuses it.
    if (!(glm::dot(p, p) < kMostDistance * kMostDistance)) adopt_due_ = true;
  });
  if (!lost_.empty()) loseClumps();
  std::sort(lost_.begin(), lost_.end());  // whatever the order of the rows
}

void GrainSolver::measure() {
  stats_.grains = static_cast<uint32_t>(awake_.size()) + sleepers_.count();
  stats_.asleep = sleepers_.count();
  const bool solved = !awake_.empty();
  stats_.visited = solved ? bodies_.count : 0;
  stats_.pairs = solved ? static_cast<uint32_t>(pairs_.pair_count) : 0;
  uint32_t contacts = sleepers_.contacts();
  float deepest = 0;
  for (uint32_t s = 0; solved && s < pairs_.slab_count; ++s) {
    const PairSlab& pairs = pairs_.slab[s];
    contacts += pairs.carried;
    for (const ColliderContact& contact : walls_.slab[s].contact)
      contacts += contact.impulse != vec3(0);
    deepest = std::max({deepest, pairs.deepest, walls_.slab[s].deepest});
  }
  stats_.contacts = contacts;
  stats_.deepest_overlap = deepest;
  double energy = 0;
  for (uint32_t k = 0; solved && k < bodies_.count; ++k) {
    const Body& b = bodies_.body[k];
    const float mass = grainMass(b.radius, bodies_.materialOf(k).density);
    energy += 0.5 * static_cast<double>(mass) *
              static_cast<double>(glm::dot(b.velocity, b.velocity) +
                                  0.4f * b.radius * b.radius * glm::dot(b.spin, b.spin));
  }
  stats_.kinetic_energy = energy;
  const size_t memory = memoryBytes();
  if (memory > memory_) ++stats_.allocations;
  memory_ = std::max(memory_, memory);
}

std::vector<std::pair<uint32_t, uint32_t>> GrainSolver::neighbourPairs(PairsThat which) const {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c) {
      if (slab.i[c] >= pairs_.bodyCount()) continue;
      if (which == PairsThat::Carry && !slab.carriesImpulse(c)) continue;
      const uint32_t a = bodies_.entity[slab.i[c]].index, b = bodies_.entity[slab.j[c]].index;
      pairs.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

size_t GrainSolver::memoryBytes() const {
  const auto of = [](const auto&... lists) { return (size_t{0} + ... + (lists.capacity() * sizeof(lists[0]))); };
  const Bodies& b = bodies_;
  size_t bytes = of(b.body, b.entity, b.material, b.margin, b.berth, b.clump) + b.materials.memoryBytes() +
                 workspace_.memoryBytes() + grid_.memoryBytes() + pairs_.memoryBytes() + walls_.memoryBytes() +
                 sleepers_.memoryBytes() + clumps_.memoryBytes() + rigids_.memoryBytes() + strikes_.memoryBytes() +
                 of(place_, awake_, settled_, strays_, met_, shifts_, chunk_flags_, driven_, posed_, posed_end_,
                    moved_walls_, forces_seen_) +
                 of(waking_, partners_, falling_, uneasy_, waiting_, to_book_, pressed_, touches_, touching_, clump_rows_) +
                 of(woken_pairs_, woken_walls_, joining_pairs_, joining_walls_, refused_, lost_, broken_);
  for (const auto& driven : driven_) bytes += of(driven);
  return bytes;
}

}  // namespace scree::grains
