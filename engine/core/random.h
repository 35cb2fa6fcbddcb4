// Counter-based random numbers: a pure function of (seed, entity, tick, draw), so that no result
// depends on the order or the thread in which numbers are drawn.
#pragma once

#include "engine/core/hash.h"

namespace scree {

// 64 uniform random bits.
constexpr uint64_t randomBits(uint64_t seed, uint64_t entity, uint64_t tick, uint64_t draw) {
  return mix64(hashCombine(hashCombine(hashCombine(seed, entity), tick), draw));
}

// Uniform in [0, 1), 24 bits of resolution.
constexpr float randomUnit(uint64_t seed, uint64_t entity, uint64_t tick, uint64_t draw) {
  return static_cast<float>(randomBits(seed, entity, tick, draw) >> 40) * 0x1p-24f;
}

}  // namespace scree
