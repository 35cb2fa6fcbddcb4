// Contacts of grains with distance fields: the points that touch, told apart from substep to substep.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/contacts.h"

namespace scree::grains {
namespace {

// A contact that nothing touches.
void rest(ColliderContact& contact) {
  constexpr float kFarBelow = -1e30f;
  contact.impulse = contact.rolling = vec3(0);
  contact.offset = kFarBelow;
  contact.gives = false;  // a body that nothing touches
  contact.flat = 0;
}

// Adds the faces that the grain comes to within the substep and did not touch before: of a ramp the
// foot is nearest until the grain is on it.
uint32_t addFacesAhead(const DistanceField& field, vec3 p, vec3 way, float radius,
                       std::span<SurfacePoint> touch, uint32_t count) {
  constexpr float kSameDirection = 0.9998f;
  SurfacePoint ahead[DistanceField::kMostTouches];
  const uint32_t found =
      field.touches(p + way, 1.02f * radius, std::span(ahead, touch.size()));
  for (uint32_t k = 0; k < found && count < touch.size(); ++k) {
    SurfacePoint face = ahead[k];
    face.distance -= glm::dot(face.normal, way);  // from where the grain is now
    // Only planes, and only those that it is before: around an edge the one there now is right.
    bool fresh = face.flat > 0 && face.distance > 0.999f * radius;
    for (uint32_t t = 0; t < count; ++t)
      fresh = fresh && glm::dot(face.normal, touch[t].normal) < kSameDirection;
    face.flat = 0;
    if (fresh) touch[count++] = face;
  }
  return count;
}

}  // namespace

size_t placeField(ColliderSlab& slab, size_t first, const Body* body, const PosedCollider& collider,
                  float h) {
  const ColliderContact& one = slab.contact[first];
  size_t parts = 1;
  while (first + parts < slab.contact.size() && slab.contact[first + parts].grain == one.grain &&
         slab.contact[first + parts].collider == one.collider)
    ++parts;
  const std::span<ColliderContact> contact(&slab.contact[first], parts);
  const Body& grain = body[one.grain];
  const vec3 p = grain.position, local = (p - collider.position) * collider.world_from_local;
  const vec3 u = grain.velocity - velocityAt(collider, p);
  // What may be touched within the substep; of more than two radii the guard takes care.
  const float reach =
      grain.radius + std::min(0.02f * grain.radius + h * std::sqrt(glm::dot(u, u)), 2 * grain.radius);
  SurfacePoint touch[DistanceField::kMostTouches];
  uint32_t count = std::min(collider.field->touches(local, reach, std::span(touch, parts)),
                            static_cast<uint32_t>(parts));
  slab.guards.push_back({static_cast<uint32_t>(first), local, count > 0 ? touch[0].distance : reach});
  if (parts > 1 && h * h * glm::dot(u, u) > 0.01f * grain.radius * grain.radius)
    count = addFacesAhead(*collider.field, local, h * (u * collider.world_from_local), grain.radius,
                          std::span(touch, parts), count);
  slab.driven = slab.driven || drives(collider, grain, h);
  for (uint32_t t = 0; t < count; ++t) touch[t].normal = collider.world_from_local * touch[t].normal;
  if (parts == 1) {
    if (count == 0) {
      rest(contact[0]);
      return 1;
    }
    setSurface(contact[0], touch[0], grain, collider);
    return 1;
  }
  // Each contact goes on with the point in its direction, so that it keeps its impulse.
  constexpr float kSameSurface = 0.9f;
  uint32_t taken = 0, used = 0;
  const auto give = [&](size_t c, uint32_t t) {
    setSurface(contact[c], touch[t], grain, collider);
    taken |= 1u << t;
    used |= 1u << c;
  };
  for (size_t c = 0; c < parts; ++c) {
    if (contact[c].impulse == vec3(0)) continue;
    uint32_t best = DistanceField::kMostTouches;
    float most = kSameSurface;
    for (uint32_t t = 0; t < count; ++t) {
      const float along = glm::dot(contact[c].normal, touch[t].normal);
      if ((taken >> t & 1) != 0 || !(along > most)) continue;
      most = along;
      best = t;
    }
    if (best < DistanceField::kMostTouches) give(c, best);
  }
  for (uint32_t t = 0; t < count; ++t) {
    if ((taken >> t & 1) != 0) continue;
    size_t c = 0;
    while ((used >> c & 1) != 0) ++c;
    contact[c].impulse = contact[c].rolling = vec3(0);
    give(c, t);
  }
  for (size_t c = 0; c < parts; ++c)
    if ((used >> c & 1) == 0) rest(contact[c]);
  return parts;
}

}  // namespace scree::grains
