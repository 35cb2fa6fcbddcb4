// The loops over lanes, as compiled for one instruction set each. All sets give the same bits.
#pragma once

#include <cstdint>
#include <span>

#include "engine/core/math.h"
#include "engine/ecs/entity.h"

namespace scree::grains {

struct Body;
struct ColliderSlab;
struct PairSlab;
struct PosedCollider;
struct PassSettings;

// What a search reads of all grains, by slot, with kMostLanes idle entries behind the last.
struct Reaches {
  const float *x, *y, *z, *radius, *reach;  // m
};
inline constexpr uint32_t kMostLanes = 8;
struct SlotRange {
  uint32_t begin, end;
};
// A grain found: its slot, and this bit if the two nearly touch.
inline constexpr uint32_t kNearBit = 0x80000000u;
// Distance of centres in sums of radii, below which they do.
inline constexpr float kNearlyTouching = 1.005f;

// Grains that the loops over all of them take at a time.
inline constexpr uint32_t kRow = 16;
struct Prediction {
  vec3 gravity_step{0};  // velocity that gravity adds in the substep, m/s
  float h = 0;           // substep, s
  vec3 drift{0};         // that margins are measured against, m/s
  vec3 drifted{0};       // m, since the search
};
struct Motion {
  float h = 0;           // substep, s
  float keep = 1;        // share of the velocity that damping leaves
  float fast = 0;        // m/s
  float most_speed = 0;  // m/s of the surface: a grain that spins faster stops spinning
};

struct Kernels {
  // Velocities take up the impulses kept from the last substep.
  void (*applyKept)(PairSlab& slab, Body* body, const PassSettings& settings);
  // One pass: impulses that stop approach and sliding, then a shift that undoes overlap.
  void (*relax)(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings);
  // The same of contacts with colliders.
  void (*relaxWalls)(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                     const PassSettings& settings);
  // Writes the grains of the ranges within reach of `slot`, in order, and returns how many they
  // are; may write kMostLanes more than that.
  uint32_t (*scan)(const Reaches& grains, uint32_t slot, const SlotRange* range,
                   uint32_t range_count, uint32_t* hits);
  // Adds gravity to kRow bodies; true if one of them may leave its margin around where it is listed.
  bool (*predict)(Body* body, const Reaches& listed, const float* margin, const Prediction& settings);
  // Moves kRow bodies from where they were, which it writes to `from`. `smooth`: squares of the
  // changes of velocity up to which places follow the mean of the velocities before and after. Returns a
  // bit for each that is faster than settings.fast.
  uint32_t (*move)(Body* body, const float* smooth, const Motion& settings, float (&from)[3][kRow]);
};
extern const Kernels kBaselineKernels;
// Null where this processor or compiler lacks the set.
const Kernels* avx2Kernels();
const Kernels* avx512Kernels();

// An instruction set; the results are the same to the bit.
enum class Lanes : uint32_t { Widest, Baseline, Avx2, Avx512 };
// Null where it is lacking.
const Kernels* kernelsOf(Lanes lanes);

}  // namespace scree::grains
