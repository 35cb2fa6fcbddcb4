// The kernels for AVX2. The target is set for these functions alone, after all other headers,
// so that no function shared with other files is compiled for it.
#include "modules/grains/pair_pass.h"

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif
#define SCREE_LANES avx2
#define SCREE_LANES_AVX2
#include "modules/grains/lanes.h"
#include "modules/grains/pair_kernel.h"
#include "modules/grains/wall_kernel.h"
#include "modules/grains/scan_kernel.h"
#include "modules/grains/move_kernel.h"
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

namespace scree::grains {

const Kernels* avx2Kernels() {
  static constexpr Kernels kThese{avx2::applyKept, avx2::relax, avx2::relaxWalls, avx2::scan,
                                 avx2::predict, avx2::move};
  return __builtin_cpu_supports("avx2") ? &kThese : nullptr;
}

}  // namespace scree::grains
#else
namespace scree::grains {

const Kernels* avx2Kernels() { return nullptr; }

}  // namespace scree::grains
#endif
