// Rigid bodies over a tick: taken over, moved, handed back.
#include "modules/grains/rigid.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/solver.h"

namespace scree::grains {
namespace {


dquat turnedBy(const dquat& q, const dvec3& angle) {
  // Rotation by 2 atan(|half|); with the series of tan the angle is right to (angle / 2)^7.
  const double square = 0.25 * glm::dot(angle, angle);
  const double stretch = square < 1 ? 1 + square / 3 + square * square * (2.0 / 15) : 1.5;
  const dvec3 half = angle * (0.5 * stretch);
  return glm::normalize(q + dquat(0, half.x, half.y, half.z) * q);
}

bool keyBelow(const Collider& collider, uint32_t key) { return collider.key < key; }

bool asLeft(const RigidRow& a, const RigidRow& b) {
  return a.position == b.position && a.rotation == b.rotation && a.velocity == b.velocity && a.spin == b.spin &&
         a.density == b.density && a.mass == b.mass && a.damping == b.damping && a.freedom == b.freedom &&
         a.pivot == b.pivot && a.line == b.line && a.line_local == b.line_local &&
         a.point_local == b.point_local && a.stiffness == b.stiffness && a.resistance == b.resistance &&
         a.low == b.low && a.high == b.high;
}

}  // namespace

double giveAcross(const Rigid& body, const dvec3& arm, const dvec3& n) {
  const dvec3 across = std::abs(n.y) < 0.7 ? dvec3(0, 1, 0) : dvec3(1, 0, 0);
  const dvec3 s = glm::normalize(glm::cross(n, across)), t = glm::cross(n, s);
  const dvec3 rs = glm::cross(arm, s), rt = glm::cross(arm, t);
  const dvec3 ms = body.give_linear * s, gs = body.give_angular * rs;
  const double ss = glm::dot(s, ms) + glm::dot(rs, gs), st = glm::dot(t, ms) + glm::dot(rt, gs);
  const double tt = glm::dot(t, body.give_linear * t) + glm::dot(rt, body.give_angular * rt);
  const double half = 0.5 * (ss - tt);
  return 0.5 * (ss + tt) + std::sqrt(half * half + st * st);
}

void Rigids::ready(Rigid& body, const RigidRow& row, const Collider& collider) {
  body.row = row;
  body.form = outline(collider);
  const double fill = row.mass > 0 ? static_cast<double>(row.mass) / body.form->volume : static_cast<double>(row.density);
  body.mass = fill * body.form->volume;
  body.centre = body.form->centre;
  body.inertia = fill * body.form->inertia;
  body.rotation = glm::normalize(dquat(row.rotation));
  body.reach = body.form->reach;
  const dmat3 turned = glm::mat3_cast(body.rotation);
  const dvec3 line(row.line);
  switch (row.freedom) {
    case Freedom::Free:
      body.base = row.position + turned * body.centre;
      body.velocity = dvec3(row.velocity);
      body.spin = dvec3(row.spin);
      break;
    case Freedom::Hinge:
      body.base = row.pivot;
      body.velocity = dvec3(0);
      body.spin = line * glm::dot(line, dvec3(row.spin));
      break;
    case Freedom::Slider:
      body.base = row.pivot + line * glm::dot(line, row.position - row.pivot) + turned * body.centre;
      body.velocity = line * glm::dot(line, dvec3(row.velocity));
      body.spin = dvec3(0);
      break;
  }
  place(body);
  body.reach += glm::length(body.base - body.position);
}

// Where the collider is.
void Rigids::place(Rigid& body) const {
  body.turned = glm::mat3_cast(body.rotation);
  body.position = body.base - body.turned * (body.row.freedom == Freedom::Hinge ? dvec3(body.row.point_local)
                                                                                : body.centre);
}

// M and G for a substep of h.
void Rigids::freedom(Rigid& body, double h) const {
  const RigidRow& row = body.row;
  const dvec3 line(row.line);
  body.give_linear = body.give_angular = dmat3(0.0);
  const dmat3 inertia = body.turned * body.inertia * glm::transpose(body.turned);
  switch (row.freedom) {
    case Freedom::Free:
      body.give_linear = dmat3(1 / (body.eased * body.mass));
      body.give_angular = glm::inverse(body.eased * inertia);
      break;
    case Freedom::Hinge: {
      const dvec3 around = glm::cross(line, body.turned * (body.centre - dvec3(row.point_local)));
      const double moment =
          body.eased * (glm::dot(line, inertia * line) + body.mass * glm::dot(around, around));
      body.give_angular = glm::outerProduct(line, line) / (moment + h * static_cast<double>(row.resistance));
      break;
    }
    case Freedom::Slider:
      body.give_linear = glm::outerProduct(line, line) / (body.eased * body.mass + h * static_cast<double>(row.resistance) +
                                              h * h * static_cast<double>(row.stiffness));
      break;
  }
}

void Rigids::begin(std::span<RigidRow> rows, std::span<Collider> colliders) {
  if (rows.empty() && body_.empty()) return;
  for (Collider& collider : colliders) collider.rigid = kNoRigid;
  before_.swap(body_);
  body_.clear();
  awake_ = 0;
  auto last = before_.begin();
  auto at = colliders.begin();
  for (const RigidRow& row : rows) {
    while (at != colliders.end() && at->key < row.key) ++at;
    while (last != before_.end() && last->key < row.key) ++last;
    Collider& collider = *at;  // gatherBodies() has seen to it
    const bool known = last != before_.end() && last->key == row.key;
    Rigid body;
    if (known) body = *last;
    const bool same = known && asLeft(row, last->row);
    const std::shared_ptr<const RigidForm> form = body.form;
    body.key = row.key;
    body.collider = static_cast<uint32_t>(at - colliders.begin());
    collider.rigid = static_cast<uint32_t>(body_.size());
    ready(body, row, collider);
    if (!same || (form != nullptr && form != body.form)) {
      body.asleep = false;
      wakeBody(body);  // counted below
      body.slack = 0;
      body.listed_position = vec3(body.position);
      body.listed_rotation = quat(body.rotation);
    }
    body.slept = body.asleep;
    awake_ += body.asleep ? 0 : 1;
    collider.position0 = collider.position1 = body.listed_position;
    collider.rotation0 = collider.rotation1 = body.listed_rotation;
    collider.slack = body.slack;
    body_.push_back(std::move(body));
  }
  // Bodies have other numbers now; who leaned on one that is gone, or on a collider, wakes.
  std::erase_if(contact_, [&](RigidContact& contact) {
    contact.a = number(contact.key_a);
    const auto other = std::lower_bound(colliders.begin(), colliders.end(), contact.key_b, keyBelow);
    const bool there = other != colliders.end() && other->key == contact.key_b;
    contact.b = there ? other->rigid : kNoSlot;
    if (contact.a != kNoSlot && there) return false;
    for (const uint32_t left : {contact.a, contact.b})
      if (left != kNoSlot) body_[left].rouse = true;
    return true;
  });
  std::erase_if(outline_, [&](const Outline& kept) {
    const auto now = std::lower_bound(colliders.begin(), colliders.end(), kept.key, keyBelow);
    return now == colliders.end() || now->key != kept.key;
  });
  pressed_.assign(body_.size(), {});
}

// The body with a collider's key; kNoSlot: none.
uint32_t Rigids::number(uint32_t key) const {
  const auto at = std::lower_bound(body_.begin(), body_.end(), key,
                                   [](const Rigid& body, uint32_t wanted) { return body.key < wanted; });
  return at != body_.end() && at->key == key ? static_cast<uint32_t>(at - body_.begin()) : kNoSlot;
}

// Kept from tick to tick, and made anew when the collider's shape changes.
std::shared_ptr<const RigidForm> Rigids::outline(const Collider& collider) {
  const auto at = std::lower_bound(outline_.begin(), outline_.end(), collider.key,
                                   [](const Outline& kept, uint32_t key) { return kept.key < key; });
  const bool filled = collider.rigid != kNoRigid;
  if (at != outline_.end() && at->key == collider.key && at->shape == collider.shape &&
      at->half == collider.half_extent && at->a == collider.a && at->b == collider.b &&
      at->radius == collider.radius && at->field == collider.field.get() && at->filled == filled)
    return at->form;
  Outline made{collider.key, collider.shape, collider.half_extent, collider.a, collider.b, collider.radius,
               collider.field.get(), collider.field, nullptr, filled};
  made.form = std::make_shared<const RigidForm>(filled ? formOf(collider) : outlineOf(collider));
  if (at != outline_.end() && at->key == collider.key) {
    *at = made;
    return at->form;
  }
  return outline_.insert(at, made)->form;
}

void Rigids::ease(std::span<const ColliderSlab> slabs, const Bodies& grains) {
  constexpr double kMostRatio = 1000;
  for (Rigid& body : body_) body.eased = 1;
  for (const ColliderSlab& slab : slabs)
    for (const ColliderContact& contact : slab.contact) {
      if (contact.impulse == vec3(0) || !isAwake(grains, contact.grain)) continue;
      const uint32_t k = number(colliderKey(contact.key));  // listed in the last tick, among its colliders
      if (k == kNoSlot || body_[k].asleep) continue;
      Rigid& body = body_[k];
      const Body& grain = grains.body[contact.grain];
      const double mass = static_cast<double>(grain.gravity_scale) / static_cast<double>(grain.inverse_mass);  // true
      if (mass > kMostRatio * body.mass) body.eased = std::max(body.eased, mass / (kMostRatio * body.mass));
    }
  for (const RigidContact& contact : contact_) {
    if (contact.b == kNoSlot || contact.impulse == dvec3(0)) continue;
    Rigid &a = body_[contact.a], &b = body_[contact.b];
    Rigid& light = a.mass < b.mass ? a : b;
    const double ratio = std::max(a.mass, b.mass) / (kMostRatio * light.mass);
    if (!a.asleep && !b.asleep) light.eased = std::max(light.eased, ratio);
  }
}

void Rigids::predict(vec3 gravity_step, float h, std::span<const Force> forces) {
  for (Rigid& body : body_) {
    if (body.asleep) continue;
    ++solved_;
    const RigidRow& row = body.row;
    freedom(body, h);
    body.shift = body.twist = dvec3(0);
    body.limit = 0;
    body.velocity_before = body.velocity;
    const dvec3 arm = body.row.freedom == Freedom::Hinge
                          ? body.turned * (body.centre - dvec3(row.point_local)) : dvec3(0);
    vec3 change = gravity_step;
    if (!forces.empty()) {
      const vec3 v(velocityAt(body, arm));
      change += pushOf(forces, vec3(body.base + arm) + 0.5f * h * v, v, gravity_step, h);
    }
    const double step = static_cast<double>(h), resistance = static_cast<double>(row.resistance);
    if (row.freedom == Freedom::Slider) {
      const double stiffness = static_cast<double>(row.stiffness);
      const dvec3 line(row.line);
      const double travel = glm::dot(line, body.position - row.pivot);
      const double mass = body.eased * body.mass;
      body.velocity *= mass / (mass + step * resistance + step * step * stiffness);
      body.velocity -= body.give_linear * (line * (step * stiffness * travel));
    } else if (row.freedom == Freedom::Hinge) {
      // 1 - h c / (moment + h c).
      body.spin -= body.give_angular * (body.spin * (step * resistance));
    }
    push(body, arm, body.mass * dvec3(change));
  }
}

bool Rigids::relist(std::span<Collider> colliders, float h, float dt) {
  bool any = false;
  for (Rigid& body : body_) {
    if (body.asleep) continue;
    const double speed = glm::length(body.velocity) + glm::length(body.spin) * body.reach;
    const double gone = glm::length(body.position - dvec3(body.listed_position)) +
                        apartBy(body.rotation, dquat(body.listed_rotation)) * body.reach;
    const double fresh = speed * static_cast<double>(dt) + 0.02 * body.reach;
    const double slack = static_cast<double>(body.slack);
    if (gone + speed * static_cast<double>(h) <= slack && slack <= 4 * fresh) continue;
    body.listed_position = vec3(body.position);
    body.listed_rotation = quat(body.rotation);
    body.slack = static_cast<float>(fresh);
    Collider& collider = colliders[body.collider];
    collider.position0 = collider.position1 = body.listed_position;
    collider.rotation0 = collider.rotation1 = body.listed_rotation;
    collider.slack = body.slack;
    any = true;
  }
  return any;
}

void Rigids::pose(std::span<PosedCollider> posed, std::span<const Collider> colliders) const {
  for (const Rigid& body : body_) {
    if (body.asleep) continue;
    posed[body.collider] = this->posed(colliders[body.collider], posed[body.collider]);
  }
}

PosedCollider Rigids::posed(const Collider& collider, PosedCollider was) const {
  const Rigid& body = body_[collider.rigid];
  was.position = vec3(body.position);
  was.world_from_local = mat3(body.turned);
  was.a = was.position + was.world_from_local * collider.a;
  was.b = was.position + was.world_from_local * collider.b;
  was.surface_velocity = was.world_from_local * collider.surface_velocity;
  was.velocity = vec3(velocityAt(body, body.position - body.base));
  was.spin = vec3(body.spin);
  was.gives = true;
  return was;
}

Collider Rigids::overTick(Collider collider, vec3 gravity, float dt) const {
  const Rigid& body = body_[collider.rigid];
  collider.position0 = collider.position1 = vec3(body.position);
  collider.rotation0 = collider.rotation1 = quat(body.rotation);
  collider.slack = motionOf(body, gravity, dt);
  return collider;
}

// As grains move: by the mean velocity where nothing but gravity acts. The angular momentum is the same
// before and after the turn.
void Rigids::move(vec3 gravity_step, float h) {
  const double smooth = 1.01 * static_cast<double>(glm::length(gravity_step)), step = static_cast<double>(h);
  for (Rigid& body : body_) {
    if (body.asleep) continue;
    const RigidRow& row = body.row;
    const double keep = std::clamp(1 - static_cast<double>(row.damping) * step, 0.0, 1.0);
    const double fastest = static_cast<double>(kMostSpeed);
    if (!(glm::dot(body.velocity, body.velocity) <= fastest * fastest)) body.velocity = dvec3(0);
    if (!(glm::dot(body.spin, body.spin) * body.reach * body.reach <= fastest * fastest)) body.spin = dvec3(0);
    const dvec3 change = body.velocity - body.velocity_before;
    body.unbalanced = glm::length(change);
    const double half = row.freedom == Freedom::Free && glm::dot(change, change) <= smooth * smooth ? 0.5 : 0.0;
    body.base += step * (body.velocity - half * change) + body.shift;
    if (row.freedom == Freedom::Free) {
      const auto spinAt = [&](const dquat& rotation, const dvec3& momentum) {
        const dmat3 turned = glm::mat3_cast(rotation);
        const dvec3 local = momentum * turned;
        return turned * (glm::inverse(body.inertia) * local);
      };
      const dvec3 momentum = body.turned * (body.inertia * (body.spin * body.turned));
      // Twice: the middle's spin turns to a middle that is right to the third order.
      dvec3 middle = spinAt(turnedBy(body.rotation, 0.5 * step * body.spin), momentum);
      middle = spinAt(turnedBy(body.rotation, 0.5 * step * middle), momentum);
      body.rotation = turnedBy(body.rotation, step * middle + body.twist);
      body.spin = spinAt(body.rotation, momentum);
    } else if (row.freedom == Freedom::Hinge) {
      body.rotation = turnedBy(body.rotation, step * body.spin + body.twist);
      const dvec3 line(row.line);
      body.rotation = turnedBy(body.rotation, glm::cross(body.rotation * dvec3(row.line_local), line));
    }
    body.velocity *= keep;
    body.spin *= keep;
    place(body);
  }
}

void Rigids::end(std::span<RigidRow> rows, const StepParameters& parameters) {
  for (size_t k = 0; k < body_.size(); ++k) {
    Rigid& body = body_[k];
    RigidRow& row = rows[k];
    row.asleep = body.asleep;
    if (body.asleep && body.slept) continue;
    // As it will come back from a Transform.
    row.position = (parameters.origin + body.position) - parameters.origin;
    row.rotation = quat(body.rotation);
    const dvec3 arm = body.position + body.turned * body.centre - body.base;
    row.velocity = vec3(velocityAt(body, arm));
    row.spin = vec3(body.spin);
    const dvec3 low(parameters.bounds_min), high(parameters.bounds_max), p = body.position;
    row.lost = !(p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y && p.z <= high.z);
    body.row = row;
    if (!body.asleep) continue;
    body.listed_position = vec3(row.position);
    body.listed_rotation = glm::normalize(row.rotation);
    body.slack = 0;
  }
}

void Rigids::scaleKept(double scale) {
  for (RigidContact& contact : contact_) contact.impulse *= scale;
}

uint32_t Rigids::contactCount() const {
  return static_cast<uint32_t>(std::count_if(contact_.begin(), contact_.end(),
                                             [](const RigidContact& c) { return c.impulse != dvec3(0); }));
}

void Rigids::addLoads(std::span<Collider> colliders, bool awake, int times) const {
  for (const RigidContact& contact : contact_) {
    const bool moves = !body_[contact.a].asleep || (contact.b != kNoSlot && !body_[contact.b].asleep);
    if (moves != awake || contact.impulse == dvec3(0)) continue;
    const auto at = std::lower_bound(colliders.begin(), colliders.end(), contact.key_b, keyBelow);
    Collider& own = colliders[body_[contact.a].collider];
    if (own.sensed) own.load += static_cast<double>(times) * contact.impulse;
    if (at != colliders.end() && at->key == contact.key_b && at->sensed)
      at->load -= static_cast<double>(times) * contact.impulse;
  }
}

size_t Rigids::memoryBytes() const {
  size_t bytes = (body_.capacity() + before_.capacity()) * sizeof(Rigid) +
                 (contact_.capacity() + last_.capacity()) * sizeof(RigidContact) +
                 pressed_.capacity() * sizeof(Pressed) + candidate_.capacity() * sizeof(Candidate) +
                 outline_.capacity() * sizeof(Outline);
  for (const Outline& kept : outline_)
    bytes += kept.form->point.capacity() * sizeof(vec3) + kept.form->edge.capacity() * sizeof(RigidForm::Edge);
  return bytes;
}

}  // namespace scree::grains
