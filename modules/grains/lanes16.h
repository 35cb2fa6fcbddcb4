// Sixteen floats in lock step: AVX-512.
// Included several times, once for each instruction set: see lanes.h.

namespace scree::simd::SCREE_LANES {

struct Mask16 {
  __mmask16 v;
};
struct Float16 {
  __m512 v;
  using Mask = Mask16;
  static constexpr uint32_t kLanes = 16;
};

template <>
inline Float16 splat<Float16>(float a) { return {_mm512_set1_ps(a)}; }
template <>
inline Float16 load<Float16>(const float* p, size_t next) {
  return {_mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p)), _mm256_loadu_ps(p + next), 1)};
}
inline void store(float* p, size_t next, Float16 a) {
  _mm256_storeu_ps(p, _mm512_castps512_ps256(a.v));
  _mm256_storeu_ps(p + next, _mm512_extractf32x8_ps(a.v, 1));
}
inline Float16 operator+(Float16 a, Float16 b) { return {_mm512_add_ps(a.v, b.v)}; }
inline Float16 operator-(Float16 a, Float16 b) { return {_mm512_sub_ps(a.v, b.v)}; }
inline Float16 operator*(Float16 a, Float16 b) { return {_mm512_mul_ps(a.v, b.v)}; }
inline Float16 operator/(Float16 a, Float16 b) { return {_mm512_div_ps(a.v, b.v)}; }
inline Float16 sqrt(Float16 a) { return {_mm512_sqrt_ps(a.v)}; }
// The second operand if either is NaN.
inline Float16 min(Float16 a, Float16 b) { return {_mm512_min_ps(a.v, b.v)}; }
inline Float16 max(Float16 a, Float16 b) { return {_mm512_max_ps(a.v, b.v)}; }
inline Mask16 less(Float16 a, Float16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OS)}; }
inline Mask16 lessEqual(Float16 a, Float16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OS)}; }
inline Mask16 notEqual(Float16 a, Float16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_NEQ_UQ)}; }
inline Mask16 operator&(Mask16 a, Mask16 b) { return {static_cast<__mmask16>(a.v & b.v)}; }
inline Mask16 operator|(Mask16 a, Mask16 b) { return {static_cast<__mmask16>(a.v | b.v)}; }
inline Mask16 andNot(Mask16 mask, Mask16 b) { return {static_cast<__mmask16>(~mask.v & b.v)}; }
inline Float16 operator&(Mask16 mask, Float16 b) { return {_mm512_maskz_mov_ps(mask.v, b.v)}; }
inline Float16 andNot(Mask16 mask, Float16 b) {
  return {_mm512_maskz_mov_ps(static_cast<__mmask16>(~mask.v), b.v)};
}
inline Float16 select(Mask16 mask, Float16 a, Float16 b) { return {_mm512_mask_mov_ps(b.v, mask.v, a.v)}; }
inline unsigned bits(Mask16 mask) { return mask.v; }
template <>
inline Mask16 maskOf<Float16>(unsigned lanes) { return {static_cast<__mmask16>(lanes)}; }

// See those of Float8.
inline Mask16 wholeBatches(Mask16 mask) {
  return {static_cast<__mmask16>(((mask.v & 0xff) != 0 ? 0xff : 0) | (mask.v > 0xff ? 0xff00 : 0))};
}
inline Float16 inBatches(Mask16 active, Float16 now, Float16 before) { return select(active, now, before); }

template <class RowOf>
SCREE_INLINE inline void readRows(const RowOf& rowOf, int k, size_t offset, Float16& rows) {
  const auto row = [&](int at) SCREE_INLINE { return _mm_loadu_ps(rowOf(at) + offset); };
  const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(row(k)), row(k + 4), 1);
  const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(row(k + 8)), row(k + 12), 1);
  rows.v = _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}
template <class RowOf>
SCREE_INLINE inline void writeRows(const RowOf& rowOf, int k, size_t offset, Float16 rows) {
  const __m256 low = _mm512_castps512_ps256(rows.v), high = _mm512_extractf32x8_ps(rows.v, 1);
  _mm_storeu_ps(rowOf(k) + offset, _mm256_castps256_ps128(low));
  _mm_storeu_ps(rowOf(k + 4) + offset, _mm256_extractf128_ps(low, 1));
  _mm_storeu_ps(rowOf(k + 8) + offset, _mm256_castps256_ps128(high));
  _mm_storeu_ps(rowOf(k + 12) + offset, _mm256_extractf128_ps(high, 1));
}
SCREE_INLINE inline void transpose(Float16& a, Float16& b, Float16& c, Float16& d) {
  const __m512 ab_low = _mm512_unpacklo_ps(a.v, b.v), cd_low = _mm512_unpacklo_ps(c.v, d.v);
  const __m512 ab_high = _mm512_unpackhi_ps(a.v, b.v), cd_high = _mm512_unpackhi_ps(c.v, d.v);
  a.v = _mm512_shuffle_ps(ab_low, cd_low, 0x44);
  b.v = _mm512_shuffle_ps(ab_low, cd_low, 0xee);
  c.v = _mm512_shuffle_ps(ab_high, cd_high, 0x44);
  d.v = _mm512_shuffle_ps(ab_high, cd_high, 0xee);
}

}  // namespace scree::simd::SCREE_LANES
