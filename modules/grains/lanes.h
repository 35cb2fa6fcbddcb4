// Floats in lock step, for the instruction set whose namespace SCREE_LANES names: eight (Float8) and,
// with AVX-512, sixteen (Float16). Included several times, once for each instruction set.
// Only operations that IEEE 754 rounds exactly, and no fused ones: all sets give the same bits.
// A branch is taken for a batch of eight at a time: see wholeBatches().

namespace scree::simd::SCREE_LANES {

template <class Floats>
Floats splat(float a);
// Eight floats, and if there are more lanes, those that lie `next` floats further on.
template <class Floats>
Floats load(const float* p, size_t next = 0);
// The mask whose bits() are these.
template <class Floats>
typename Floats::Mask maskOf(unsigned lanes);

}  // namespace scree::simd::SCREE_LANES

#include "modules/grains/lanes8.h"
#if defined(SCREE_LANES_AVX512)
#include "modules/grains/lanes16.h"
#endif

namespace scree::simd::SCREE_LANES {

#if defined(SCREE_LANES_AVX512)
using Widest = Float16;
#else
using Widest = Float8;
#endif

template <class Mask>
inline bool any(Mask mask) {
  return bits(mask) != 0;
}

// Three components of each lane.
template <class Floats>
struct Vec3s {
  Floats x, y, z;
};
template <class Floats>
inline Vec3s<Floats> operator+(Vec3s<Floats> a, Vec3s<Floats> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Floats>
inline Vec3s<Floats> operator-(Vec3s<Floats> a, Vec3s<Floats> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Floats>
inline Vec3s<Floats> operator*(Floats s, Vec3s<Floats> a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Floats>
inline Vec3s<Floats> operator&(typename Floats::Mask mask, Vec3s<Floats> a) {
  return {mask & a.x, mask & a.y, mask & a.z};
}
template <class Floats>
inline Floats dot(Vec3s<Floats> a, Vec3s<Floats> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Floats>
inline Vec3s<Floats> cross(Vec3s<Floats> a, Vec3s<Floats> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Floats>
inline Vec3s<Floats> select(typename Floats::Mask mask, Vec3s<Floats> a, Vec3s<Floats> b) {
  return {select(mask, a.x, b.x), select(mask, a.y, b.y), select(mask, a.z, b.z)};
}
template <class Floats>
inline Vec3s<Floats> inBatches(typename Floats::Mask active, Vec3s<Floats> now, Vec3s<Floats> before) {
  return {inBatches(active, now.x, before.x), inBatches(active, now.y, before.y),
          inBatches(active, now.z, before.z)};
}
template <class Floats>
inline Vec3s<Floats> load3(const float (*p)[8], size_t next) {
  return {load<Floats>(p[0], next), load<Floats>(p[1], next), load<Floats>(p[2], next)};
}
template <class Floats>
inline void store3(float (*p)[8], size_t next, Vec3s<Floats> a) {
  store(p[0], next, a.x);
  store(p[1], next, a.y);
  store(p[2], next, a.z);
}


// Three columns of rows of four floats, and the fourth.
template <class Floats>
struct Part {
  Vec3s<Floats> v;
  Floats w;
};
// The part of each lane's row that lies `offset` floats behind rowOf(lane).
template <class Floats, class RowOf>
SCREE_INLINE inline Part<Floats> readPart(const RowOf& rowOf, size_t offset) {
  Floats a, b, c, d;
  readRows(rowOf, 0, offset, a);
  readRows(rowOf, 1, offset, b);
  readRows(rowOf, 2, offset, c);
  readRows(rowOf, 3, offset, d);
  transpose(a, b, c, d);
  return {{a, b, c}, d};
}
template <class Floats, class RowOf>
SCREE_INLINE inline void writePart(const RowOf& rowOf, size_t offset, const Part<Floats>& part) {
  Floats a = part.v.x, b = part.v.y, c = part.v.z, d = part.w;
  transpose(a, b, c, d);
  writeRows(rowOf, 0, offset, a);
  writeRows(rowOf, 1, offset, b);
  writeRows(rowOf, 2, offset, c);
  writeRows(rowOf, 3, offset, d);
}
// Two parts: where a row lies is made out once for both.
template <class Floats, class RowOf>
SCREE_INLINE inline void readParts(const RowOf& rowOf, size_t first, Part<Floats>& p, size_t second, Part<Floats>& q) {
  Floats a[4], b[4];
  for (int k = 0; k < 4; ++k) {
    readRows(rowOf, k, first, a[k]);
    readRows(rowOf, k, second, b[k]);
  }
  transpose(a[0], a[1], a[2], a[3]);
  transpose(b[0], b[1], b[2], b[3]);
  p = {{a[0], a[1], a[2]}, a[3]};
  q = {{b[0], b[1], b[2]}, b[3]};
}
template <class Floats, class RowOf>
SCREE_INLINE inline void writeParts(const RowOf& rowOf, size_t first, const Part<Floats>& p, size_t second,
                                    const Part<Floats>& q) {
  Floats a[4] = {p.v.x, p.v.y, p.v.z, p.w}, b[4] = {q.v.x, q.v.y, q.v.z, q.w};
  transpose(a[0], a[1], a[2], a[3]);
  transpose(b[0], b[1], b[2], b[3]);
  for (int k = 0; k < 4; ++k) {
    writeRows(rowOf, k, first, a[k]);
    writeRows(rowOf, k, second, b[k]);
  }
}

}  // namespace scree::simd::SCREE_LANES
