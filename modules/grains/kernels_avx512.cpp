// The kernels for AVX-512: thirty-two registers, masks, and pair passes of two batches at a time. The
// target is set for these functions alone, after all other headers, as in kernels_avx2.cpp.
#include "modules/grains/pair_pass.h"

#if defined(__x86_64__) && defined(__GNUC__)
#if !defined(__clang__)  // GCC 12 warns of what its own header leaves undefined on purpose
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512dq,avx512vl"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl")
#endif
#define SCREE_LANES avx512
#define SCREE_LANES_AVX512
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

const Kernels* avx512Kernels() {
  static constexpr Kernels kThese{avx512::applyKept, avx512::relax, avx512::relaxWalls, avx512::scan,
                                 avx512::predict, avx512::move};
  const bool there = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                     __builtin_cpu_supports("avx512vl");
  return there ? &kThese : nullptr;
}

}  // namespace scree::grains
#else
namespace scree::grains {

const Kernels* avx512Kernels() { return nullptr; }

}  // namespace scree::grains
#endif
