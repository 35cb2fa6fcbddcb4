// The solver's dealings with rigid bodies: who wakes, ticks without a grain awake, who falls asleep.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/solver.h"

namespace scree::grains {

// True if a body woke.
bool GrainSolver::wakeRigids(std::span<const Collider> colliders, const StepParameters& parameters) {
  if (last_h_ > 0 && (substepOf(parameters) != last_h_ || parameters.gravity != last_gravity_)) rigids_.wakeAll();
  for (const WokenWall& wall : woken_walls_) rigids_.rouse(colliderKey(wall.key));
  if (!parameters.forces.empty())
    for (const Rigid& body : rigids_.bodies())
      if (wakesAny(parameters.forces, vec3(body.position))) rigids_.rouse(body.key);
  moved_walls_.resize(colliders.size());
  for (size_t k = 0; k < colliders.size(); ++k)
    moved_walls_[k] = colliders[k].moves() || (colliders[k].rigid == kNoSlot && walls_.sweptLast(colliders[k]) == nullptr);
  return rigids_.wakeRoused(colliders, moved_walls_, parameters.gravity, std::min(parameters.dt, kLongestTick));
}

void GrainSolver::poseColliders(std::span<const Collider> colliders, int substep, int substeps, float h) {
  const float whole = static_cast<float>(substeps);
  posed_.resize(colliders.size());
  for (size_t k = 0; k < colliders.size(); ++k)
    posed_[k] = poseCollider(colliders[k], static_cast<float>(substep) / whole,
                             static_cast<float>(substep + 1) / whole, h);
  if (rigids_.anyAwake()) rigids_.pose(posed_, colliders);
}

// A tick in which no grain is awake; sleepers that a body touches have woken before.
void GrainSolver::stepRigids(std::span<Collider> colliders, const StepParameters& parameters) {
  const int substeps = std::clamp(parameters.substeps, 1, 64), passes = std::clamp(parameters.passes, 1, 64);
  const float h = substepOf(parameters), dt = h * static_cast<float>(substeps);
  PassSettings settings;
  settings.h = h;
  settings.inverse_h = 1 / h;
  settings.gravity_step = parameters.gravity * h;
  settings.bounce_speed = std::max(0.05f, 2 * glm::length(settings.gravity_step));
  if (rigids_.anyAwake()) rigids_.ease({}, bodies_);
  for (int substep = 0; substep < substeps && rigids_.anyAwake(); ++substep) {
    rigids_.predict(settings.gravity_step, h, parameters.forces);
    if (rigids_.relist(colliders, h, dt)) walls_.sweep(colliders);
    poseColliders(colliders, substep, substeps, h);
    rigids_.findContacts(colliders, posed_, walls_.swept(), h, dt);
    rigids_.applyKept({}, nullptr, colliders);
    for (int pass = 0; pass < passes; ++pass) {
      settings.first_pass = pass == 0;
      rigids_.relax({}, nullptr, colliders, posed_, settings);
    }
    rigids_.addLoads(colliders, true, 1);
    rigids_.move(settings.gravity_step, h);
  }
  settleRigids(colliders, parameters, dt);
}

// The tick's end for bodies: what grains press on each, who falls asleep, rows.
void GrainSolver::settleRigids(std::span<Collider> colliders, const StepParameters& parameters, float dt) {
  rigids_.addLoads(colliders, false, std::clamp(parameters.substeps, 1, 64));
  std::vector<Rigids::Pressed>& pressed = rigids_.pressed();
  if (!awake_.empty())
    for (const ColliderSlab& slab : slabsInUse())
      for (const ColliderContact& contact : slab.contact) {
        const uint32_t k = colliders[contact.collider].rigid;
        if (k == kNoSlot || contact.impulse == vec3(0) || !isAwake(bodies_, contact.grain)) continue;
        pressed[k].impulse -= dvec3(contact.impulse);
        pressed[k].size += static_cast<double>(glm::length(contact.impulse));
        pressed[k].stirred = pressed[k].stirred || !isStill(contact.grain);
      }
  for (const Rigid& body : rigids_.bodies()) {
    Rigids::Pressed& own = pressed[colliders[body.collider].rigid];
    if (!parameters.forces.empty() && wakesAny(parameters.forces, vec3(body.position))) own.stirred = true;
    const Sleepers::WallLoad* load = sleepers_.loadOn(body.key);
    if (load == nullptr) continue;
    dvec3 impulse(0);
    for (int axis = 0; axis < 3; ++axis) impulse[axis] = load->impulse[static_cast<size_t>(axis)].value();
    own.impulse -= impulse;
    own.size += glm::length(impulse);
  }
  rigids_.settle(dt, parameters.gravity * substepOf(parameters));
  rigids_.end(parameters.bodies, parameters);
}

}  // namespace scree::grains
