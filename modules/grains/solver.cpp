// One tick of the grains: the order of the solver's steps.
#include "modules/grains/rest.h"
#include "modules/grains/solver.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "engine/core/parallel.h"

namespace scree::grains {
namespace {

// Grains a task of the loops over all grains.
constexpr size_t kChunk = 8192;

// What forces add to the velocity in the substep, at whose begin the grain had `velocity_before`.
vec3 pushOn(const Body& grain, std::span<const Force> forces, vec3 gravity_step, float h) {
  return pushOf(forces, grain.position + 0.5f * h * grain.velocity_before, grain.velocity_before,
                gravity_step, h);
}

// What a fast blade drives against walls takes more passes, and the walls' word comes last.
void settleDriven(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                  PassSettings settings) {
  constexpr int kPasses = 3;
  for (int pass = 0; pass < kPasses; ++pass) relaxColliders(slab, body, posed, settings);
  settings.standing = true;
  relaxColliders(slab, body, posed, settings);
}

}  // namespace

float substepOf(const StepParameters& parameters) {
  return std::min(parameters.dt, kLongestTick) /
         static_cast<float>(std::clamp(parameters.substeps, 1, 64));
}

void GrainSolver::step(std::span<const GrainRows> tables, std::span<Collider> colliders,
                       const StepParameters& parameters, RowsAre rows) {
  refused_.clear();
  lost_.clear();
  broken_.clear();
  strikes_.begin(parameters.strikes, parameters.substeps);
  for (Collider& collider : colliders) {
    collider.load = glm::dvec3(0);
    collider.load_contacts = 0;
  }
  if (!(parameters.dt > 0)) {
    adopt_due_ = true;  // whatever is new is looked at in the next one
    return;
  }
  const float dt = std::min(parameters.dt, kLongestTick);
  const int substeps = std::clamp(parameters.substeps, 1, 64);
  const float h = substepOf(parameters);
  const vec3 gravity_step = parameters.gravity * h;
  const float keep = std::clamp(1 - parameters.damping * h, 0.0f, 1.0f);

  kernels_ = kernelsOf(parameters.lanes);
  if (kernels_ == nullptr) kernels_ = &kBaselineKernels;
  grid_.use(*kernels_);
  stats_.rebuilds = 0;
  stats_.woken = 0;
  size_t row_count = 0;
  for (const GrainRows& table : tables) row_count += table.entity.size();
  if (rows == RowsAre::Unknown || adopt_due_ || row_count != row_count_) {
    row_count_ = row_count;
    adopt(tables);
    wake(tables, gravity_step);
    readRows(tables);
  }
  rigids_.begin(parameters.bodies, colliders);
  walls_.bringFields(colliders);
  findDisturbed(colliders, parameters);
  if (!parameters.blows.empty()) {
    wake(tables, gravity_step);
    strikeBlows(parameters.blows);
  }
  findStruck(parameters);
  wake(tables, gravity_step);
  if (!rigids_.empty()) {
    // A body that wakes wakes the grains on it, which may lean on another.
    while (wakeRigids(colliders, parameters)) {
      findDisturbed(colliders, parameters);
      wake(tables, gravity_step);
    }
  }
  if (last_h_ > 0 && h != last_h_) scaleKeptImpulses(h / last_h_);
  last_h_ = h;
  last_gravity_ = parameters.gravity;
  if (awake_.empty()) {
    walls_.sweep(colliders);
    bookRest(gravity_step);
    if (!rigids_.empty()) stepRigids(colliders, parameters);
    addSleepersLoads(colliders, substeps);
    measure();
    return;
  }
  readyMasses();
  shareHeavyLoads();
  if (rigids_.anyAwake()) rigids_.ease(slabsInUse(), bodies_);
  walls_due_ = true;

  for (int substep = 0; substep < substeps; ++substep) {
    ++age_;
    predict(gravity_step, h, parameters.forces);
    if (rigids_.anyAwake()) {
      rigids_.predict(gravity_step, h, parameters.forces);
      walls_due_ = rigids_.relist(colliders, h, dt) || walls_due_;
    }
    if (!strays_.empty() && (search_due_ || !followStrays(h))) search_due_ = left_margin_ = true;
    if (search_due_) searchNeighbours(h);
    if (walls_due_) listColliders(colliders, dt, h);
    const bool clumps = !clumps_.moving().empty();
    if (clumps) clumps_.begin(bodies_);
    relax(colliders, parameters, h, substep);
    collectLoads(colliders, substep + 1 == substeps);
    move(gravity_step, h, keep, parameters.forces, !colliders.empty());
    if (rigids_.anyAwake()) {
      rigids_.addLoads(colliders, true, 1);
      rigids_.move(gravity_step, h);
    }
    if (clumps) clumps_.place(bodies_, gravity_step, h, keep);
    const float t1 = static_cast<float>(substep + 1) / static_cast<float>(substeps);
    guard(colliders, t1);
    if (clumps) mend(colliders, t1);
  }
  addSleepersLoads(colliders, substeps);
  writeRows(tables, parameters, dt);
  measure();
  calm_ = std::min(calm_ + 1, kCalm);
  settle(tables, parameters, gravity_step, dt);
  if (!rigids_.empty()) settleRigids(colliders, parameters, dt);
  findUnbalanced(gravity_step);
  wake(tables, gravity_step);
  bookRest(gravity_step);
  strikes_.close();
  adopt_due_ = adopt_due_ || !lost_.empty() || !refused_.empty() || !broken_.empty();
}

// Masses as they are, before shareHeavyLoads().
void GrainSolver::readyMasses() {
  for (uint32_t k = 0; k < bodies_.count; ++k) {
    if (!isAwake(bodies_, k)) continue;
    Body& body = bodies_.body[k];
    body.inverse_mass = 1 / grainMass(body.radius, bodies_.materialOf(k).density);
    body.gravity_scale = 1;
  }
  clumps_.giveMasses(bodies_);
}

// Adds gravity and forces, and notes the grains that may leave their margin within the substep.
void GrainSolver::predict(vec3 gravity_step, float h, std::span<const Force> forces) {
  const size_t chunks = (bodies_.count + kChunk - 1) / kChunk;
  chunk_flags_.assign(chunks, 0);
  const vec3 drift = drift_ * drift_time_;
  const auto leaves = [&](size_t k) {
    const Body& grain = bodies_.body[k];
    const Reference reference = grid_.referenceOf(bodies_, static_cast<uint32_t>(k));
    const vec3 strayed = grain.position - reference.position - drift;
    const vec3 relative = grain.velocity - drift_;
    const float way = glm::dot(strayed, strayed), next = h * h * glm::dot(relative, relative);
    // (a + b)^2 <= 2 (a^2 + b^2): hardly any grain needs the roots.
    return !(2.001f * (way + next) <= reference.margin * reference.margin) &&
           !(std::sqrt(way) + std::sqrt(next) <= reference.margin);
  };
  const Prediction prediction{gravity_step, h, drift_, drift};
  const size_t in_rows = forces.empty() ? std::min(bodies_.count, grid_.listed()) : 0;
  parallelChunks(bodies_.count, kChunk, [&](size_t chunk, size_t begin, size_t end) {
    bool any = false;
    size_t k = begin;
    for (; k + kRow <= std::min(end, in_rows); k += kRow)
      any = kernels_->predict(&bodies_.body[k], grid_.reachesFrom(static_cast<uint32_t>(k)), &bodies_.margin[k],
                              prediction) || any;
    for (; k < end; ++k) {
      Body& grain = bodies_.body[k];
      grain.velocity_before = grain.velocity;
      grain.velocity += grain.gravity_scale * gravity_step;
      if (!forces.empty()) grain.velocity += grain.gravity_scale * pushOn(grain, forces, gravity_step, h);
      any = leaves(k) || any;
    }
    chunk_flags_[chunk] = any;
  });
  strays_.clear();
  for (size_t chunk = 0; chunk < chunks; ++chunk) {
    if (chunk_flags_[chunk] == 0) continue;
    const size_t end = std::min<size_t>(bodies_.count, (chunk + 1) * kChunk);
    for (size_t k = chunk * kChunk; k < end && strays_.size() <= kMostStrays; ++k)
      if (leaves(k)) strays_.push_back(static_cast<uint32_t>(k));
  }
}

void GrainSolver::relax(std::span<Collider> colliders, const StepParameters& parameters, float h,
                        int substep) {
  PassSettings settings;
  settings.h = h;
  settings.inverse_h = 1 / h;
  settings.gravity_step = parameters.gravity * h;
  // Gravity's own kick must not bounce: twice what it adds in a substep, and a slow crawl.
  settings.bounce_speed = std::max(0.05f, 2 * glm::length(settings.gravity_step));
  settings.rolling = pairs_.rolling;
  settings.bouncing = pairs_.bouncing;
  settings.cohesive = pairs_.cohesive;

  const int substeps = std::clamp(parameters.substeps, 1, 64);
  poseColliders(colliders, substep, substeps, h);
  const bool bodies = rigids_.anyAwake();
  if (bodies) rigids_.findContacts(colliders, posed_, walls_.swept(), h, h * static_cast<float>(substeps));

  Body* body = bodies_.body.data();
  const uint32_t slabs = pairs_.slab_count;
  const Worth worth = worthOf(pairs_.pair_count + walls_.contact_count, kFewPairs);
  const auto alternate = [&](int first, const auto& visit) {
    for (uint32_t turn = 0; turn < 2; ++turn) {
      const size_t parity = (static_cast<uint32_t>(first) + turn) & 1;
      parallelChunks(slabs / 2, 1, [&](size_t s, size_t, size_t) {
        const size_t at = 2 * s + parity;
        visit(pairs_.slab[at], walls_.slab[at]);
      }, worth);
    }
  };
  alternate(0, [&](PairSlab& pairs, ColliderSlab& walls) {
    placeSurfaces(walls, body, posed_, h);
    kernels_->applyKept(pairs, body, settings);
    applyKeptColliders(walls, body);
  });
  if (bodies) rigids_.applyKept(slabsInUse(), body, colliders);
  const bool clumps = !clumps_.moving().empty();
  if (clumps) clumps_.project(bodies_);
  const int passes = std::clamp(parameters.passes, 1, 64);
  for (int pass = 0; pass < passes; ++pass) {
    settings.first_pass = pass == 0;
    alternate(pass + 1, [&](PairSlab& pairs, ColliderSlab& walls) {
      kernels_->relax(pairs, body, bodies_.entity.data(), settings);
      kernels_->relaxWalls(walls, body, posed_, settings);
    });
    if (bodies) rigids_.relax(slabsInUse(), body, colliders, posed_, settings);
    if (clumps) clumps_.project(bodies_);
  }
  // Colliders have the last word: where more passes would be needed, grains overlap a little
  // longer, but nothing is pressed through a wall.
  settings.first_pass = false;
  settings.tolerated = settings.bounce_speed;
  parallelChunks(slabs, 4, [&](size_t, size_t begin, size_t end) {
    for (size_t s = begin; s < end; ++s) {
      kernels_->relaxWalls(walls_.slab[s], body, posed_, settings);
      if (walls_.slab[s].driven) settleDriven(walls_.slab[s], body, posed_, settings);
    }
  }, worth);
  if (bodies) rigids_.endPasses(settings);
  strikes_.note(pairs_, walls_, bodies_);
  if (clumps) {
    clumps_.project(bodies_);
    clumps_.noteShifts(bodies_);
  }
  if (bounce() && clumps) clumps_.noteBounces(bodies_);
}

// Moves grains that bounced to where the impact within the substep leaves them; true if any did.
bool GrainSolver::bounce() {
  bool any = false;
  eachBounce([&](uint32_t slot, vec3 shift) {
    bodies_.body[slot].position += shift;
    any = true;
  });
  return any;
}

// Sums the impulses on sensed colliders, in the order of the lists.
void GrainSolver::collectLoads(std::span<Collider> colliders, bool last_substep) {
  const bool any = std::any_of(colliders.begin(), colliders.end(),
                               [](const Collider& c) { return c.sensed; });
  if (!any) return;
  for (uint32_t s = 0; s < walls_.slab_count; ++s) {
    const ColliderContact* counted = nullptr;  // a grain that touches a field twice counts once
    for (const ColliderContact& contact : walls_.slab[s].contact) {
      Collider& collider = colliders[contact.collider];
      if (!collider.sensed || contact.impulse == vec3(0)) continue;
      collider.load -= glm::dvec3(contact.impulse);
      if (!last_substep || (counted != nullptr && counted->grain == contact.grain &&
                            counted->collider == contact.collider))
        continue;
      ++collider.load_contacts;
      counted = &contact;
    }
  }
}

// Positions by the mean of the velocities before and after where the substep changed them no more
// than gravity would (exact for parabolas, for sliding and rolling), by the velocity after where a
// contact stopped the grain.
void GrainSolver::move(vec3 gravity_step, float h, float keep, std::span<const Force> forces,
                       bool walls) {
  const float smooth = 1.01f * glm::length(gravity_step);
  drift_time_ += h;
  // Slower grains stay where they are listed.
  const float fast = walls ? std::min(keep * least_margin_way_ / h, kMostSpeed) : kMostSpeed;
  const Motion motion{h, keep, fast, kMostSpeed};
  driven_.resize((bodies_.count + kChunk - 1) / kChunk);
  parallelChunks(bodies_.count, kChunk, [&](size_t chunk, size_t begin, size_t end) {
    std::array<float, kRow> most;
    most.fill(smooth * smooth);
    float from[3][kRow];
    for (size_t first = begin; first < end; first += kRow) {
      const size_t n = std::min<size_t>(kRow, end - first);
      Body* const row = &bodies_.body[first];
      for (size_t k = 0; k < n && !forces.empty(); ++k) {
        const vec3 push = pushOn(row[k], forces, gravity_step, h);
        const float pushes = smooth + 1.01f * std::sqrt(glm::dot(push, push));
        most[k] = pushes * pushes;
      }
      uint32_t fast_ones = 0;
      if (n == kRow) {
        fast_ones = kernels_->move(row, most.data(), motion, from);
      } else {
        std::array<Body, kRow> last;
        std::copy_n(row, n, last.begin());
        fast_ones = kernels_->move(last.data(), most.data(), motion, from) & ((1u << n) - 1);
        std::copy_n(last.begin(), n, row);
      }
      for (; fast_ones != 0; fast_ones &= fast_ones - 1) {
        const size_t k = static_cast<size_t>(std::countr_zero(fast_ones)), slot = first + k;
        Body& grain = row[k];
        // Only numbers beyond all physics are zeroed; they must not spread.
        if (!(glm::dot(grain.velocity, grain.velocity) <= kMostSpeed * kMostSpeed)) grain.velocity = vec3(0);
        const Reference reference = grid_.referenceOf(bodies_, static_cast<uint32_t>(slot));
        const vec3 strayed = grain.position - reference.position - drift_ * drift_time_;
        if (walls && !(glm::dot(strayed, strayed) <= reference.margin * reference.margin))
          driven_[chunk].push_back({static_cast<uint32_t>(slot), {from[0][k], from[1][k], from[2][k]}});
      }
    }
  });
}

void GrainSolver::scaleKeptImpulses(float factor) {
  // A force lasts h: its impulse scales with h. Far longer steps start afresh.
  const float scale = factor > 4 ? 0.0f : factor;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const auto scaled = [&](float(&p)[3][kBatch]) {
      for (auto& axis : p)
        for (float& lane : axis) lane *= scale;
    };
    for (ImpulseBatch& batch : pairs_.slab[s].impulse) scaled(batch.impulse);
    for (RollingBatch& batch : pairs_.slab[s].rolling) scaled(batch.impulse);
  }
  for (uint32_t s = 0; s < walls_.slab_count; ++s) {
    for (ColliderContact& contact : walls_.slab[s].contact) {
      contact.impulse *= scale;
      contact.rolling *= scale;
    }
  }
  rigids_.scaleKept(static_cast<double>(scale));
  for (WokenPair& pair : woken_pairs_) {
    pair.impulse *= scale;
    pair.rolling *= scale;
  }
  for (WokenWall& wall : woken_walls_) {
    wall.impulse *= scale;
    wall.rolling *= scale;
  }
}

// Gauss-Seidel needs about as many passes as the ratio of masses in a contact. A light grain that a
// heavy one rests on is therefore given 1 / kMostRatio of its mass while the contact lasts; gravity
// on it is scaled down, so that the forces stay those of the true masses. Up to that ratio nothing
// is changed.
void GrainSolver::shareHeavyLoads() {
  constexpr float kMostRatio = 1000;
  float lightest = 3e38f, heaviest = 0;
  for (uint32_t k = 0; k < bodies_.count; ++k) {
    if (!isAwake(bodies_, k)) continue;
    lightest = std::min(lightest, bodies_.body[k].inverse_mass);
    heaviest = std::max(heaviest, bodies_.body[k].inverse_mass);
  }
  if (!(heaviest > kMostRatio * lightest)) return;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (uint32_t c = 0; c < slab.count; ++c) {
      if (slab.i[c] >= pairs_.bodyCount() || !slab.carriesImpulse(c)) continue;
      if (!isAwake(bodies_, slab.i[c]) || !isAwake(bodies_, slab.j[c])) continue;
      Body &i = bodies_.body[slab.i[c]], &j = bodies_.body[slab.j[c]];
      Body& light = i.inverse_mass > j.inverse_mass ? i : j;
      const Body& heavy = i.inverse_mass > j.inverse_mass ? j : i;
      const float most = heavy.inverse_mass / heavy.gravity_scale * kMostRatio;
      if (light.inverse_mass <= most) continue;
      const float scale = most / light.inverse_mass;
      light.inverse_mass *= scale;
      light.gravity_scale *= scale;
    }
  }
  clumps_.shareScales(bodies_);
}

}  // namespace scree::grains
