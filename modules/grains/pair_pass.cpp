// The pair passes: impulses between neighbouring grains, four pairs at a time.
//
// Impulse P of a contact acts on grain i along the normal n (from j to i) and across it; both arms
// end in one point of the line of centres, so that linear and angular momentum are conserved. A
// solid sphere answers a tangential impulse with (1 + 5/2) / m, hence the 2/7 of its rolling law.
#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/core/hash.h"
#include "modules/grains/contacts.h"
#include "modules/grains/simd4.h"

namespace scree::grains {
namespace {

using simd::Float4;
using simd::Vec3x4;

// Three components of one part of four bodies, and that part's fourth float.
struct Part {
  Vec3x4 v;
  Float4 w;
};

Part gather(const Body* body, const uint32_t* slot, size_t offset) {
  const auto row = [&](int k) {
    return simd::load(reinterpret_cast<const float*>(body + slot[k]) + offset);
  };
  Part part{{row(0), row(1), row(2)}, row(3)};
  simd::transpose(part.v.x, part.v.y, part.v.z, part.w);
  return part;
}

void scatter(Body* body, const uint32_t* slot, size_t offset, Part part) {
  simd::transpose(part.v.x, part.v.y, part.v.z, part.w);
  const auto row = [&](int k) { return reinterpret_cast<float*>(body + slot[k]) + offset; };
  simd::store(row(0), part.v.x);
  simd::store(row(1), part.v.y);
  simd::store(row(2), part.v.z);
  simd::store(row(3), part.w);
}

constexpr size_t kPosition = 0, kVelocity = 4, kSpin = 8;  // floats into Body
static_assert(offsetof(Body, velocity) == 4 * kVelocity && offsetof(Body, spin) == 4 * kSpin);

// Where two centres coincide, a direction that depends on the two entities only.
vec3 anyDirection(Entity a, Entity b) {
  const bool swapped = b < a;
  const uint64_t h = hashCombine(swapped ? b.index : a.index, swapped ? a.index : b.index);
  const auto component = [&](int shift) {
    return static_cast<float>(static_cast<int32_t>((h >> shift) & 0xffff) - 0x8000) + 0.5f;
  };
  const vec3 v(component(0), component(16), component(32));
  return v * ((swapped ? -1.0f : 1.0f) / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z));
}

void replaceCoincident(const PairSlab& slab, uint32_t c, int lanes, const Entity* entity,
                       Vec3x4& normal) {
  float x[4], y[4], z[4];
  simd::store3(x, y, z, normal);
  for (int k = 0; k < 4; ++k) {
    if ((lanes >> k & 1) == 0) continue;
    const vec3 v = anyDirection(entity[slab.i[c + uint32_t(k)]], entity[slab.j[c + uint32_t(k)]]);
    x[k] = v.x;
    y[k] = v.y;
    z[k] = v.z;
  }
  normal = simd::load3(x, y, z);
}

template <bool rolling, bool bouncing>
void relax(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings) {
  using namespace simd;
  const Float4 zero = splat(0), one = splat(1), tiny = splat(1e-37f);
  const Float4 h = splat(settings.h), inverse_h = splat(settings.inverse_h);
  const Float4 projection = splat(kProjection), slop = splat(kSlop);
  const uint32_t n = slab.count;
  float* lane = slab.lanes.data();
  const auto at = [&](Lane which) { return lane + size_t{n} * static_cast<size_t>(which); };
  float *ix = at(Lane::ImpulseX), *iy = at(Lane::ImpulseY), *iz = at(Lane::ImpulseZ);
  float *mx = at(Lane::MomentX), *my = at(Lane::MomentY), *mz = at(Lane::MomentZ);
  Float4 deepest = zero;

  for (uint32_t c = 0; c < n; c += 4) {
    const uint32_t *I = &slab.i[c], *J = &slab.j[c];
    Part xi = gather(body, I, kPosition), xj = gather(body, J, kPosition);
    const Vec3x4 d = xi.v - xj.v;
    const Float4 square = dot(d, d), sum = xi.w + xj.w;
    const Vec3x4 old = load3(ix + c, iy + c, iz + c);
    Part vi = gather(body, I, kVelocity), vj = gather(body, J, kVelocity);
    const Float4 distance = sqrt(square);
    const Float4 gap = distance - sum;
    const Float4 inverse = one / max(distance, tiny);
    Vec3x4 normal = inverse * d;
    const int coincident = bits(lessEqual(square, splat(1e-12f) * sum * sum));
    if (coincident != 0) replaceCoincident(slab, c, coincident, entity, normal);
    const Vec3x4 u = vi.v - vj.v;
    const Float4 un = dot(u, normal), old_n = dot(old, normal);
    const Float4 mass = one / (vi.w + vj.w);
    const Float4 touching = lessEqual(gap, zero);
    const Float4 kept =
        notEqual(old.x, zero) | notEqual(old.y, zero) | notEqual(old.z, zero);

    // Separation speed that is asked for: the gap may close within the substep, no more.
    Float4 asked = zero - inverse_h * max(gap, zero);
    if constexpr (bouncing) {
      const Float4 approach = load(at(Lane::Approach) + c);
      asked = select(less(zero, approach), approach, asked);
    }
    Float4 next_n = max(zero, old_n - mass * (un - asked));
    Float4 active = less(zero, next_n) | kept | touching;
    if (!any(active)) continue;

    // A pair that has not touched yet and would pass by has no contact, though the plane that
    // stands for the surface here is crossed.
    const Float4 closing = andNot(touching | kept, less(zero, next_n));
    Float4 hits = touching | kept;
    if (any(closing)) {
      const Float4 u2 = max(dot(u, u), tiny), du = distance * un;
      const Float4 t = min(max(zero - du / u2, zero), h);
      const Float4 nearest = square + t * (du + du + t * u2);
      const Float4 hit = closing & less(nearest, sum * sum);
      next_n = select(closing, hit & next_n, next_n);
      hits = hits | hit;
    }
    if constexpr (bouncing) {
      if (settings.first_pass) {
        const Float4 restitution = load(at(Lane::Restitution) + c);
        const Float4 fresh = andNot(kept, hits) & less(un, splat(-settings.bounce_speed)) &
                             less(zero, restitution) & less(zero, next_n);
        const Float4 approach = fresh & (restitution * (zero - un));
        store(at(Lane::Approach) + c, approach);
        next_n = select(fresh, max(zero, old_n - mass * (un - approach)), next_n);
        for (int f = bits(fresh & less(zero, gap)); f != 0; f &= f - 1) {
          const uint32_t k = static_cast<uint32_t>(std::countr_zero(unsigned(f)));
          float e[4], g[4], x[4], y[4], z[4];
          store(e, restitution);
          store(g, gap);
          store3(x, y, z, normal);
          slab.bounces.push_back({I[k], J[k], vec3(x[k], y[k], z[k]) * (-(1 + e[k]) * g[k])});
        }
      }
    }

    Part wi = gather(body, I, kSpin), wj = gather(body, J, kSpin);
    const Float4 arm = distance / sum;
    const Vec3x4 turn = arm * (xi.w * wi.v + xj.w * wj.v);
    const Vec3x4 ut = u - un * normal - cross(turn, normal);
    const Float4 mass_t = mass / (one + splat(2.5f) * arm * arm);
    const Vec3x4 wish = old - old_n * normal - mass_t * ut;
    const Float4 limit = load(at(Lane::Friction) + c) * next_n;
    const Float4 scale = min(one, limit / sqrt(max(dot(wish, wish), tiny)));
    const Vec3x4 next = next_n * normal + scale * wish;
    const Vec3x4 change = next - old;
    store3(ix + c, iy + c, iz + c, next);
    vi.v = vi.v + vi.w * change;
    vj.v = vj.v - vj.w * change;
    scatter(body, I, kVelocity, vi);
    scatter(body, J, kVelocity, vj);

    const Vec3x4 moment = arm * cross(normal, next);
    const Vec3x4 twist = moment - load3(mx + c, my + c, mz + c);
    store3(mx + c, my + c, mz + c, moment);
    wi.v = wi.v - wi.w * twist;
    wj.v = wj.v - wj.w * twist;
    if constexpr (rolling) {
      // Rolling resistance: a torque against the relative spin, at most mu_r r N, where r is half
      // the harmonic mean of the radii.
      float *rx = at(Lane::RollingX), *ry = at(Lane::RollingY), *rz = at(Lane::RollingZ);
      const Float4 ki = wi.w / xi.w, kj = wj.w / xj.w;  // 1 / moment of inertia
      const Vec3x4 old_r = load3(rx + c, ry + c, rz + c);
      const Vec3x4 wish_r = old_r - (one / (ki + kj)) * (wi.v - wj.v);
      const Float4 limit_r =
          load(at(Lane::RollingFriction) + c) * next_n * (xi.w * xj.w / sum);
      const Vec3x4 next_r =
          min(one, limit_r / sqrt(max(dot(wish_r, wish_r), tiny))) * wish_r;
      const Vec3x4 change_r = next_r - old_r;
      store3(rx + c, ry + c, rz + c, next_r);
      wi.v = wi.v + ki * change_r;
      wj.v = wj.v - kj * change_r;
    }
    scatter(body, I, kSpin, wi);
    scatter(body, J, kSpin, wj);

    const Float4 overlap = zero - gap - slop * sum;
    deepest = max(deepest, zero - gap);
    if (any(less(zero, overlap))) {
      const Vec3x4 shift = projection * max(overlap, zero) * mass * normal;
      xi.v = xi.v + vi.w * shift;
      xj.v = xj.v - vj.w * shift;
      scatter(body, I, kPosition, xi);
      scatter(body, J, kPosition, xj);
    }
  }
  float depth[4];
  store(depth, deepest);
  slab.deepest = std::max({slab.deepest, depth[0], depth[1], depth[2], depth[3]});
}

}  // namespace

void applyKeptPairs(PairSlab& slab, Body* body, const PassSettings& settings) {
  using namespace simd;
  const Float4 zero = splat(0);
  const uint32_t n = slab.count;
  float* lane = slab.lanes.data();
  const auto at = [&](Lane which) { return lane + size_t{n} * static_cast<size_t>(which); };
  float* trust = at(Lane::Trust);
  slab.bounces.clear();
  slab.deepest = 0;
  for (uint32_t c = 0; c < n; c += 4) {
    float *ix = at(Lane::ImpulseX) + c, *iy = at(Lane::ImpulseY) + c,
          *iz = at(Lane::ImpulseZ) + c;
    Vec3x4 impulse = load3(ix, iy, iz);
    const Float4 kept = notEqual(impulse.x, zero) | notEqual(impulse.y, zero) |
                        notEqual(impulse.z, zero);
    const Float4 trusted = load(trust + c);
    store(trust + c, kept & splat(1));
    if (settings.bouncing) store(at(Lane::Approach) + c, zero);
    if (!any(kept)) continue;
    // The impulse of an impact says nothing about the next substep: only contacts that lasted
    // longer than one keep theirs.
    impulse = trusted * impulse;
    store3(ix, iy, iz, impulse);
    float *mx = at(Lane::MomentX) + c, *my = at(Lane::MomentY) + c, *mz = at(Lane::MomentZ) + c;
    const Vec3x4 moment = trusted * load3(mx, my, mz);
    store3(mx, my, mz, moment);
    Vec3x4 rolling{zero, zero, zero};
    if (settings.rolling) {
      float *rx = at(Lane::RollingX) + c, *ry = at(Lane::RollingY) + c,
            *rz = at(Lane::RollingZ) + c;
      rolling = trusted * load3(rx, ry, rz);
      store3(rx, ry, rz, rolling);
    }
    if (!any(notEqual(trusted, zero))) continue;
    const uint32_t *I = &slab.i[c], *J = &slab.j[c];
    Part vi = gather(body, I, kVelocity), vj = gather(body, J, kVelocity);
    Part wi = gather(body, I, kSpin), wj = gather(body, J, kSpin);
    vi.v = vi.v + vi.w * impulse;
    vj.v = vj.v - vj.w * impulse;
    wi.v = wi.v - wi.w * moment;
    wj.v = wj.v - wj.w * moment;
    if (settings.rolling) {
      wi.v = wi.v + (wi.w / gather(body, I, kPosition).w) * rolling;
      wj.v = wj.v - (wj.w / gather(body, J, kPosition).w) * rolling;
    }
    scatter(body, I, kVelocity, vi);
    scatter(body, J, kVelocity, vj);
    scatter(body, I, kSpin, wi);
    scatter(body, J, kSpin, wj);
  }
}

void relaxPairs(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings) {
  if (settings.bouncing) {
    relax<true, true>(slab, body, entity, settings);
  } else if (settings.rolling) {
    relax<true, false>(slab, body, entity, settings);
  } else {
    relax<false, false>(slab, body, entity, settings);
  }
}

}  // namespace scree::grains
