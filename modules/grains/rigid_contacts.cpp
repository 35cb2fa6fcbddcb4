// Where bodies touch colliders and each other: points and edges of one against the surface of the other.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "modules/grains/rigid.h"

namespace scree::grains {
namespace {

// Contacts that a pair has at most: those spread widest.
constexpr size_t kMostContacts = 12;
// Features of the other side have this bit.
constexpr uint32_t kMirrored = 0x80000000u;

auto identity(const RigidContact& c) { return std::tuple(c.key_a, c.key_b, c.feature); }

// Share of the way from a to b where the distance is least, as if it had one valley.
float lowest(const PosedCollider& other, vec3 a, vec3 b, float most) {
  constexpr float kGolden = 0.618034f;
  float low = 0, high = 1, x = 1 - kGolden, y = kGolden;
  const auto at = [&](float t) { return distanceTo(other, a + (b - a) * t, most); };
  float dx = at(x), dy = at(y);
  for (int step = 0; step < 16; ++step) {
    if (dx <= dy) {
      high = y;
      y = x;
      dy = dx;
      x = low + (1 - kGolden) * (high - low);
      dx = at(x);
    } else {
      low = x;
      x = y;
      dx = dy;
      y = low + kGolden * (high - low);
      dy = at(y);
    }
  }
  return dx <= dy ? x : y;
}

// From t inside, where the distance is at most `level`, towards `outside`: how far it stays so.
float edgeOf(const PosedCollider& other, vec3 a, vec3 b, float t, float outside, float level) {
  for (int step = 0; step < 12; ++step) {
    const float middle = 0.5f * (t + outside);
    (distanceTo(other, a + (b - a) * middle, 2 * std::abs(level) + 1) <= level ? t : outside) = middle;
  }
  return t;
}

}  // namespace

// Points and edges of `form` that are nearer to the other's surface than margin.
void Rigids::features(const RigidForm& form, const PosedCollider& own, const PosedCollider& other, float margin,
                      uint32_t base) {
  const float reach = margin + form.radius;
  const auto placed = [&](uint32_t k) { return own.position + own.world_from_local * form.point[k]; };
  const auto add = [&](uint32_t feature, vec3 p) {
    const SurfacePoint near = nearestSurface(other, p);
    if (near.distance < reach)
      candidate_.push_back({base | feature, p - form.radius * near.normal, near.normal, near.distance - form.radius, false});
  };
  distance_.clear();
  for (uint32_t k = 0; k < form.point.size(); ++k) {
    const vec3 p = placed(k);
    const float distance = distanceTo(other, p, 1e9f);
    distance_.push_back(distance);
    if (distance < reach) add(k, p);
  }
  if (other.shape == Shape::Plane) return;
  const uint32_t points = static_cast<uint32_t>(form.point.size());
  for (uint32_t e = 0; e < form.edge.size(); ++e) {
    const float d0 = distance_[form.edge[e].a], d1 = distance_[form.edge[e].b];
    const vec3 a = placed(form.edge[e].a), b = placed(form.edge[e].b);
    const float length = glm::length(b - a);
    if (!(0.5f * (d0 + d1 - length) < reach)) continue;
    const float t = lowest(other, a, b, reach + length);
    const float d = distanceTo(other, a + (b - a) * t, reach + length);
    if (!(d < reach)) continue;
    const float level = d + 1e-4f * length;
    // An end that is as near as the middle is a point that is there already.
    const float from = d0 > level ? edgeOf(other, a, b, t, 0, level) : 0.0f;
    const float to = d1 > level ? edgeOf(other, a, b, t, 1, level) : 1.0f;
    constexpr float kEnd = 0.02f;  // nearer to a point, that will do
    if (from > kEnd && from < 1 - kEnd) add(points + 2 * e, a + (b - a) * from);
    if (to > kEnd && to < 1 - kEnd && to - from > kEnd) add(points + 2 * e + 1, a + (b - a) * to);
  }
}

// Adds the contacts of body a with collider k, which may be body b.
void Rigids::touch(uint32_t a, uint32_t b, uint32_t k, std::span<const Collider> colliders,
                   std::span<const PosedCollider> posed, float margin) {
  const Rigid& body = body_[a];
  const Collider &own = colliders[body.collider], &other = colliders[k];
  const PosedCollider &own_pose = posed[body.collider], &other_pose = posed[k];
  candidate_.clear();
  const std::shared_ptr<const RigidForm> other_form = other.shape != Shape::Plane ? outline(other) : nullptr;
  const bool round = body.form->radius > 0, round_other = other_form != nullptr && other_form->radius > 0;
  // The axis of what is round tells all; else each has points that may touch the other's faces.
  if (round || !round_other) features(*body.form, own_pose, other_pose, margin, 0);
  const size_t direct = candidate_.size();
  if (!round && other_form != nullptr) {
    features(*other_form, other_pose, own_pose, margin, kMirrored);
    for (size_t c = direct; c < candidate_.size(); ++c) candidate_[c].normal = -candidate_[c].normal;
  }
  if (candidate_.empty()) return;

  const auto begin = std::lower_bound(last_.begin(), last_.end(), std::tuple(own.key, other.key, 0u),
                                      [](const RigidContact& c, const auto& wanted) { return identity(c) < wanted; });
  const auto formerly = [&](uint32_t feature) -> const RigidContact* {
    for (auto at = begin; at != last_.end() && at->key_a == own.key && at->key_b == other.key; ++at)
      if (at->feature == feature) return &*at;
    return nullptr;
  };
  for (Candidate& c : candidate_) {
    const RigidContact* last = formerly(c.feature);
    c.carried = last != nullptr && last->impulse != dvec3(0);
    c.normal_before = c.carried ? vec3(last->normal) : vec3(0);
  }
  if (other_form != nullptr && body.form->convex && other_form->convex && !round && !round_other) {
    faceEachOther(*body.form, own_pose, *other_form, other_pose);
  } else {
    for (Candidate& c : candidate_) {
      // What is inside goes back out on the side where it came in.
      const bool mirrored = (c.feature & kMirrored) != 0;
      const PosedCollider& surface = mirrored ? own_pose : other_pose;
      if (!(c.distance < 0) || !c.carried || surface.shape == Shape::Field) continue;
      const vec3 way = c.normal_before;
      if (glm::dot(way, c.normal) > 0.7f) continue;
      const vec3 out = mirrored ? -way : way;
      c.distance = glm::dot(out, c.point) - supportOffset(surface, out);
      c.normal = way;
    }
  }
  // The same place told twice.
  const float close = 0.01f * std::min(body.form->reach, other_form != nullptr && other_form->reach > 0
                                                             ? other_form->reach : body.form->reach);
  for (size_t c = direct; c < candidate_.size();) {
    const bool twice = std::any_of(candidate_.begin(), candidate_.begin() + static_cast<std::ptrdiff_t>(direct),
                                   [&](const Candidate& one) {
                                     const vec3 d = one.point - candidate_[c].point;
                                     return glm::dot(d, d) < close * close &&
                                            glm::dot(one.normal, candidate_[c].normal) > 0.9f;
                                   });
    if (twice) candidate_.erase(candidate_.begin() + static_cast<std::ptrdiff_t>(c));
    else ++c;
  }
  if (candidate_.size() > kMostContacts) thinOut(body.form->reach);

  const double friction = std::sqrt(static_cast<double>(own.friction) * static_cast<double>(other.friction));
  const double restitution = static_cast<double>(std::max(own.restitution, other.restitution));
  for (const Candidate& c : candidate_) {
    RigidContact contact;
    contact.key_a = own.key;
    contact.key_b = other.key;
    contact.feature = c.feature;
    contact.a = a;
    contact.b = b;
    contact.collider = k;
    if (const RigidContact* last = formerly(c.feature)) {
      contact.impulse = last->trusted ? last->impulse : dvec3(0);
      contact.trusted = last->impulse != dvec3(0);
    }
    contact.normal = glm::normalize(dvec3(c.normal));
    const dvec3 point(c.point);
    contact.arm_a = point - body.base;
    contact.gap = static_cast<double>(c.distance);
    contact.friction = friction;
    contact.restitution = restitution;
    contact.give_normal = body.asleep ? 0 : giveAlong(body, contact.arm_a, contact.normal);
    contact.give_across = body.asleep ? 0 : giveAcross(body, contact.arm_a, contact.normal);
    contact.surface = dvec3(other_pose.surface_velocity - own_pose.surface_velocity);
    if (b == kNoSlot) {
      contact.surface += dvec3(velocityAt(other_pose, c.point));
    } else if (!body_[b].asleep) {
      contact.arm_b = point - body_[b].base;
      contact.give_normal += giveAlong(body_[b], contact.arm_b, contact.normal);
      contact.give_across += giveAcross(body_[b], contact.arm_b, contact.normal);
    }
    if (contact.give_normal > 0) contact_.push_back(contact);
  }
}

// Two convex bodies have one normal: of those at hand, the one along which they are farthest apart. A corner
// that lies on another's edge would else be pushed out sideways.
void Rigids::faceEachOther(const RigidForm& form, const PosedCollider& own, const RigidForm& other_form,
                           const PosedCollider& other) {
  const auto most = [](const RigidForm& of, const PosedCollider& pose, vec3 n) {
    const vec3 local = n * pose.world_from_local;
    float far = -3e38f;
    for (const vec3 p : of.point) far = std::max(far, glm::dot(local, p));
    return far + glm::dot(n, pose.position);
  };
  vec3 best(0);
  float farthest = -3e38f;
  const auto weigh = [&](vec3 n, float favour) {
    if (n == vec3(0)) return;
    const float gap = -most(form, own, -n) - most(other_form, other, n) + favour;
    if (!(gap > farthest)) return;
    farthest = gap;
    best = n;
  };
  // The one so far stays unless another is clearly better.
  const float favour = 1e-3f * std::min(form.reach, other_form.reach);
  vec3 last(0);
  for (const Candidate& c : candidate_) {
    weigh(c.normal_before, favour);
    if (c.normal != last) weigh(c.normal, 0);
    last = c.normal;
  }
  const float own_low = -most(form, own, -best), other_high = most(other_form, other, best);
  for (Candidate& c : candidate_) {
    const float along = glm::dot(best, c.point);
    c.distance = (c.feature & kMirrored) != 0 ? own_low - along : along - other_high;
    c.normal = best;
  }
}

// Keeps the deepest candidate and those that lie farthest from those kept.
void Rigids::thinOut(float reach) {
  std::vector<Candidate>& all = candidate_;
  size_t kept = 0;
  float deepest = 3e38f;
  for (const Candidate& c : all) deepest = std::min(deepest, c.distance);
  while (kept < kMostContacts) {
    size_t best = kept;
    float most = -1;
    for (size_t c = kept; c < all.size(); ++c) {
      float value = kept == 0 ? deepest - all[c].distance + 1 : 3e38f;
      for (size_t k = 0; k < kept; ++k) {
        const vec3 d = all[c].point - all[k].point;
        value = std::min(value, glm::dot(d, d));
      }
      if (all[c].carried) value *= 1.5f;
      if (all[c].distance > deepest + 0.01f * reach) value *= 0.1f;
      if (value > most) {
        most = value;
        best = c;
      }
    }
    std::swap(all[kept++], all[best]);
  }
  all.resize(kept);
  std::sort(all.begin(), all.end(), [](const Candidate& x, const Candidate& y) { return x.feature < y.feature; });
}

void Rigids::findContacts(std::span<const Collider> colliders, std::span<const PosedCollider> posed,
                          std::span<const ColliderLists::Swept> swept, float h, float dt) {
  last_.swap(contact_);
  contact_.clear();
  const auto motion = [&](const Rigid& body) {
    return body.asleep ? 0.0
                       : (glm::length(body.velocity) + glm::length(body.spin) * body.reach) * static_cast<double>(h);
  };
  for (uint32_t a = 0; a < body_.size(); ++a) {
    const Rigid& body = body_[a];
    const double way = motion(body);
    const vec3 centre = posed[body.collider].position;
    const float own_reach = body.form->reach;
    if (body.asleep) {
      // Only others that are awake have anything new to it.
      auto at = std::lower_bound(last_.begin(), last_.end(), std::tuple(body.key, 0u, 0u),
                                 [](const RigidContact& c, const auto& wanted) { return identity(c) < wanted; });
      for (; at != last_.end() && at->key_a == body.key; ++at)
        if (at->b == kNoSlot || body_[at->b].asleep) contact_.push_back(*at);
    }
    const size_t first = contact_.size();
    for (uint32_t k = 0; k < colliders.size(); ++k) {
      const uint32_t b = colliders[k].rigid;
      if (k == body.collider || (b != kNoSlot && b < a)) continue;
      if (body.asleep && (b == kNoSlot || body_[b].asleep)) continue;
      // No farther than a grain may be from a body that goes on from here.
      float margin = static_cast<float>(way) + 0.02f * own_reach;
      if (b != kNoSlot) margin += static_cast<float>(motion(body_[b]));
      else if (posed[k].moves()) margin += swept[k].motion * (h / dt);
      const float around = own_reach + margin;
      const Bounds& bounds = swept[k].bounds;
      if (centre.x + around < bounds.min.x || bounds.max.x < centre.x - around || centre.y + around < bounds.min.y ||
          bounds.max.y < centre.y - around || centre.z + around < bounds.min.z || bounds.max.z < centre.z - around)
        continue;
      if (!(distanceTo(posed[k], centre, 2 * around) < around)) continue;
      touch(a, b, k, colliders, posed, margin);
    }
    if (body.asleep && first != contact_.size())
      std::sort(contact_.begin(), contact_.end(),
                [](const RigidContact& x, const RigidContact& y) { return identity(x) < identity(y); });
  }
}

}  // namespace scree::grains
