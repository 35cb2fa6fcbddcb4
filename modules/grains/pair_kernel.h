// The pair passes: impulses between neighbouring grains, eight pairs at a time.
// Included several times, once for each instruction set: see lanes8.h.
//
// Impulse P of a contact acts on grain i along the normal n (from j to i) and across it; both arms
// end in one point of the line of centres, so that linear and angular momentum are conserved. A
// solid sphere answers a tangential impulse with (1 + 5/2) / m, hence the 2/7 of its rolling law.

namespace scree::grains::SCREE_LANES {

using namespace simd::SCREE_LANES;

// Three components of one part of eight bodies, and that part's fourth float.
struct Part {
  Vec3x8 v;
  Float8 w;
};

inline Part read(const Body* body, const uint32_t* slot, size_t offset) {
  Part part;
  gather(reinterpret_cast<const float*>(body) + offset, sizeof(Body) / sizeof(float), slot,
         part.v.x, part.v.y, part.v.z, part.w);
  return part;
}
inline void write(Body* body, const uint32_t* slot, size_t offset, const Part& part) {
  scatter(reinterpret_cast<float*>(body) + offset, sizeof(Body) / sizeof(float), slot, part.v.x,
          part.v.y, part.v.z, part.w);
}

inline void replaceCoincident(const uint32_t* i, const uint32_t* j, unsigned lanes,
                              const Entity* entity, Vec3x8& normal) {
  float n[3][kBatch];
  store3(n, normal);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int k = std::countr_zero(lanes);
    const vec3 v = anyDirection(entity[i[k]], entity[j[k]]);
    n[0][k] = v.x;
    n[1][k] = v.y;
    n[2][k] = v.z;
  }
  normal = load3(n);
}

// Notes that pairs begin to bounce; `fresh` are those that overlap already.
inline void noteBounces(PairSlab& slab, const uint32_t* i, const uint32_t* j, unsigned fresh,
                        Float8 restitution, Float8 gap, Vec3x8 normal) {
  float e[kBatch], g[kBatch], n[3][kBatch];
  store(e, restitution);
  store(g, gap);
  store3(n, normal);
  for (; fresh != 0; fresh &= fresh - 1) {
    const int k = std::countr_zero(fresh);
    slab.bounces.push_back({i[k], j[k], vec3(n[0][k], n[1][k], n[2][k]) * (-(1 + e[k]) * g[k])});
  }
}

// What contacts hold: gripOf() and heldRebound() of cohesion.h, eight at a time.
struct Grips {
  Float8 impulse, limit;
};
inline Grips gripOf(Float8 before, Float8 speed, Float8 mass, Float8 inverse_mass, Float8 pull, Float8 left,
                    const PassSettings& settings) {
  const Float8 zero = splat(0), h = splat(settings.h), most = pull * h, stops = mass * speed;
  const Float8 from = max(before, zero);
  const Float8 slowing = pull * inverse_mass - splat(settings.inverse_h) * (speed - from);
  const Float8 square = from * from - (slowing + slowing) * left;
  const Float8 sum = from + sqrt(max(square, zero));
  const Float8 leaves = lessEqual(zero, square) & less(left + left, h * sum);
  const Float8 torn = (pull + pull) * left / sum;
  return {select(leaves, torn, min(max(stops, zero), most)), select(leaves, torn, most)};
}
inline Float8 heldRebound(Float8 speed, Float8 slowing, Float8 reach, Float8 rest) {
  const Float8 lost = slowing * rest, square = speed * speed;
  const Float8 slowed = square / (lost + sqrt(lost * lost + square));
  const Float8 left = sqrt(max(square - (slowing + slowing) * reach, splat(0)));
  return select(lessEqual(slowed * rest, reach), slowed, left);
}

template <bool kRolling, bool kBouncing, bool kCohesive>
void relaxBatches(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings) {
  const Float8 zero = splat(0), one = splat(1), tiny = splat(1e-37f);
  const Float8 h = splat(settings.h), inverse_h = splat(settings.inverse_h);
  const Float8 projection = splat(kProjection), slop = splat(kSlop);
  const uint32_t batches = slab.count / kBatch;
  Float8 deepest = zero;
  slab.carried = 0;

  for (uint32_t b = 0; b < batches; ++b) {
    const uint32_t *i = &slab.i[size_t{kBatch} * b], *j = &slab.j[size_t{kBatch} * b];
    float(*const carried)[kBatch] = slab.impulse[b].impulse;
    Part xi = read(body, i, kPosition), xj = read(body, j, kPosition);
    const Vec3x8 d = xi.v - xj.v;
    const Float8 square = dot(d, d), sum = xi.w + xj.w;
    const Vec3x8 old = load3(carried);
    Part vi = read(body, i, kVelocity), vj = read(body, j, kVelocity);
    const Float8 distance = sqrt(square);
    const Float8 gap = distance - sum;
    Vec3x8 normal = (one / max(distance, tiny)) * d;
    const unsigned coincident = bits(lessEqual(square, splat(1e-12f) * sum * sum));
    if (coincident != 0) replaceCoincident(i, j, coincident, entity, normal);
    const Vec3x8 u = vi.v - vj.v;
    const Float8 un = dot(u, normal), old_n = dot(old, normal);
    const Float8 mass = one / (vi.w + vj.w);
    Float8 touching = lessEqual(gap, zero);
    const Float8 kept = notEqual(old.x, zero) | notEqual(old.y, zero) | notEqual(old.z, zero);

    // Separation speed that is asked for: the gap may close within the substep, no more.
    Float8 asked = zero - inverse_h * max(gap, zero);
    if constexpr (kBouncing) {
      const Float8 approach = load(slab.bouncing[b].approach);
      asked = select(less(zero, approach), approach, asked);
    }
    Float8 next_n = max(zero, old_n - mass * (un - asked));
    [[maybe_unused]] Float8 pull, reach, holds;
    [[maybe_unused]] Grips grip;
    if constexpr (kCohesive) {
      pull = load(slab.cohesion[b].pull);
      reach = splat(kReach) * (xi.w * xj.w / sum);
      const Float8 left = reach - max(gap, zero), stops = mass * un - old_n;
      holds = less(zero, pull) & less(zero, left) & (touching | kept | less(zero, stops));
      if constexpr (kBouncing) holds = andNot(less(zero, load(slab.bouncing[b].approach)), holds);
      const Float8 before = dot(read(body, i, kBefore).v - read(body, j, kBefore).v, normal);
      grip = gripOf(before, (vi.w + vj.w) * stops, mass, vi.w + vj.w, pull, left, settings);
      grip = {holds & grip.impulse, holds & grip.limit};
      next_n = select(less(zero, next_n), next_n, zero - grip.impulse);
      touching = touching | holds;
    }
    const Float8 touched = touching | kept, pushed = less(zero, next_n);
    if (!any(touched | pushed)) continue;

    // A pair that has not touched yet and would pass by has no contact, though the plane that
    // stands for the surface here is crossed.
    const Float8 closing = andNot(touched, pushed);
    Float8 hits = touched;
    if (any(closing)) {
      const Float8 u2 = max(dot(u, u), tiny), du = distance * un;
      const Float8 t = min(max(zero - du / u2, zero), h);
      const Float8 nearest = square + t * (du + du + t * u2);
      const Float8 hit = closing & less(nearest, sum * sum);
      next_n = select(closing, hit & next_n, next_n);
      hits = hits | hit;
      if (!any(hits)) continue;
    }
    if constexpr (kBouncing) {
      if (settings.first_pass) {
        Float8 restitution = load(slab.bouncing[b].restitution);
        Float8 fresh = andNot(kept, hits) & less(un, splat(-settings.bounce_speed)) &
                             less(zero, restitution) & less(zero, next_n);
        Float8 approach = fresh & (restitution * (zero - un));
        if constexpr (kCohesive) {
          const Float8 rest = max(h - max(gap, zero) / max(zero - un, tiny), zero);
          const Float8 held = heldRebound(approach, pull * (vi.w + vj.w), reach, rest);
          approach = fresh & select(less(zero, pull), held, approach);
          fresh = less(zero, approach);
          restitution = select(fresh, approach / max(zero - un, tiny), restitution);
          grip.limit = andNot(fresh, grip.limit);
        }
        store(slab.bouncing[b].approach, approach);
        next_n = select(fresh, max(zero, old_n - mass * (un - approach)), next_n);
        noteBounces(slab, i, j, bits(fresh & less(zero, gap)), restitution, gap, normal);
      }
    }

    Part wi = read(body, i, kSpin), wj = read(body, j, kSpin);
    const Float8 inverse_sum = one / sum;
    const Vec3x8 lever = inverse_sum * d;  // from the contact to the centres, in radii
    const Vec3x8 turn = xi.w * wi.v + xj.w * wj.v;
    const Vec3x8 ut = u - un * normal - cross(turn, lever);
    const Float8 mass_t = mass / (one + splat(2.5f) * (inverse_sum * inverse_sum * square));
    const Vec3x8 wish = old - old_n * normal - mass_t * ut;
    Float8 pressed = next_n;  // together, by whatever
    if constexpr (kCohesive) pressed = next_n + grip.limit;
    const Float8 limit = wi.w * wj.w * pressed;
    const Float8 scale = min(one, limit / sqrt(max(dot(wish, wish), tiny)));
    const Vec3x8 next = next_n * normal + scale * wish;
    const Vec3x8 change = next - old;
    store3(carried, next);
    slab.carried += static_cast<uint32_t>(std::popcount(
        bits(notEqual(next.x, zero) | notEqual(next.y, zero) | notEqual(next.z, zero))));
    vi.v = vi.v + vi.w * change;
    vj.v = vj.v - vj.w * change;
    write(body, i, kVelocity, vi);
    write(body, j, kVelocity, vj);

    const Vec3x8 twist = cross(lever, change);
    const Float8 inverse_radii = splat(2.5f) / (xi.w * xj.w);
    wi.v = wi.v - vi.w * (xj.w * inverse_radii) * twist;
    wj.v = wj.v - vj.w * (xi.w * inverse_radii) * twist;
    if constexpr (kRolling) {
      // Rolling resistance: a torque against the relative spin, at most mu_r r N, where r is half
      // the harmonic mean of the radii.
      RollingBatch& rolls = slab.rolling[b];
      const Float8 ki = splat(2.5f) * vi.w / (xi.w * xi.w),  // 1 / moment of inertia
          kj = splat(2.5f) * vj.w / (xj.w * xj.w);
      const Vec3x8 old_r = load3(rolls.impulse);
      const Vec3x8 wish_r = old_r - (one / (ki + kj)) * (wi.v - wj.v);
      const Float8 limit_r = load(rolls.friction) * pressed * (xi.w * xj.w * inverse_sum);
      const Vec3x8 next_r = min(one, limit_r / sqrt(max(dot(wish_r, wish_r), tiny))) * wish_r;
      const Vec3x8 change_r = next_r - old_r;
      store3(rolls.impulse, next_r);
      wi.v = wi.v + ki * change_r;
      wj.v = wj.v - kj * change_r;
    }
    write(body, i, kSpin, wi);
    write(body, j, kSpin, wj);

    const Float8 overlap = zero - gap - slop * sum;
    deepest = max(deepest, zero - gap);
    Float8 undone = max(overlap, zero);
    if constexpr (kCohesive) {  // what hangs is drawn to touch again
      const Float8 hangs = less(next_n, zero) & less(grip.impulse, grip.limit);
      undone = select(hangs, undone + min(slop * sum - gap, zero), undone);
    }
    if (any(notEqual(undone, zero))) {
      const Vec3x8 shift = projection * undone * mass * normal;
      xi.v = xi.v + vi.w * shift;
      xj.v = xj.v - vj.w * shift;
      write(body, i, kPosition, xi);
      write(body, j, kPosition, xj);
    }
  }
  float depth[kBatch];
  store(depth, deepest);
  for (const float overlap : depth) slab.deepest = std::max(slab.deepest, overlap);
}

inline void applyKept(PairSlab& slab, Body* body, const PassSettings& settings) {
  const Float8 zero = splat(0);
  const uint32_t batches = slab.count / kBatch;
  slab.bounces.clear();
  slab.deepest = 0;
  for (uint32_t b = 0; b < batches; ++b) {
    if (settings.bouncing) store(slab.bouncing[b].approach, zero);
    float(*const carried)[kBatch] = slab.impulse[b].impulse;
    Vec3x8 impulse = load3(carried);
    const unsigned kept = bits(notEqual(impulse.x, zero) | notEqual(impulse.y, zero) |
                               notEqual(impulse.z, zero));
    const unsigned trusted = kept & slab.trust[b];
    slab.trust[b] = static_cast<uint8_t>(kept);
    if (kept == 0) continue;
    // The impulse of an impact says nothing about the next substep: only contacts that lasted
    // longer than one keep theirs.
    if (trusted != kept) {
      const Float8 mask = maskOf(trusted);
      impulse = mask & impulse;
      store3(carried, impulse);
      if (settings.rolling)
        store3(slab.rolling[b].impulse, mask & load3(slab.rolling[b].impulse));
    }
    if (trusted == 0) continue;
    const uint32_t *i = &slab.i[size_t{kBatch} * b], *j = &slab.j[size_t{kBatch} * b];
    const Part xi = read(body, i, kPosition), xj = read(body, j, kPosition);
    Part vi = read(body, i, kVelocity), vj = read(body, j, kVelocity);
    Part wi = read(body, i, kSpin), wj = read(body, j, kSpin);
    const Vec3x8 lever = (splat(1) / (xi.w + xj.w)) * (xi.v - xj.v);
    const Vec3x8 moment = cross(lever, impulse);
    const Float8 inverse_radii = splat(2.5f) / (xi.w * xj.w);
    vi.v = vi.v + vi.w * impulse;
    vj.v = vj.v - vj.w * impulse;
    wi.v = wi.v - vi.w * (xj.w * inverse_radii) * moment;
    wj.v = wj.v - vj.w * (xi.w * inverse_radii) * moment;
    if (settings.rolling) {
      const Vec3x8 rolling = load3(slab.rolling[b].impulse);
      wi.v = wi.v + (splat(2.5f) * vi.w / (xi.w * xi.w)) * rolling;
      wj.v = wj.v - (splat(2.5f) * vj.w / (xj.w * xj.w)) * rolling;
    }
    write(body, i, kVelocity, vi);
    write(body, j, kVelocity, vj);
    write(body, i, kSpin, wi);
    write(body, j, kSpin, wj);
  }
}

inline void relax(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings) {
  if (settings.cohesive) {
    if (settings.bouncing) {
      relaxBatches<true, true, true>(slab, body, entity, settings);
    } else {
      relaxBatches<true, false, true>(slab, body, entity, settings);
    }
  } else if (settings.bouncing) {
    relaxBatches<true, true, false>(slab, body, entity, settings);
  } else if (settings.rolling) {
    relaxBatches<true, false, false>(slab, body, entity, settings);
  } else {
    relaxBatches<false, false, false>(slab, body, entity, settings);
  }
}

}  // namespace scree::grains::SCREE_LANES
