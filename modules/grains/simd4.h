// Four floats in lock step: SSE2 where there is SSE2 (every x86-64), plain loops elsewhere.
// Only operations that IEEE 754 rounds exactly, so that both give the same bits.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace scree::simd {

#if defined(__SSE2__) && !defined(SCREE_SIMD_PLAIN)

struct Float4 {
  __m128 v;
};

inline Float4 splat(float a) { return {_mm_set1_ps(a)}; }
inline Float4 load(const float* p) { return {_mm_loadu_ps(p)}; }
inline void store(float* p, Float4 a) { _mm_storeu_ps(p, a.v); }
inline Float4 operator+(Float4 a, Float4 b) { return {_mm_add_ps(a.v, b.v)}; }
inline Float4 operator-(Float4 a, Float4 b) { return {_mm_sub_ps(a.v, b.v)}; }
inline Float4 operator*(Float4 a, Float4 b) { return {_mm_mul_ps(a.v, b.v)}; }
inline Float4 operator/(Float4 a, Float4 b) { return {_mm_div_ps(a.v, b.v)}; }
inline Float4 sqrt(Float4 a) { return {_mm_sqrt_ps(a.v)}; }
// The second operand if either is NaN.
inline Float4 min(Float4 a, Float4 b) { return {_mm_min_ps(a.v, b.v)}; }
inline Float4 max(Float4 a, Float4 b) { return {_mm_max_ps(a.v, b.v)}; }
// Masks: all bits of a lane set or clear.
inline Float4 less(Float4 a, Float4 b) { return {_mm_cmplt_ps(a.v, b.v)}; }
inline Float4 lessEqual(Float4 a, Float4 b) { return {_mm_cmple_ps(a.v, b.v)}; }
inline Float4 notEqual(Float4 a, Float4 b) { return {_mm_cmpneq_ps(a.v, b.v)}; }
inline Float4 operator&(Float4 a, Float4 b) { return {_mm_and_ps(a.v, b.v)}; }
inline Float4 operator|(Float4 a, Float4 b) { return {_mm_or_ps(a.v, b.v)}; }
// b where the mask is clear.
inline Float4 andNot(Float4 mask, Float4 b) { return {_mm_andnot_ps(mask.v, b.v)}; }
// One bit a lane.
inline int bits(Float4 mask) { return _mm_movemask_ps(mask.v); }
// Rows to columns: a, b, c, d hold (x, y, z, w) of lanes 0 to 3; afterwards x of all lanes, ...
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
  _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v);
}

#else

struct Float4 {
  float v[4];
};

namespace detail {
template <class F>
inline Float4 each(Float4 a, Float4 b, F f) {
  Float4 r;
  for (int k = 0; k < 4; ++k) r.v[k] = f(a.v[k], b.v[k]);
  return r;
}
inline float mask(bool on) {
  const uint32_t u = on ? 0xffffffffu : 0u;
  float f;
  std::memcpy(&f, &u, 4);
  return f;
}
inline uint32_t raw(float f) {
  uint32_t u;
  std::memcpy(&u, &f, 4);
  return u;
}
inline float cooked(uint32_t u) {
  float f;
  std::memcpy(&f, &u, 4);
  return f;
}
}  // namespace detail

inline Float4 splat(float a) { return {{a, a, a, a}}; }
inline Float4 load(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
inline void store(float* p, Float4 a) { std::memcpy(p, a.v, 16); }
inline Float4 operator+(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x + y; });
}
inline Float4 operator-(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x - y; });
}
inline Float4 operator*(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x * y; });
}
inline Float4 operator/(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x / y; });
}
inline Float4 sqrt(Float4 a) {
  return detail::each(a, a, [](float x, float) { return std::sqrt(x); });
}
inline Float4 min(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x < y ? x : y; });
}
inline Float4 max(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return x > y ? x : y; });
}
inline Float4 less(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return detail::mask(x < y); });
}
inline Float4 lessEqual(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return detail::mask(x <= y); });
}
inline Float4 notEqual(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) { return detail::mask(!(x == y)); });
}
inline Float4 operator&(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) {
    return detail::cooked(detail::raw(x) & detail::raw(y));
  });
}
inline Float4 operator|(Float4 a, Float4 b) {
  return detail::each(a, b, [](float x, float y) {
    return detail::cooked(detail::raw(x) | detail::raw(y));
  });
}
inline Float4 andNot(Float4 mask, Float4 b) {
  return detail::each(mask, b, [](float x, float y) {
    return detail::cooked(~detail::raw(x) & detail::raw(y));
  });
}
inline int bits(Float4 mask) {
  int r = 0;
  for (int k = 0; k < 4; ++k) r |= static_cast<int>(detail::raw(mask.v[k]) >> 31) << k;
  return r;
}
inline void transpose(Float4& a, Float4& b, Float4& c, Float4& d) {
  const Float4 rows[4] = {a, b, c, d};
  Float4* columns[4] = {&a, &b, &c, &d};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) columns[i]->v[k] = rows[k].v[i];
}

#endif

inline Float4 select(Float4 mask, Float4 a, Float4 b) { return (mask & a) | andNot(mask, b); }
inline bool any(Float4 mask) { return bits(mask) != 0; }

// Three components of four lanes.
struct Vec3x4 {
  Float4 x, y, z;
};
inline Vec3x4 operator+(Vec3x4 a, Vec3x4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3x4 operator-(Vec3x4 a, Vec3x4 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3x4 operator*(Float4 s, Vec3x4 a) { return {s * a.x, s * a.y, s * a.z}; }
inline Float4 dot(Vec3x4 a, Vec3x4 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3x4 cross(Vec3x4 a, Vec3x4 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3x4 load3(const float* x, const float* y, const float* z) {
  return {load(x), load(y), load(z)};
}
inline void store3(float* x, float* y, float* z, Vec3x4 a) {
  store(x, a.x);
  store(y, a.y);
  store(z, a.z);
}

}  // namespace scree::simd
