// A collider as a saved world keeps it: all that decides whether it is still the same one.
#pragma once

#include "engine/core/bytes.h"
#include "modules/grains/collider.h"

namespace scree::grains {

// Calls visit(field) for each field that is saved: what a tick puts out is not.
template <class AnyCollider, class Visit>
void eachSavedField(AnyCollider& collider, const Visit& visit) {
  // A new field does not compile until it is named here, and saved or left out.
  auto& [key, shape, position0, position1, rotation0, rotation1, half_extent, a, b, radius, field,
         field_identity, friction, rolling_friction, restitution, cohesion, surface_velocity, slack, rigid,
         sensed, load, load_contacts] = collider;
  visit(key);
  visit(shape);
  visit(position0);
  visit(position1);
  visit(rotation0);
  visit(rotation1);
  visit(half_extent);
  visit(a);
  visit(b);
  visit(radius);
  static_cast<void>(field);  // the first tick brings it
  visit(field_identity);
  visit(friction);
  visit(rolling_friction);
  visit(restitution);
  visit(cohesion);
  visit(surface_velocity);
  visit(slack);
  static_cast<void>(rigid);   // the next tick finds it
  static_cast<void>(sensed);  // the lists do not depend on it
  static_cast<void>(load);
  static_cast<void>(load_contacts);
}

inline bool isShape(Shape shape) {
  switch (shape) {
    case Shape::Plane:
    case Shape::Box:
    case Shape::Capsule:
    case Shape::Field:
      return true;
  }
  return false;
}

inline void writeCollider(ByteWriter& out, const Collider& collider) {
  eachSavedField(collider, [&](const auto& field) { out.number(field); });
}

// Any numbers: a collider that is not to the bit like the world's own is not used. False: its shape
// or key is none.
inline bool readCollider(ByteReader& in, Collider& collider) {
  eachSavedField(collider, [&]<class T>(T& field) { field = in.number<T>(); });
  return isShape(collider.shape) && collider.key < kKeyLimit;
}

}  // namespace scree::grains
