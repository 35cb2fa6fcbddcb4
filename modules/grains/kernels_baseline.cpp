// The kernels for the instructions that every machine has.
#include "modules/grains/pair_pass.h"

#include "engine/core/hash.h"

#define SCREE_LANES baseline
#include "modules/grains/lanes8.h"
#include "modules/grains/pair_kernel.h"
#include "modules/grains/scan_kernel.h"

namespace scree::grains {

vec3 anyDirection(Entity a, Entity b) {
  const bool swapped = b < a;
  const uint64_t h = hashCombine(swapped ? b.index : a.index, swapped ? a.index : b.index);
  const auto component = [&](int shift) {
    return static_cast<float>(static_cast<int32_t>((h >> shift) & 0xffff) - 0x8000) + 0.5f;
  };
  const vec3 v(component(0), component(16), component(32));
  return v * ((swapped ? -1.0f : 1.0f) / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
}

const Kernels kBaselineKernels{baseline::applyKept, baseline::relax, baseline::scan};

}  // namespace scree::grains
