// The kernels for the instructions that every machine has.
#include "modules/grains/pair_pass.h"

#include "engine/core/hash.h"

#define SCREE_LANES baseline
#include "modules/grains/lanes.h"
#include "modules/grains/pair_kernel.h"
#include "modules/grains/wall_kernel.h"
#include "modules/grains/scan_kernel.h"
#include "modules/grains/move_kernel.h"

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

const Kernels kBaselineKernels{baseline::applyKept, baseline::relax, baseline::relaxWalls, baseline::scan,
                                 baseline::predict, baseline::move};

const Kernels* kernelsOf(Lanes lanes) {
  switch (lanes) {
    case Lanes::Baseline: return &kBaselineKernels;
    case Lanes::Avx2: return avx2Kernels();
    case Lanes::Avx512: return avx512Kernels();
    case Lanes::Widest: break;
  }
  for (const Lanes wide : {Lanes::Avx512, Lanes::Avx2})
    if (const Kernels* kernels = kernelsOf(wide); kernels != nullptr) return kernels;
  return &kBaselineKernels;
}

}  // namespace scree::grains
