// What the kernels of every instruction set share.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "modules/grains/cohesion.h"
#include "modules/grains/contacts.h"
#include "modules/grains/simd4.h"

// Of what hands over so many lanes that a call would take longer than the work.
#define SCREE_INLINE __attribute__((always_inline))

namespace scree::grains {

// The bodies of slabs of fewer batches stay in the near caches: 1500 batches meet some 250 KB of them.
inline constexpr uint32_t kFarBatches = 1500;

inline constexpr size_t kPosition = 0, kVelocity = 4, kSpin = 8, kBefore = 12;  // floats into Body
// The same into ColliderContact, of four floats that are read together.
inline constexpr size_t kWallImpulse = offsetof(ColliderContact, impulse) / 4,  // and trust
    kWallRolling = offsetof(ColliderContact, rolling) / 4,                      // and approach
    kWallMaterial = offsetof(ColliderContact, friction) / 4,  // and rolling friction, restitution, pull
    kWallPlane = offsetof(ColliderContact, normal) / 4,       // and offset
    kWallVelocity = offsetof(ColliderContact, surface_velocity) / 4,  // and mass
    kWallSpin = offsetof(ColliderContact, surface_spin) / 4,          // and spin_factor
    kWallFlat = offsetof(ColliderContact, flat) / 4 - 3;              // the last
static_assert(kWallRolling == kWallImpulse + 4 && kWallMaterial == kWallRolling + 4 && kWallPlane == kWallMaterial + 4 &&
              kWallVelocity == kWallPlane + 4 && kWallSpin == kWallVelocity + 4 && kWallFlat == kWallSpin + 1);
static_assert(offsetof(Body, velocity) == 4 * kVelocity && offsetof(Body, spin) == 4 * kSpin &&
              offsetof(Body, velocity_before) == 4 * kBefore);

// Where two centres coincide, a direction that depends on the two entities only.
vec3 anyDirection(Entity a, Entity b);

}  // namespace scree::grains
