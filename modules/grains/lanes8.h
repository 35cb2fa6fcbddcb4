// Eight floats in lock step: AVX2, AVX-512, or two fours.
// Included several times, once for each instruction set: see lanes.h.

namespace scree::simd::SCREE_LANES {

#if defined(SCREE_LANES_AVX2) || defined(SCREE_LANES_AVX512)

#if defined(SCREE_LANES_AVX512)
struct Mask8 {
  __mmask8 v;
};
#endif

struct Float8 {
  __m256 v;
#if defined(SCREE_LANES_AVX512)
  using Mask = Mask8;
#else
  using Mask = Float8;
#endif
  static constexpr uint32_t kLanes = 8;
};

template <>
inline Float8 splat<Float8>(float a) { return {_mm256_set1_ps(a)}; }
template <>
inline Float8 load<Float8>(const float* p, size_t) { return {_mm256_loadu_ps(p)}; }
inline void store(float* p, size_t, Float8 a) { _mm256_storeu_ps(p, a.v); }
inline Float8 operator+(Float8 a, Float8 b) { return {_mm256_add_ps(a.v, b.v)}; }
inline Float8 operator-(Float8 a, Float8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
inline Float8 operator*(Float8 a, Float8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
inline Float8 operator/(Float8 a, Float8 b) { return {_mm256_div_ps(a.v, b.v)}; }
inline Float8 sqrt(Float8 a) { return {_mm256_sqrt_ps(a.v)}; }
// The second operand if either is NaN.
inline Float8 min(Float8 a, Float8 b) { return {_mm256_min_ps(a.v, b.v)}; }
inline Float8 max(Float8 a, Float8 b) { return {_mm256_max_ps(a.v, b.v)}; }
#if defined(SCREE_LANES_AVX512)
inline Mask8 less(Float8 a, Float8 b) { return {_mm256_cmp_ps_mask(a.v, b.v, _CMP_LT_OS)}; }
inline Mask8 lessEqual(Float8 a, Float8 b) { return {_mm256_cmp_ps_mask(a.v, b.v, _CMP_LE_OS)}; }
inline Mask8 notEqual(Float8 a, Float8 b) { return {_mm256_cmp_ps_mask(a.v, b.v, _CMP_NEQ_UQ)}; }
inline Mask8 operator&(Mask8 a, Mask8 b) { return {static_cast<__mmask8>(a.v & b.v)}; }
inline Mask8 operator|(Mask8 a, Mask8 b) { return {static_cast<__mmask8>(a.v | b.v)}; }
inline Mask8 andNot(Mask8 mask, Mask8 b) { return {static_cast<__mmask8>(~mask.v & b.v)}; }
inline Float8 operator&(Mask8 mask, Float8 b) { return {_mm256_maskz_mov_ps(mask.v, b.v)}; }
inline Float8 andNot(Mask8 mask, Float8 b) {
  return {_mm256_maskz_mov_ps(static_cast<__mmask8>(~mask.v), b.v)};
}
inline Float8 select(Mask8 mask, Float8 a, Float8 b) { return {_mm256_mask_mov_ps(b.v, mask.v, a.v)}; }
inline unsigned bits(Mask8 mask) { return mask.v; }
template <>
inline Mask8 maskOf<Float8>(unsigned lanes) { return {static_cast<__mmask8>(lanes)}; }
#else
// Masks: all bits of a lane set or clear.
inline Float8 less(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OS)}; }
inline Float8 lessEqual(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OS)}; }
inline Float8 notEqual(Float8 a, Float8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_NEQ_UQ)}; }
inline Float8 operator&(Float8 a, Float8 b) { return {_mm256_and_ps(a.v, b.v)}; }
inline Float8 operator|(Float8 a, Float8 b) { return {_mm256_or_ps(a.v, b.v)}; }
// b where the mask is clear.
inline Float8 andNot(Float8 mask, Float8 b) { return {_mm256_andnot_ps(mask.v, b.v)}; }
inline Float8 select(Float8 mask, Float8 a, Float8 b) { return {_mm256_blendv_ps(b.v, a.v, mask.v)}; }
// One bit a lane.
inline unsigned bits(Float8 mask) { return static_cast<unsigned>(_mm256_movemask_ps(mask.v)); }
template <>
inline Float8 maskOf<Float8>(unsigned lanes) {
  alignas(32) uint32_t lane[8];
  for (unsigned k = 0; k < 8; ++k) lane[k] = 0u - (lanes >> k & 1u);
  return {_mm256_load_ps(reinterpret_cast<const float*>(lane))};
}
#endif

// Row k of four floats, which lies `offset` behind rowOf(k), and every fourth behind it.
template <class RowOf>
SCREE_INLINE inline void readRows(const RowOf& rowOf, int k, size_t offset, Float8& rows) {
  rows.v = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(rowOf(k) + offset)),
                                _mm_loadu_ps(rowOf(k + 4) + offset), 1);
}
template <class RowOf>
SCREE_INLINE inline void writeRows(const RowOf& rowOf, int k, size_t offset, Float8 rows) {
  _mm_storeu_ps(rowOf(k) + offset, _mm256_castps256_ps128(rows.v));
  _mm_storeu_ps(rowOf(k + 4) + offset, _mm256_extractf128_ps(rows.v, 1));
}
// Such rows, from 0, 1, 2 and 3 on, to columns x, y, z, w of all lanes, and back.
SCREE_INLINE inline void transpose(Float8& a, Float8& b, Float8& c, Float8& d) {
  const __m256 ab_low = _mm256_unpacklo_ps(a.v, b.v), cd_low = _mm256_unpacklo_ps(c.v, d.v);
  const __m256 ab_high = _mm256_unpackhi_ps(a.v, b.v), cd_high = _mm256_unpackhi_ps(c.v, d.v);
  a.v = _mm256_shuffle_ps(ab_low, cd_low, 0x44);
  b.v = _mm256_shuffle_ps(ab_low, cd_low, 0xee);
  c.v = _mm256_shuffle_ps(ab_high, cd_high, 0x44);
  d.v = _mm256_shuffle_ps(ab_high, cd_high, 0xee);
}

#if !defined(SCREE_LANES_AVX512)
// By eight bits: which they are, in order.
inline constexpr auto kLanesOf = [] {
  std::array<std::array<uint8_t, 8>, 256> lanes{};
  for (unsigned set = 0; set < 256; ++set)
    for (unsigned lane = 0, n = 0; lane < 8; ++lane)
      if ((set >> lane & 1) != 0) lanes[set][n++] = static_cast<uint8_t>(lane);
  return lanes;
}();
#endif
// Writes first + k for the lanes k of `within`, in order, with the top bit where the mask is set;
// returns how many they are, and writes eight.
inline uint32_t pack(uint32_t first, Float8::Mask mask, unsigned within, uint32_t* out) {
  const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(first)),
                                         _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
#if defined(SCREE_LANES_AVX512)
  const __m256i named = _mm256_mask_or_epi32(index, mask.v, index, _mm256_set1_epi32(INT32_MIN));
  const __m256i packed = _mm256_maskz_compress_epi32(static_cast<__mmask8>(within), named);
#else
  const __m256i top = _mm256_slli_epi32(_mm256_castps_si256(mask.v), 31);
  const __m256i lanes = _mm256_cvtepu8_epi32(
      _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kLanesOf[within].data())));
  const __m256i packed = _mm256_permutevar8x32_epi32(_mm256_or_si256(index, top), lanes);
#endif
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), packed);
  return static_cast<uint32_t>(std::popcount(within));
}

#else

struct Float8 {
  Float4 a, b;
  using Mask = Float8;
  static constexpr uint32_t kLanes = 8;
};

template <>
inline Float8 splat<Float8>(float a) { return {simd::splat(a), simd::splat(a)}; }
template <>
inline Float8 load<Float8>(const float* p, size_t) { return {simd::load(p), simd::load(p + 4)}; }
inline void store(float* p, size_t, Float8 f) {
  simd::store(p, f.a);
  simd::store(p + 4, f.b);
}
inline Float8 operator+(Float8 f, Float8 g) { return {f.a + g.a, f.b + g.b}; }
inline Float8 operator-(Float8 f, Float8 g) { return {f.a - g.a, f.b - g.b}; }
inline Float8 operator*(Float8 f, Float8 g) { return {f.a * g.a, f.b * g.b}; }
inline Float8 operator/(Float8 f, Float8 g) { return {f.a / g.a, f.b / g.b}; }
inline Float8 sqrt(Float8 f) { return {simd::sqrt(f.a), simd::sqrt(f.b)}; }
inline Float8 min(Float8 f, Float8 g) { return {simd::min(f.a, g.a), simd::min(f.b, g.b)}; }
inline Float8 max(Float8 f, Float8 g) { return {simd::max(f.a, g.a), simd::max(f.b, g.b)}; }
inline Float8 less(Float8 f, Float8 g) { return {simd::less(f.a, g.a), simd::less(f.b, g.b)}; }
inline Float8 lessEqual(Float8 f, Float8 g) {
  return {simd::lessEqual(f.a, g.a), simd::lessEqual(f.b, g.b)};
}
inline Float8 notEqual(Float8 f, Float8 g) {
  return {simd::notEqual(f.a, g.a), simd::notEqual(f.b, g.b)};
}
inline Float8 operator&(Float8 f, Float8 g) { return {f.a & g.a, f.b & g.b}; }
inline Float8 operator|(Float8 f, Float8 g) { return {f.a | g.a, f.b | g.b}; }
inline Float8 andNot(Float8 mask, Float8 g) {
  return {simd::andNot(mask.a, g.a), simd::andNot(mask.b, g.b)};
}
inline Float8 select(Float8 mask, Float8 f, Float8 g) {
  return {simd::select(mask.a, f.a, g.a), simd::select(mask.b, f.b, g.b)};
}
inline unsigned bits(Float8 mask) {
  return static_cast<unsigned>(simd::bits(mask.a) | simd::bits(mask.b) << 4);
}

template <class RowOf>
SCREE_INLINE inline void readRows(const RowOf& rowOf, int k, size_t offset, Float8& rows) {
  rows = {simd::load(rowOf(k) + offset), simd::load(rowOf(k + 4) + offset)};
}
template <class RowOf>
SCREE_INLINE inline void writeRows(const RowOf& rowOf, int k, size_t offset, Float8 rows) {
  simd::store(rowOf(k) + offset, rows.a);
  simd::store(rowOf(k + 4) + offset, rows.b);
}
SCREE_INLINE inline void transpose(Float8& a, Float8& b, Float8& c, Float8& d) {
  simd::transpose(a.a, b.a, c.a, d.a);
  simd::transpose(a.b, b.b, c.b, d.b);
}

inline uint32_t pack(uint32_t first, Float8 mask, unsigned within, uint32_t* out) {
  const unsigned top = bits(mask);
  uint32_t count = 0;
  for (; within != 0; within &= within - 1) {
    const uint32_t lane = static_cast<uint32_t>(std::countr_zero(within));
    out[count++] = (first + lane) | (top >> lane & 1) << 31;
  }
  return count;
}
template <>
inline Float8 maskOf<Float8>(unsigned lanes) {
  uint32_t lane[8];
  for (unsigned k = 0; k < 8; ++k) lane[k] = 0u - (lanes >> k & 1u);
  return load<Float8>(reinterpret_cast<const float*>(lane));
}

#endif

// Of each batch in the lanes: all of it if the mask has a lane of it. One batch: never asked without.
inline Float8::Mask wholeBatches(Float8::Mask mask) { return mask; }
// `now` in batches that are `active`, and `before` in others. One batch: it is.
inline Float8 inBatches(Float8::Mask, Float8 now, Float8) { return now; }

}  // namespace scree::simd::SCREE_LANES
