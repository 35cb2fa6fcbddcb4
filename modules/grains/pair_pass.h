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

namespace scree::grains {

inline constexpr size_t kPosition = 0, kVelocity = 4, kSpin = 8, kBefore = 12;  // floats into Body
static_assert(offsetof(Body, velocity) == 4 * kVelocity && offsetof(Body, spin) == 4 * kSpin &&
              offsetof(Body, velocity_before) == 4 * kBefore);

// Where two centres coincide, a direction that depends on the two entities only.
vec3 anyDirection(Entity a, Entity b);

}  // namespace scree::grains
