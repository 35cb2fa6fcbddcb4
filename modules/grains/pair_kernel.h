// The pair passes: impulses between neighbouring grains, eight or sixteen pairs at a time.
// Included several times, once for each instruction set: see lanes.h.
//
// Impulse P of a contact acts on grain i along the normal n (from j to i) and across it; both arms
// end in one point of the line of centres, so that linear and angular momentum are conserved. A
// solid sphere answers a tangential impulse with (1 + 5/2) / m, hence the 2/7 of its rolling law.

namespace scree::grains::SCREE_LANES {

using namespace simd::SCREE_LANES;

// Parts of the bodies of slots.
SCREE_INLINE inline auto rowsOf(const Body* body, const uint32_t* slot) {
  return [=](int k) SCREE_INLINE { return reinterpret_cast<const float*>(body + slot[k]); };
}
SCREE_INLINE inline auto rowsOf(Body* body, const uint32_t* slot) {
  return [=](int k) SCREE_INLINE { return reinterpret_cast<float*>(body + slot[k]); };
}
template <class Floats>
SCREE_INLINE inline Part<Floats> read(const Body* body, const uint32_t* slot, size_t offset) {
  return readPart<Floats>(rowsOf(body, slot), offset);
}
template <class Floats>
SCREE_INLINE inline void write(Body* body, const uint32_t* slot, size_t offset, const Part<Floats>& part) {
  writePart(rowsOf(body, slot), offset, part);
}

// Of what a contact carries: floats from a batch to the next.
template <class Batch>
inline constexpr size_t kNext = sizeof(Batch) / sizeof(float);

template <class Floats>
inline void replaceCoincident(const uint32_t* i, const uint32_t* j, unsigned lanes,
                              const Entity* entity, Vec3s<Floats>& normal) {
  float n[3][Floats::kLanes];
  store(n[0], kBatch, normal.x);
  store(n[1], kBatch, normal.y);
  store(n[2], kBatch, normal.z);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int k = std::countr_zero(lanes);
    const vec3 v = anyDirection(entity[i[k]], entity[j[k]]);
    n[0][k] = v.x;
    n[1][k] = v.y;
    n[2][k] = v.z;
  }
  normal = {load<Floats>(n[0], kBatch), load<Floats>(n[1], kBatch), load<Floats>(n[2], kBatch)};
}

// Notes that pairs begin to bounce; `fresh` are those that overlap already.
template <class Floats>
inline void noteBounces(PairSlab& slab, const uint32_t* i, const uint32_t* j, unsigned fresh,
                        Floats restitution, Floats gap, Vec3s<Floats> normal) {
  float e[Floats::kLanes], g[Floats::kLanes], n[3][Floats::kLanes];
  store(e, kBatch, restitution);
  store(g, kBatch, gap);
  store(n[0], kBatch, normal.x);
  store(n[1], kBatch, normal.y);
  store(n[2], kBatch, normal.z);
  for (; fresh != 0; fresh &= fresh - 1) {
    const int k = std::countr_zero(fresh);
    slab.bounces.push_back({i[k], j[k], vec3(n[0][k], n[1][k], n[2][k]) * (-(1 + e[k]) * g[k])});
  }
}

// What contacts hold: gripOf() and heldRebound() of cohesion.h, for each lane.
template <class Floats>
struct Grips {
  Floats impulse, limit;
};
template <class Floats>
inline Grips<Floats> gripOf(Floats before, Floats speed, Floats mass, Floats inverse_mass, Floats pull,
                            Floats left, const PassSettings& settings) {
  const Floats zero = splat<Floats>(0), h = splat<Floats>(settings.h), most = pull * h, stops = mass * speed;
  const Floats from = max(before, zero);
  const Floats slowing = pull * inverse_mass - splat<Floats>(settings.inverse_h) * (speed - from);
  const Floats square = from * from - (slowing + slowing) * left;
  const Floats sum = from + sqrt(max(square, zero));
  const typename Floats::Mask leaves = lessEqual(zero, square) & less(left + left, h * sum);
  const Floats torn = (pull + pull) * left / sum;
  return {select(leaves, torn, min(max(stops, zero), most)), select(leaves, torn, most)};
}
template <class Floats>
inline Floats heldRebound(Floats speed, Floats slowing, Floats reach, Floats rest) {
  const Floats lost = slowing * rest, square = speed * speed;
  const Floats slowed = square / (lost + sqrt(lost * lost + square));
  const Floats left = sqrt(max(square - (slowing + slowing) * reach, splat<Floats>(0)));
  return select(lessEqual(slowed * rest, reach), slowed, left);
}

// Batch b, or with sixteen lanes also the next, which shares no grain with it. A batch of which no
// lane acts stays as it is to the bit, whatever the other does. Returns how deep the lanes overlap.
template <class Floats, bool kRolling, bool kBouncing, bool kCohesive>
SCREE_INLINE inline Floats relaxStep(PairSlab& slab, uint32_t b, Body* body, const Entity* entity,
                                     const PassSettings& settings) {
  using Mask = typename Floats::Mask;
  using Vec = Vec3s<Floats>;
  const Floats zero = splat<Floats>(0), one = splat<Floats>(1), tiny = splat<Floats>(1e-37f);
  const Floats h = splat<Floats>(settings.h), inverse_h = splat<Floats>(settings.inverse_h);
  const Floats projection = splat<Floats>(kProjection), slop = splat<Floats>(kSlop);
  constexpr size_t kNextImpulse = kNext<ImpulseBatch>, kNextRolling = kNext<RollingBatch>,
                   kNextBouncing = kNext<BouncingBatch>, kNextCohesion = kNext<CohesionBatch>;

  const uint32_t *i = &slab.i[size_t{kBatch} * b], *j = &slab.j[size_t{kBatch} * b];
  float(*const carried)[kBatch] = slab.impulse[b].impulse;
  Part<Floats> xi, xj, vi, vj;
  readParts(rowsOf(body, i), kPosition, xi, kVelocity, vi);
  readParts(rowsOf(body, j), kPosition, xj, kVelocity, vj);
  const Vec d = xi.v - xj.v;
  const Floats square = dot(d, d), sum = xi.w + xj.w;
  const Vec old = load3<Floats>(carried, kNextImpulse);
  const Floats distance = sqrt(square);
  const Floats gap = distance - sum;
  Vec normal = (one / max(distance, tiny)) * d;
  const unsigned coincident = bits(lessEqual(square, splat<Floats>(1e-12f) * sum * sum));
  if (coincident != 0) replaceCoincident(i, j, coincident, entity, normal);
  const Vec u = vi.v - vj.v;
  const Floats un = dot(u, normal), old_n = dot(old, normal);
  const Floats mass = one / (vi.w + vj.w);
  Mask touching = lessEqual(gap, zero);
  const Mask kept = notEqual(old.x, zero) | notEqual(old.y, zero) | notEqual(old.z, zero);

  // Separation speed that is asked for: the gap may close within the substep, no more.
  Floats asked = zero - inverse_h * max(gap, zero);
  if constexpr (kBouncing) {
    const Floats approach = load<Floats>(slab.bouncing[b].approach, kNextBouncing);
    asked = select(less(zero, approach), approach, asked);
  }
  Floats next_n = max(zero, old_n - mass * (un - asked));
  [[maybe_unused]] Floats pull, reach;
  [[maybe_unused]] Mask holds;
  [[maybe_unused]] Grips<Floats> grip;
  if constexpr (kCohesive) {
    pull = load<Floats>(slab.cohesion[b].pull, kNextCohesion);
    reach = splat<Floats>(kReach) * (xi.w * xj.w / sum);
    const Floats left = reach - max(gap, zero), stops = mass * un - old_n;
    holds = less(zero, pull) & less(zero, left) & (touching | kept | less(zero, stops));
    if constexpr (kBouncing)
      holds = andNot(less(zero, load<Floats>(slab.bouncing[b].approach, kNextBouncing)), holds);
    const Floats before =
        dot(read<Floats>(body, i, kBefore).v - read<Floats>(body, j, kBefore).v, normal);
    grip = gripOf(before, (vi.w + vj.w) * stops, mass, vi.w + vj.w, pull, left, settings);
    grip = {holds & grip.impulse, holds & grip.limit};
    next_n = select(less(zero, next_n), next_n, zero - grip.impulse);
    touching = touching | holds;
  }
  const Mask touched = touching | kept, pushed = less(zero, next_n);
  if (!any(touched | pushed)) return zero;

  // A pair that has not touched yet and would pass by has no contact, though the plane that
  // stands for the surface here is crossed.
  const Mask closing = andNot(touched, pushed);
  Mask hits = touched;
  if (any(closing)) {
    const Floats u2 = max(dot(u, u), tiny), du = distance * un;
    const Floats t = min(max(zero - du / u2, zero), h);
    const Floats nearest = square + t * (du + du + t * u2);
    const Mask hit = closing & less(nearest, sum * sum);
    next_n = select(closing, hit & next_n, next_n);
    hits = hits | hit;
    if (!any(hits)) return zero;
  }
  const Mask acts = wholeBatches(hits);
  if constexpr (kBouncing) {
    if (settings.first_pass) {
      Floats restitution = load<Floats>(slab.bouncing[b].restitution, kNextBouncing);
      Mask fresh = andNot(kept, hits) & less(un, splat<Floats>(-settings.bounce_speed)) &
                   less(zero, restitution) & less(zero, next_n);
      Floats approach = fresh & (restitution * (zero - un));
      if constexpr (kCohesive) {
        const Floats rest = max(h - max(gap, zero) / max(zero - un, tiny), zero);
        const Floats held = heldRebound(approach, pull * (vi.w + vj.w), reach, rest);
        approach = fresh & select(less(zero, pull), held, approach);
        fresh = less(zero, approach);
        restitution = select(fresh, approach / max(zero - un, tiny), restitution);
        grip.limit = andNot(fresh, grip.limit);
      }
      store(slab.bouncing[b].approach, kNextBouncing, approach);
      next_n = select(fresh, max(zero, old_n - mass * (un - approach)), next_n);
      noteBounces(slab, i, j, bits(fresh & less(zero, gap)), restitution, gap, normal);
    }
  }

  Part<Floats> wi = read<Floats>(body, i, kSpin), wj = read<Floats>(body, j, kSpin);
  const Floats inverse_sum = one / sum;
  const Vec lever = inverse_sum * d;  // from the contact to the centres, in radii
  const Vec turn = xi.w * wi.v + xj.w * wj.v;
  const Vec ut = u - un * normal - cross(turn, lever);
  const Floats mass_t = mass / (one + splat<Floats>(2.5f) * (inverse_sum * inverse_sum * square));
  const Vec wish = old - old_n * normal - mass_t * ut;
  Floats pressed = next_n;  // together, by whatever
  if constexpr (kCohesive) pressed = next_n + grip.limit;
  const Floats limit = wi.w * wj.w * pressed;
  const Floats scale = min(one, limit / sqrt(max(dot(wish, wish), tiny)));
  const Vec next = inBatches(acts, next_n * normal + scale * wish, old);
  const Vec change = next - old;
  store3(carried, kNextImpulse, next);
  slab.carried += static_cast<uint32_t>(std::popcount(
      bits(notEqual(next.x, zero) | notEqual(next.y, zero) | notEqual(next.z, zero))));
  vi.v = inBatches(acts, vi.v + vi.w * change, vi.v);
  vj.v = inBatches(acts, vj.v - vj.w * change, vj.v);

  const Vec twist = cross(lever, change);
  const Floats inverse_radii = splat<Floats>(2.5f) / (xi.w * xj.w);
  Vec spin_i = wi.v - vi.w * (xj.w * inverse_radii) * twist;
  Vec spin_j = wj.v - vj.w * (xi.w * inverse_radii) * twist;
  if constexpr (kRolling) {
    // Rolling resistance: a torque against the relative spin, at most mu_r r N, where r is half
    // the harmonic mean of the radii.
    RollingBatch& rolls = slab.rolling[b];
    const Floats ki = splat<Floats>(2.5f) * vi.w / (xi.w * xi.w),  // 1 / moment of inertia
        kj = splat<Floats>(2.5f) * vj.w / (xj.w * xj.w);
    const Vec old_r = load3<Floats>(rolls.impulse, kNextRolling);
    const Vec wish_r = old_r - (one / (ki + kj)) * (spin_i - spin_j);
    const Floats limit_r =
        load<Floats>(rolls.friction, kNextRolling) * pressed * (xi.w * xj.w * inverse_sum);
    const Vec next_r = inBatches(
        acts, min(one, limit_r / sqrt(max(dot(wish_r, wish_r), tiny))) * wish_r, old_r);
    const Vec change_r = next_r - old_r;
    store3(rolls.impulse, kNextRolling, next_r);
    spin_i = spin_i + ki * change_r;
    spin_j = spin_j - kj * change_r;
  }
  wi.v = inBatches(acts, spin_i, wi.v);
  wj.v = inBatches(acts, spin_j, wj.v);
  writeParts(rowsOf(body, i), kVelocity, vi, kSpin, wi);
  writeParts(rowsOf(body, j), kVelocity, vj, kSpin, wj);

  const Floats overlap = zero - gap - slop * sum;
  Floats undone = max(overlap, zero);
  if constexpr (kCohesive) {  // what hangs is drawn to touch again
    const Mask hangs = less(next_n, zero) & less(grip.impulse, grip.limit);
    undone = select(hangs, undone + min(slop * sum - gap, zero), undone);
  }
  const Mask moves = acts & notEqual(undone, zero);
  if (any(moves)) {
    const Mask move = wholeBatches(moves);
    const Vec shift = projection * undone * mass * normal;
    xi.v = inBatches(move, xi.v + vi.w * shift, xi.v);
    xj.v = inBatches(move, xj.v - vj.w * shift, xj.v);
    write(body, i, kPosition, xi);
    write(body, j, kPosition, xj);
  }
  return inBatches(acts, zero - gap, zero);
}

// relaxStep() by itself. Where it is in the loop, with two widths, registers run out: GCC 12 makes
// it a quarter slower.
template <class Floats, bool kRolling, bool kBouncing, bool kCohesive>
[[gnu::noinline]] Floats relaxApart(PairSlab& slab, uint32_t b, Body* body, const Entity* entity,
                                    const PassSettings& settings) {
  return relaxStep<Floats, kRolling, kBouncing, kCohesive>(slab, b, body, entity, settings);
}

// The processor fetches the bodies of a batch while the ones before it are worked on.
inline void fetch(const PairSlab& slab, uint32_t b, const Body* body) {
  const uint32_t *i = &slab.i[size_t{kBatch} * b], *j = &slab.j[size_t{kBatch} * b];
  for (uint32_t k = 0; k < kBatch; ++k) {
    __builtin_prefetch(body + i[k]);
    __builtin_prefetch(body + j[k]);
  }
}

template <bool kRolling, bool kBouncing, bool kCohesive>
void relaxBatches(PairSlab& slab, Body* body, const Entity* entity, const PassSettings& settings) {
  constexpr uint32_t kStep = Widest::kLanes / kBatch, kAhead = 3;  // batches
  const uint32_t batches = slab.count / kBatch;
  const uint32_t fetched = batches < kFarBatches ? 0 : batches - kAhead - kStep;
  Widest deepest = splat<Widest>(0);
  [[maybe_unused]] Float8 odd_deepest = splat<Float8>(0);
  slab.carried = 0;
  uint32_t b = 0;
  for (const uint32_t contacts : slab.colour_end) {
    const uint32_t end = (contacts + kBatch - 1) / kBatch;
    for (; b + kStep <= end; b += kStep) {
      if (b < fetched)
        for (uint32_t k = 0; k < kStep; ++k) fetch(slab, b + kAhead + k, body);
      if constexpr (kStep == 1) {
        deepest = max(deepest, relaxStep<Widest, kRolling, kBouncing, kCohesive>(
                                   slab, b, body, entity, settings));
      } else {
        deepest = max(deepest, relaxApart<Widest, kRolling, kBouncing, kCohesive>(
                                   slab, b, body, entity, settings));
      }
    }
    if constexpr (kStep > 1)
      if (b < end)
        odd_deepest = max(odd_deepest, relaxApart<Float8, kRolling, kBouncing, kCohesive>(
                                           slab, b++, body, entity, settings));
  }
  float depths[Widest::kLanes + kBatch];
  store(depths, kBatch, deepest);
  store(depths + Widest::kLanes, kBatch, odd_deepest);
  for (const float overlap : depths) slab.deepest = std::max(slab.deepest, overlap);
}

inline void applyKept(PairSlab& slab, Body* body, const PassSettings& settings) {
  using Vec = Vec3s<Float8>;
  constexpr size_t kNextImpulse = kNext<ImpulseBatch>, kNextRolling = kNext<RollingBatch>;
  const Float8 zero = splat<Float8>(0);
  const uint32_t batches = slab.count / kBatch;
  slab.bounces.clear();
  slab.deepest = 0;
  for (uint32_t b = 0; b < batches; ++b) {
    if (settings.bouncing) store(slab.bouncing[b].approach, kNext<BouncingBatch>, zero);
    float(*const carried)[kBatch] = slab.impulse[b].impulse;
    Vec impulse = load3<Float8>(carried, kNextImpulse);
    const unsigned kept = bits(notEqual(impulse.x, zero) | notEqual(impulse.y, zero) |
                               notEqual(impulse.z, zero));
    const unsigned trusted = kept & slab.trust[b];
    slab.trust[b] = static_cast<uint8_t>(kept);
    if (kept == 0) continue;
    // The impulse of an impact says nothing about the next substep: only contacts that lasted
    // longer than one keep theirs.
    if (trusted != kept) {
      const Float8::Mask mask = maskOf<Float8>(trusted);
      impulse = mask & impulse;
      store3(carried, kNextImpulse, impulse);
      if (settings.rolling) {
        float(*const rolling)[kBatch] = slab.rolling[b].impulse;
        store3(rolling, kNextRolling, mask & load3<Float8>(rolling, kNextRolling));
      }
    }
    if (trusted == 0) continue;
    const uint32_t *i = &slab.i[size_t{kBatch} * b], *j = &slab.j[size_t{kBatch} * b];
    Part<Float8> xi, xj, vi, vj;
    readParts(rowsOf(body, i), kPosition, xi, kVelocity, vi);
    readParts(rowsOf(body, j), kPosition, xj, kVelocity, vj);
    auto wi = read<Float8>(body, i, kSpin), wj = read<Float8>(body, j, kSpin);
    const Vec lever = (splat<Float8>(1) / (xi.w + xj.w)) * (xi.v - xj.v);
    const Vec moment = cross(lever, impulse);
    const Float8 inverse_radii = splat<Float8>(2.5f) / (xi.w * xj.w);
    vi.v = vi.v + vi.w * impulse;
    vj.v = vj.v - vj.w * impulse;
    wi.v = wi.v - vi.w * (xj.w * inverse_radii) * moment;
    wj.v = wj.v - vj.w * (xi.w * inverse_radii) * moment;
    if (settings.rolling) {
      const Vec rolling = load3<Float8>(slab.rolling[b].impulse, kNextRolling);
      wi.v = wi.v + (splat<Float8>(2.5f) * vi.w / (xi.w * xi.w)) * rolling;
      wj.v = wj.v - (splat<Float8>(2.5f) * vj.w / (xj.w * xj.w)) * rolling;
    }
    writeParts(rowsOf(body, i), kVelocity, vi, kSpin, wi);
    writeParts(rowsOf(body, j), kVelocity, vj, kSpin, wj);
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
