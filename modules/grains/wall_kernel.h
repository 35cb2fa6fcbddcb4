// The passes over contacts of grains with colliders: what relaxContact() does to one, several at a time.
// Included several times, once for each instruction set: see lanes.h.
//
// A collider gives way to nobody, so contacts of different grains do not matter to each other. Those of one
// grain keep their order: its first contacts come into one batch, its second ones into the next.

namespace scree::grains::SCREE_LANES {

// Contacts of as many grains. Lanes that are not used work on what is nobody's.
struct WallLanes {
  ColliderContact* contact[Widest::kLanes];
  Body* body[Widest::kLanes];
  uint32_t count = 0;
};

// Parts of bodies or contacts.
template <class T>
SCREE_INLINE inline auto rowsOf(T* const* one) {
  return [=](int k) SCREE_INLINE { return reinterpret_cast<float*>(one[k]); };
}
template <class T>
SCREE_INLINE inline Part<Widest> read(T* const* one, size_t offset) {
  return readPart<Widest>(rowsOf(one), offset);
}
template <class T>
SCREE_INLINE inline void write(T* const* one, size_t offset, const Part<Widest>& part) {
  writePart(rowsOf(one), offset, part);
}

// Returns the lanes that are left to relaxContact(): what might bounce, or pass by an edge.
inline unsigned relaxWallLanes(const WallLanes& lanes, const PassSettings& settings, Widest& deepest) {
  using Mask = Widest::Mask;
  using Vec = Vec3s<Widest>;
  const Widest zero = splat<Widest>(0), one = splat<Widest>(1), tiny = splat<Widest>(1e-37f),
               inverse_h = splat<Widest>(settings.inverse_h);
  const Part<Widest> plane = read(lanes.contact, kWallPlane), ground = read(lanes.contact, kWallVelocity);
  Part<Widest> carried = read(lanes.contact, kWallImpulse);
  const Widest approach = read(lanes.contact, kWallRolling).w;
  Part<Widest> x = read(lanes.body, kPosition), v = read(lanes.body, kVelocity);
  const Vec normal = plane.v, old = carried.v;
  const Widest mass = ground.w, gap = dot(normal, x.v) - plane.w - x.w;
  const Vec u = v.v - ground.v;
  const Widest un = dot(u, normal), old_n = dot(old, normal);
  const Widest asked = select(less(zero, approach), approach, splat<Widest>(-1) * max(gap, zero) * inverse_h);
  const Widest next_n = max(old_n - mass * (un - asked), zero);
  const Mask kept = notEqual(old.x, zero) | notEqual(old.y, zero) | notEqual(old.z, zero),
             pushed = less(zero, next_n), overlaps = less(gap, zero);
  unsigned acting = bits(kept | pushed | overlaps) & ((1u << lanes.count) - 1);
  if (settings.tolerated > 0) acting &= bits(lessEqual(un - asked, splat<Widest>(-settings.tolerated)));
  if (acting == 0) return 0;

  const unsigned fresh = acting & ~bits(kept);
  unsigned special = 0;
  if (fresh != 0) {
    const Widest leap = splat<Widest>(2) * x.w * inverse_h, square = dot(u, u),
                 round = read(lanes.contact, kWallFlat).w * inverse_h;
    special = fresh & bits(less(zero, gap) & pushed & lessEqual(round * round, square) & less(square, leap * leap));
  }
  const Part<Widest> material = read(lanes.contact, kWallMaterial);
  if (settings.first_pass && fresh != 0)
    special |= fresh & bits(less(zero, material.v.z) & less(un, splat<Widest>(-settings.bounce_speed)));
  acting &= ~special;
  if (acting == 0) return special;

  const Mask acts = maskOf<Widest>(acting);
  Part<Widest> w = read(lanes.body, kSpin);
  const Part<Widest> turning = read(lanes.contact, kWallSpin);
  const Widest friction = material.v.x, rolling_friction = material.v.y, spin_factor = turning.w;
  const Vec ut = u - un * normal - x.w * cross(w.v, normal);
  const Vec wish = old - old_n * normal - mass * splat<Widest>(2.0f / 7) * ut;
  const Widest size = sqrt(max(dot(wish, wish), tiny));
  const Vec next = select(acts, next_n * normal + min(friction * next_n / size, one) * wish, old);
  const Vec change = next - old;
  v.v = select(acts, v.v + v.w * change, v.v);
  write(lanes.body, kVelocity, v);
  carried.v = next;
  write(lanes.contact, kWallImpulse, carried);

  Vec spin = w.v - spin_factor * cross(normal, change);
  const Mask rolls = acts & less(zero, rolling_friction);
  if (any(rolls)) {
    Part<Widest> rolling = read(lanes.contact, kWallRolling);
    const Widest inverse_inertia = spin_factor / x.w;
    const Vec slip = spin - turning.v;
    const Vec wish_r = rolling.v - Vec{slip.x / inverse_inertia, slip.y / inverse_inertia, slip.z / inverse_inertia};
    const Widest size_r = sqrt(max(dot(wish_r, wish_r), tiny)), limit_r = rolling_friction * x.w * next_n;
    const Vec next_r = select(rolls, min(limit_r / size_r, one) * wish_r, rolling.v);
    spin = select(rolls, spin + inverse_inertia * (next_r - rolling.v), spin);
    rolling.v = next_r;
    write(lanes.contact, kWallRolling, rolling);
  }
  w.v = select(acts, spin, w.v);
  write(lanes.body, kSpin, w);

  const Widest depth = splat<Widest>(-1) * gap;
  deepest = max(acts & depth, deepest);
  const Widest overlap = depth - splat<Widest>(kSlop) * x.w;
  const Mask moves = acts & less(zero, overlap);
  if (any(moves)) {
    x.v = select(moves, x.v + splat<Widest>(2 * kProjection) * overlap * normal, x.v);
    write(lanes.body, kPosition, x);
  }
  return special;
}

inline void relaxWalls(ColliderSlab& slab, Body* body, std::span<const PosedCollider> posed,
                       const PassSettings& settings) {
  if (settings.cohesive) {
    relaxColliders(slab, body, posed, settings);
    return;
  }
  ColliderContact no_contact;
  Body nobody;
  constexpr uint32_t kRanks = 3;  // a grain in a corner has three contacts
  WallLanes rank[kRanks];
  Widest deepest = splat<Widest>(0);
  const auto relax = [&](uint32_t last_rank) {
    for (uint32_t r = 0; r <= last_rank; ++r) {
      WallLanes& lanes = rank[r];
      if (lanes.count == 0) continue;
      for (uint32_t k = lanes.count; k < Widest::kLanes; ++k) {
        lanes.contact[k] = &no_contact;
        lanes.body[k] = &nobody;
      }
      for (unsigned left = relaxWallLanes(lanes, settings, deepest); left != 0; left &= left - 1) {
        const int k = std::countr_zero(left);
        relaxContact(slab, *lanes.contact[k], *lanes.body[k], posed, settings);
      }
      lanes.count = 0;
    }
  };
  uint32_t grain = kNoSlot, r = 0;
  for (ColliderContact& contact : slab.contact) {
    if (contact.gives) continue;
    r = contact.grain == grain ? r + 1 : 0;
    if (r == kRanks) {
      relax(kRanks - 1);
      r = 0;
    }
    grain = contact.grain;
    WallLanes& lanes = rank[r];
    lanes.contact[lanes.count] = &contact;
    lanes.body[lanes.count++] = &body[grain];
    if (lanes.count == Widest::kLanes) relax(r);
  }
  relax(kRanks - 1);
  float depths[Widest::kLanes];
  store(depths, kBatch, deepest);
  for (const float depth : depths) slab.deepest = std::max(slab.deepest, depth);
}

}  // namespace scree::grains::SCREE_LANES
