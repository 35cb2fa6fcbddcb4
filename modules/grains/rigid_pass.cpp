// The passes over contacts with bodies: grains against bodies, bodies against colliders and each other.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/cohesion.h"
#include "modules/grains/rigid.h"

namespace scree::grains {
namespace {

// Of grains, how far a centre may be lifted in a pass, and of bodies.
double corrected(double overlap, double h) {
  return std::min(kBodyProjection * overlap, kBodyProjectionSpeed * h);
}

// The impulse next to the one so far, next_n along n, and inside the cone of friction: at most `most`
// across it. `u` is the velocity there.
dvec3 nextImpulse(const dvec3& impulse, const dvec3& n, const dvec3& u, double next_n, double give_across,
                  double most) {
  const double un = glm::dot(u, n), old_n = glm::dot(impulse, n);
  const dvec3 wish = impulse - old_n * n - (u - un * n) / give_across;
  const double size = std::sqrt(std::max(glm::dot(wish, wish), 1e-60));
  return next_n * n + std::min(1.0, most / size) * wish;
}

template <class Visit>
void eachGiving(std::span<ColliderSlab> slabs, const Visit& visit) {
  for (ColliderSlab& slab : slabs)
    for (ColliderContact& contact : slab.contact)
      if (contact.gives) visit(slab, contact);
}

}  // namespace

void Rigids::applyKept(std::span<ColliderSlab> slabs, Body* grains, std::span<const Collider> colliders) {
  eachGiving(slabs, [&](ColliderSlab&, ColliderContact& contact) {
    Rigid& body = body_[colliders[contact.collider].rigid];
    Body& grain = grains[contact.grain];
    const bool kept = contact.impulse != vec3(0);
    contact.approach = 0;
    contact.impulse *= contact.trust;
    contact.rolling *= contact.trust;
    contact.trust = kept ? 1.0f : 0.0f;
    grain.velocity += grain.inverse_mass * contact.impulse;
    grain.spin += contact.spin_factor * (contact.rolling / grain.radius - glm::cross(contact.normal, contact.impulse));
    push(body, dvec3(grain.position - contact.normal * grain.radius) - body.base, -dvec3(contact.impulse));
    body.spin -= body.give_angular * dvec3(contact.rolling);
  });
  for (RigidContact& contact : contact_) {
    contact.approach = 0;
    Rigid& a = body_[contact.a];
    Rigid* b = contact.b != kNoSlot && !body_[contact.b].asleep ? &body_[contact.b] : nullptr;
    if (a.asleep && b == nullptr) continue;
    if (!a.asleep) push(a, contact.arm_a, contact.impulse);
    if (b != nullptr) push(*b, contact.arm_b, -contact.impulse);
  }
}

void Rigids::relaxGrain(ColliderContact& contact, Body& grain, Rigid& body, const PosedCollider& posed,
                        const PassSettings& settings, float& deepest) {
  const dvec3 n(contact.normal);
  const double radius = grain.radius, h = settings.h, inverse_mass = grain.inverse_mass;
  const dvec3 arm = dvec3(grain.position - contact.normal * grain.radius) - body.base;
  const double gap = static_cast<double>(glm::dot(contact.normal, grain.position) - contact.offset - grain.radius) -
                     glm::dot(n, body.shift + glm::cross(body.twist, arm));
  const dvec3 surface = velocityAt(body, arm) + dvec3(posed.surface_velocity);
  const dvec3 centre = dvec3(grain.velocity) - surface;
  const dvec3 u = centre - radius * glm::cross(dvec3(grain.spin), n);
  const double un = glm::dot(u, n);
  double asked = contact.approach > 0 ? static_cast<double>(contact.approach) : -std::max(gap, 0.0) / h;
  const dvec3 impulse(contact.impulse);
  const double own_give = giveAlong(body, arm, n), give = inverse_mass + own_give;
  const bool kept = contact.impulse != vec3(0);
  const double old_n = glm::dot(impulse, n);
  double next_n = std::max(0.0, old_n - (un - asked) / give);
  Grip grip;
  bool holds = false;
  if (contact.pull > 0 && !(contact.approach > 0)) {
    const double left = static_cast<double>(kReach) * radius - std::max(gap, 0.0), stops = un / give - old_n;
    holds = left > 0 && (kept || gap <= 0 || stops > 0);
    if (holds) {
      const float before = glm::dot(grain.velocity_before - contact.surface_velocity, contact.normal);
      grip = gripOf(before, static_cast<float>(stops * give), static_cast<float>(1 / give), contact.pull,
                    static_cast<float>(left), settings.h);
      if (!(next_n > 0)) next_n = -static_cast<double>(grip.impulse);
    }
  }
  if (!(next_n > 0) && !kept && !(gap < 0) && !holds) return;
  const double leap = 2 * radius / h, speed_square = glm::dot(centre, centre), round = static_cast<double>(contact.flat) / h;
  if (!kept && gap > 0 && next_n > 0 && speed_square >= round * round && speed_square < leap * leap) {
    // As for colliders that do not give: does it miss the true surface?
    const double planar = gap + un * h;
    const double left =
        static_cast<double>(nearestSurface(posed, grain.position + vec3(centre * h)).distance) - radius;
    if (left > -0.02 * radius && left - planar > -0.5 * planar) return;
  }
  if (settings.first_pass && !kept && contact.restitution > 0 && un < -static_cast<double>(settings.bounce_speed)) {
    contact.approach = static_cast<float>(-static_cast<double>(contact.restitution) * un);
    asked = static_cast<double>(contact.approach);
    next_n = std::max(0.0, old_n - (un - asked) / give);
    grip = {};
  }
  const double pressed = next_n + static_cast<double>(grip.limit);
  const vec3 next(nextImpulse(impulse, n, u, next_n, 3.5 * inverse_mass + giveAcross(body, arm, n),
                              static_cast<double>(contact.friction) * pressed));
  const vec3 change = next - contact.impulse;
  grain.velocity += grain.inverse_mass * change;
  grain.spin -= contact.spin_factor * glm::cross(contact.normal, change);
  push(body, arm, -dvec3(change));
  contact.impulse = next;
  if (contact.rolling_friction > 0) {
    const double inverse_inertia = static_cast<double>(contact.spin_factor) / radius;
    const dmat3& g = body.give_angular;
    const double turn = inverse_inertia + g[0][0] + g[1][1] + g[2][2];  // not less than the true one
    const dvec3 wish = dvec3(contact.rolling) - (dvec3(grain.spin) - body.spin) / turn;
    const double size = std::sqrt(std::max(glm::dot(wish, wish), 1e-60));
    const double limit = static_cast<double>(contact.rolling_friction) * radius * pressed;
    const vec3 rolling(std::min(1.0, limit / size) * wish);
    grain.spin += static_cast<float>(inverse_inertia) * (rolling - contact.rolling);
    body.spin -= body.give_angular * dvec3(rolling - contact.rolling);
    contact.rolling = rolling;
  }
  deepest = std::max(deepest, static_cast<float>(-gap));
  const double overlap = -gap - static_cast<double>(kSlop) * radius;
  if (!(overlap > 0)) return;
  // Shared as an impulse would be.
  const double part = kBodyProjection * overlap / give;
  grain.position += contact.normal * static_cast<float>(part * inverse_mass);
  const double back = std::min(part, kBodyProjectionSpeed * h / std::max(own_give, 1e-300));
  body.shift -= body.give_linear * (n * back);
  body.twist -= body.give_angular * (glm::cross(arm, n) * back);
}

// Contacts of bodies with colliders and each other, and the stops of sliders.
void Rigids::relaxContacts(const PassSettings& settings) {
  const double h = static_cast<double>(settings.h);
  for (RigidContact& contact : contact_) {
    Rigid& a = body_[contact.a];
    Rigid* b = contact.b != kNoSlot && !body_[contact.b].asleep ? &body_[contact.b] : nullptr;
    if ((a.asleep && b == nullptr) || (settings.standing && contact.b != kNoSlot)) continue;
    const dvec3 n = contact.normal;
    dvec3 u = -contact.surface, moved(0);
    if (!a.asleep) {
      u += velocityAt(a, contact.arm_a);
      moved += a.shift + glm::cross(a.twist, contact.arm_a);
    }
    if (b != nullptr) {
      u -= velocityAt(*b, contact.arm_b);
      moved -= b->shift + glm::cross(b->twist, contact.arm_b);
    }
    const double gap = contact.gap + glm::dot(n, moved), un = glm::dot(u, n);
    if (settings.first_pass && contact.impulse == dvec3(0) && contact.restitution > 0 &&
        un < -static_cast<double>(settings.bounce_speed) && gap + un * h < 0)
      contact.approach = -contact.restitution * un;
    const double asked = contact.approach > 0 ? contact.approach : -std::max(gap, 0.0) / h;
    const double next_n = std::max(0.0, glm::dot(contact.impulse, n) - (un - asked) / contact.give_normal);
    const dvec3 next = nextImpulse(contact.impulse, n, u, next_n, contact.give_across, contact.friction * next_n);
    const dvec3 change = next - contact.impulse;
    contact.impulse = next;
    if (!a.asleep) push(a, contact.arm_a, change);
    if (b != nullptr) push(*b, contact.arm_b, -change);
    const double overlap = -gap - static_cast<double>(kSlop) * a.reach;
    if (!(overlap > 0)) continue;
    const double part = corrected(overlap, h) / contact.give_normal;
    if (!a.asleep) {
      a.shift += a.give_linear * (n * part);
      a.twist += a.give_angular * (glm::cross(contact.arm_a, n) * part);
    }
    if (b != nullptr) {
      b->shift -= b->give_linear * (n * part);
      b->twist -= b->give_angular * (glm::cross(contact.arm_b, n) * part);
    }
  }
  for (Rigid& body : body_) {
    if (body.asleep || body.row.freedom != Freedom::Slider) continue;
    const dvec3 line(body.row.line);
    const double give = glm::dot(line, body.give_linear * line);
    const double travel = glm::dot(line, body.position - body.row.pivot), speed = glm::dot(line, body.velocity);
    const double low = (static_cast<double>(body.row.low) - travel) / h, high = (static_cast<double>(body.row.high) - travel) / h;
    // The stop's impulse so far, so that it can be taken back.
    const double free = speed - give * body.limit;
    const double next = (std::clamp(free, std::min(low, high), std::max(low, high)) - free) / give;
    body.velocity += body.give_linear * (line * (next - body.limit));
    body.limit = next;
  }
}

void Rigids::relax(std::span<ColliderSlab> slabs, Body* grains, std::span<const Collider> colliders,
                   std::span<const PosedCollider> posed, const PassSettings& settings) {
  PassSettings round = settings;
  for (int k = 0; k < kRounds; ++k) {
    eachGiving(slabs, [&](ColliderSlab& slab, ColliderContact& contact) {
      relaxGrain(contact, grains[contact.grain], body_[colliders[contact.collider].rigid], posed[contact.collider],
                 round, slab.deepest);
    });
    relaxContacts(round);
    round.first_pass = false;
  }
}

}  // namespace scree::grains
