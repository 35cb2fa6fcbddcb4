// When rigid bodies fall asleep, and what wakes them.
//
// A body falls asleep when it, the grains that press on it and the bodies that it touches have been still
// for as long as a grain must be (rest.h). Its Transform then stays to the bit, to grains it is a collider
// like others, and its contacts press as they did. It wakes when it is written to; when gravity or the
// tick changes; when a collider that it may touch moves, changes or goes; when a body comes to it; when a
// sleeping grain that leans on it wakes or goes; when what grains press on it changes.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/rest.h"
#include "modules/grains/rigid.h"

namespace scree::grains {

void Rigids::wakeBody(Rigid& body) {
  body.rouse = false;
  body.still = 0;
  body.anchor = body.base;
  body.anchor_rotation = body.rotation;
  if (!body.asleep) return;
  body.asleep = false;
  ++awake_;
}

void Rigids::wakeAll() {
  for (Rigid& body : body_) wakeBody(body);
}

void Rigids::rouse(uint32_t key) {
  if (const uint32_t k = number(key); k != kNoSlot && body_[k].asleep) body_[k].rouse = true;
}

float Rigids::motionOf(const Rigid& body, vec3 gravity, float dt) const {
  const double speed = glm::length(body.velocity) + glm::length(body.spin) * body.reach;
  return static_cast<float>((speed + static_cast<double>(glm::length(gravity) * dt)) * static_cast<double>(dt));
}

bool Rigids::wakeRoused(std::span<const Collider> colliders, std::span<const uint8_t> moved, vec3 gravity, float dt) {
  if (awake_ == body_.size()) return false;
  for (const RigidContact& contact : contact_) {
    const auto at = std::lower_bound(colliders.begin(), colliders.end(), contact.key_b,
                                     [](const Collider& c, uint32_t key) { return c.key < key; });
    if (contact.b == kNoSlot && moved[static_cast<size_t>(at - colliders.begin())] != 0) body_[contact.a].rouse = true;
  }
  const auto rousedBy = [&](const Rigid& body, const Collider& other, float motion) {
    const PosedCollider begin = poseCollider(other, 0, 0, 0);
    const float around = 1.01f * body.form->reach + motion;
    return distanceTo(begin, vec3(body.position), 2 * around) < around;
  };
  for (uint32_t k = 0; k < colliders.size(); ++k) {
    const Collider& other = colliders[k];
    float motion = 0;
    if (other.rigid != kNoSlot) {
      // What lies still beside it may go on doing so.
      const Rigid& from = body_[other.rigid];
      if (from.asleep || glm::length(from.velocity) + glm::length(from.spin) * from.reach < 2.0 * static_cast<double>(kStillSpeed)) continue;
      motion = motionOf(from, gravity, dt);
    } else {
      if (moved[k] == 0) continue;
      motion = motionBound(other);
    }
    for (Rigid& body : body_)
      if (body.asleep && rousedBy(body, other, motion)) body.rouse = true;
  }
  bool any = false;
  for (Rigid& body : body_) {
    if (!body.asleep || !body.rouse) continue;
    wakeBody(body);
    any = true;
  }
  return any;
}

void Rigids::settle(float dt, vec3 gravity_step) {
  // Whom the others lean on.
  for (Rigid& body : body_) {
    const size_t k = static_cast<size_t>(&body - body_.data());
    if (body.asleep) {
      const dvec3 more = pressed_[k].impulse - body.borne;
      const double weight = body.mass * static_cast<double>(glm::length(gravity_step));
      constexpr double kMore = 0.05, kMoreShare = 0.02;  // as a share of the weight; of what it bears
      if (glm::length(more) > kMore * weight + kMoreShare * std::max(body.borne_size, pressed_[k].size))
        body.rouse = true;
      continue;
    }
    const double way = glm::length(body.base - body.anchor) +
                       apartBy(body.rotation, body.anchor_rotation) * body.reach;
    const double speed = glm::length(body.velocity) + glm::length(body.spin) * body.reach;
    if (!(way <= static_cast<double>(kStillWay) * body.reach) || !(speed <= static_cast<double>(kStillSpeed))) {
      wakeBody(body);
    } else {
      body.still += dt;
    }
  }
  // Its contacts go on pressing as they do now: they should bear just its weight.
  constexpr double kBalance = 1e-3;
  constexpr float kLongest = 8 * kFallAsleep;  // or never
  for (size_t k = 0; k < body_.size(); ++k) {
    const Rigid& body = body_[k];
    if (body.asleep) continue;
    if (body.still < kFallAsleep ||
        (body.still < kLongest && body.unbalanced > kBalance * static_cast<double>(glm::length(gravity_step))))
      pressed_[k].stirred = true;
  }
  // Those that touch fall asleep together.
  for (bool more = true; more;) {
    more = false;
    for (const RigidContact& contact : contact_) {
      if (contact.b == kNoSlot || contact.impulse == dvec3(0)) continue;
      for (const auto& [one, other] : {std::pair(contact.a, contact.b), std::pair(contact.b, contact.a)}) {
        if (body_[other].asleep) continue;
        if (body_[one].asleep) {
          body_[one].rouse = body_[one].rouse || body_[other].still == 0;
        } else if (pressed_[other].stirred && !pressed_[one].stirred) {
          pressed_[one].stirred = more = true;
        }
      }
    }
  }
  for (size_t k = 0; k < body_.size(); ++k) {
    Rigid& body = body_[k];
    if (body.asleep || pressed_[k].stirred) continue;
    body.asleep = true;
    body.rouse = false;
    --awake_;
    body.velocity = body.spin = dvec3(0);
    body.borne = pressed_[k].impulse;
    body.borne_size = pressed_[k].size;
  }
}

}  // namespace scree::grains
