// The passes over the contacts of grains with colliders.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "modules/grains/cohesion.h"
#include "modules/grains/contacts.h"

namespace scree::grains {

void setSurface(ColliderContact& contact, const SurfacePoint& near, const Body& grain,
                const PosedCollider& collider) {
  const vec3 on_surface = grain.position - near.normal * near.distance;
  contact.normal = near.normal;
  contact.offset = glm::dot(near.normal, on_surface);
  contact.flat = near.flat;
  contact.mass = 1 / grain.inverse_mass;
  contact.spin_factor = spinFactor(grain);
  contact.surface_velocity =
      (collider.moves() ? velocityAt(collider, on_surface) : vec3(0)) + collider.surface_velocity;
  contact.surface_spin = collider.spin;
  contact.gives = collider.gives;
}

bool drives(const PosedCollider& collider, const Body& grain, float h) {
  const vec3 way = h * velocityAt(collider, grain.position);
  return glm::dot(way, way) > grain.radius * grain.radius;
}

void placeSurfaces(ColliderSlab& slab, const Body* body, std::span<const PosedCollider> posed, float h) {
  slab.guards.clear();
  slab.driven = false;
  for (size_t k = 0; k < slab.contact.size(); ++k) {
    ColliderContact& contact = slab.contact[k];
    const PosedCollider& collider = posed[contact.collider];
    if (collider.shape == Shape::Field) {
      k += placeField(slab, k, body, collider, h) - 1;
      continue;
    }
    const vec3 p = body[contact.grain].position;
    SurfacePoint near = nearestSurface(collider, p);
    if (contact.guarded) {
      slab.guards.push_back({static_cast<uint32_t>(k), (p - collider.position) * collider.world_from_local,
                             near.distance});
      slab.driven = slab.driven || drives(collider, body[contact.grain], h);
    }
    // A centre inside the shape goes back out on the side where it came in, not on the nearest one.
    if (near.distance < 0 && contact.normal != vec3(0))
      near = {contact.normal, glm::dot(contact.normal, p) - supportOffset(collider, contact.normal), 0};
    setSurface(contact, near, body[contact.grain], collider);
  }
}

void applyKeptColliders(ColliderSlab& slab, Body* body) {
  slab.bounces.clear();
  slab.deepest = 0;
  for (ColliderContact& contact : slab.contact) {
    if (contact.gives) continue;
    const bool kept = contact.impulse != vec3(0);
    contact.approach = 0;
    contact.impulse *= contact.trust;
    contact.rolling *= contact.trust;
    contact.trust = kept ? 1.0f : 0.0f;
    Body& grain = body[contact.grain];
    grain.velocity += grain.inverse_mass * contact.impulse;
    grain.spin += contact.spin_factor * (contact.rolling / grain.radius -
                                        glm::cross(contact.normal, contact.impulse));
  }
}

namespace {

// A bounce inside the substep, as it would be on a parabola: the speed afterwards, and how far the
// grain must be moved so that it ends where that parabola ends. `approach` is the normal velocity
// with the whole substep's gravity in it.
struct ImpactTime {
  float speed, shift;
};
ImpactTime bounceOff(const ColliderContact& contact, float radius, float gap, float approach,
                     float gravity_step, float h) {
  const float before = approach - gravity_step;  // at the substep's begin; towards the surface
  const float g = gravity_step / h;
  const float root = std::sqrt(std::max(0.0f, before * before - 2 * g * gap));
  const float t = gap > 0 ? std::clamp(2 * gap / std::max(root - before, 1e-30f), 0.0f, h) : 0.0f;
  const float impact = before + g * t;
  const float rest = h - t;
  float restitution = contact.restitution;
  if (contact.pull > 0 && impact < 0) {
    const float left = heldRebound(-restitution * impact, contact.mass, contact.pull, kReach * radius, rest);
    if (!(left > 0)) return {0, 0};
    restitution = -left / impact;
  }
  const float speed = -restitution * impact + g * rest;
  const float shift = -std::max(gap, 0.0f) - restitution * impact * rest + 0.5f * g * rest * rest -
                      h * speed;
  return {speed, shift};
}

}  // namespace

void relaxContact(ColliderSlab& slab, ColliderContact& contact, Body& grain, std::span<const PosedCollider> posed,
                  const PassSettings& settings) {
  const vec3 normal = contact.normal;
  const float gap = glm::dot(normal, grain.position) - contact.offset - grain.radius;
  const vec3 u = grain.velocity - contact.surface_velocity;
  const float un = glm::dot(u, normal), old_n = glm::dot(contact.impulse, normal);
  const float mass = contact.mass;
  const float asked =
      contact.approach > 0 ? contact.approach : -std::max(gap, 0.0f) * settings.inverse_h;
  if (settings.tolerated > 0 && un - asked > -settings.tolerated) return;
  float next_n = std::max(0.0f, old_n - mass * (un - asked));
  const bool kept = contact.impulse != vec3(0);
  Grip grip;
  bool holds = false;
  if (contact.pull > 0 && !(contact.approach > 0)) {
    const float left = kReach * grain.radius - std::max(gap, 0.0f), stops = mass * un - old_n;
    holds = left > 0 && (kept || gap <= 0 || stops > 0);
    if (holds) {
      const float before = glm::dot(grain.velocity_before - contact.surface_velocity, normal);
      grip = gripOf(before, stops / mass, mass, contact.pull, left, settings.h);
      if (!(next_n > 0)) next_n = -grip.impulse;
    }
  }
  if (!(next_n > 0) && !kept && !(gap < 0) && !holds) return;
  const float leap = 2 * grain.radius * settings.inverse_h;
  const float speed_square = glm::dot(u, u), round = contact.flat * settings.inverse_h;
  if (!kept && gap > 0 && next_n > 0 && speed_square >= round * round && speed_square < leap * leap) {
    // Not touched yet, and too slow to get through anything: would it miss the true surface (an
    // edge, the seam between two boxes), though not the plane that stands for it?
    const float planar = gap + un * settings.h;
    const float left = nearestSurface(posed[contact.collider],
                                      grain.position + u * settings.h).distance - grain.radius;
    if (left > -0.02f * grain.radius && left - planar > -0.5f * planar) return;
  }
  if (settings.first_pass && !kept && contact.restitution > 0 && un < -settings.bounce_speed) {
    const ImpactTime impact =
        bounceOff(contact, grain.radius, gap, un,
                  glm::dot(settings.gravity_step, normal) * grain.gravity_scale, settings.h);
    if (impact.speed > 0) {
      contact.approach = impact.speed;
      next_n = std::max(0.0f, old_n - mass * (un - contact.approach));
      grip = {};
      slab.bounces.push_back({contact.grain, kNoSlot, normal * impact.shift});
    }
  }
  const vec3 ut = u - un * normal - grain.radius * glm::cross(grain.spin, normal);
  const vec3 wish = contact.impulse - old_n * normal - (mass * (2.0f / 7)) * ut;
  const float size = std::sqrt(std::max(glm::dot(wish, wish), 1e-37f));
  const vec3 next =
      next_n * normal + std::min(1.0f, contact.friction * (next_n + grip.limit) / size) * wish;
  grain.velocity += grain.inverse_mass * (next - contact.impulse);
  const float spin_factor = contact.spin_factor;
  grain.spin -= spin_factor * glm::cross(normal, next - contact.impulse);
  contact.impulse = next;
  if (contact.rolling_friction > 0) {
    const float inverse_inertia = spin_factor / grain.radius;
    const vec3 wish_r =
        contact.rolling - (grain.spin - contact.surface_spin) / inverse_inertia;
    const float size_r = std::sqrt(std::max(glm::dot(wish_r, wish_r), 1e-37f));
    const float limit_r = contact.rolling_friction * grain.radius * (next_n + grip.limit);
    const vec3 next_r = std::min(1.0f, limit_r / size_r) * wish_r;
    grain.spin += inverse_inertia * (next_r - contact.rolling);
    contact.rolling = next_r;
  }
  const float overlap = -gap - kSlop * grain.radius;
  slab.deepest = std::max(slab.deepest, -gap);
  if (overlap > 0) {
    grain.position += normal * (2 * kProjection * overlap);
  } else if (next_n < 0 && grip.impulse < grip.limit) {
    grain.position += normal * (2 * kProjection * std::min(0.0f, overlap + 2 * kSlop * grain.radius));
  }
}

void relaxColliders(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                    const PassSettings& settings) {
  for (ColliderContact& contact : slab.contact) {
    if (contact.gives || (settings.standing && posed[contact.collider].moves())) continue;
    relaxContact(slab, contact, body[contact.grain], posed, settings);
  }
}

}  // namespace scree::grains
