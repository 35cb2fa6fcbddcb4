// The moves of a substep, sixteen grains at a time: velocities take up gravity, places follow velocities.
// Included several times, once for each instruction set: see lanes.h.

namespace scree::grains::SCREE_LANES {

// Slots of the bodies that lie one behind the other.
inline constexpr auto kInRow = [] {
  std::array<uint32_t, kRow> slots{};
  for (uint32_t k = 0; k < kRow; ++k) slots[k] = k;
  return slots;
}();

template <class Floats>
SCREE_INLINE inline Vec3s<Floats> splat3(vec3 a) {
  return {splat<Floats>(a.x), splat<Floats>(a.y), splat<Floats>(a.z)};
}

inline constexpr unsigned kAll = (1u << Widest::kLanes) - 1;

inline bool predict(Body* body, const Reaches& listed, const float* margin, const Prediction& settings) {
  using Vec = Vec3s<Widest>;
  const Vec gravity = splat3<Widest>(settings.gravity_step), drift = splat3<Widest>(settings.drift),
            drifted = splat3<Widest>(settings.drifted);
  const Widest square_h = splat<Widest>(settings.h * settings.h);
  bool leaves = false;
  for (uint32_t k = 0; k < kRow; k += Widest::kLanes) {
    const uint32_t* const slot = &kInRow[k];
    const Part<Widest> x = read<Widest>(body, slot, kPosition);
    Part<Widest> v = read<Widest>(body, slot, kVelocity), before = read<Widest>(body, slot, kBefore);
    before.v = v.v;
    v.v = v.v + before.w * gravity;
    write(body, slot, kBefore, before);
    write(body, slot, kVelocity, v);

    const Vec strayed = x.v - Vec{load<Widest>(listed.x + k, kBatch), load<Widest>(listed.y + k, kBatch), load<Widest>(listed.z + k, kBatch)} - drifted;
    const Vec relative = v.v - drift;
    const Widest way = dot(strayed, strayed), next = square_h * dot(relative, relative),
                 most = load<Widest>(margin + k, kBatch);
    // (a + b)^2 <= 2 (a^2 + b^2): hardly any grain needs the roots.
    const auto stays = lessEqual(splat<Widest>(2.001f) * (way + next), most * most);
    if (bits(stays) == kAll) continue;
    leaves = leaves || bits(stays | lessEqual(sqrt(way) + sqrt(next), most)) != kAll;
  }
  return leaves;
}

inline uint32_t move(Body* body, const float* smooth, const Motion& settings, float (&from)[3][kRow]) {
  using Vec = Vec3s<Widest>;
  const Widest h = splat<Widest>(settings.h), keep = splat<Widest>(settings.keep), half = splat<Widest>(0.5f);
  const Widest fast = splat<Widest>(settings.fast * settings.fast),
               most_spin = splat<Widest>(settings.most_speed * settings.most_speed);
  uint32_t fast_ones = 0;
  for (uint32_t k = 0; k < kRow; k += Widest::kLanes) {
    const uint32_t* const slot = &kInRow[k];
    Part<Widest> x = read<Widest>(body, slot, kPosition), v = read<Widest>(body, slot, kVelocity),
                 w = read<Widest>(body, slot, kSpin);
    const Vec change = v.v - read<Widest>(body, slot, kBefore).v;
    store(&from[0][k], kBatch, x.v.x);
    store(&from[1][k], kBatch, x.v.y);
    store(&from[2][k], kBatch, x.v.z);
    const Widest share = lessEqual(dot(change, change), load<Widest>(smooth + k, kBatch)) & half;
    x.v = x.v + h * (v.v - share * change);
    v.v = keep * v.v;
    w.v = keep * w.v;
    const auto spins = lessEqual(dot(w.v, w.v) * x.w * x.w, most_spin);
    w.v = spins & w.v;
    write(body, slot, kPosition, x);
    write(body, slot, kVelocity, v);
    write(body, slot, kSpin, w);
    fast_ones |= (bits(lessEqual(dot(v.v, v.v), fast)) ^ kAll) << k;
  }
  return fast_ones;
}

}  // namespace scree::grains::SCREE_LANES
