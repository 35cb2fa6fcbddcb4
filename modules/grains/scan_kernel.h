// The distance tests of the neighbour search, eight grains at a time. Included several times, once
// for each instruction set: see lanes8.h.

namespace scree::grains::SCREE_LANES {

inline uint32_t scan(const Reaches& grains, uint32_t slot, uint32_t begin, uint32_t end,
                     uint32_t* hits) {
  using namespace simd::SCREE_LANES;
  const Float8 px = splat(grains.x[slot]), py = splat(grains.y[slot]), pz = splat(grains.z[slot]);
  const Float8 reach = splat(grains.reach[slot]);
  uint32_t count = 0;
  for (uint32_t k = begin; k < end; k += kMostLanes) {
    const Float8 dx = load(grains.x + k) - px, dy = load(grains.y + k) - py,
                 dz = load(grains.z + k) - pz;
    const Float8 sum = load(grains.reach + k) + reach;
    unsigned within = bits(less(dx * dx + dy * dy + dz * dz, sum * sum));
    if (end - k < kMostLanes) within &= (1u << (end - k)) - 1;
    for (; within != 0; within &= within - 1)
      hits[count++] = k + static_cast<uint32_t>(std::countr_zero(within));
  }
  return count;
}

}  // namespace scree::grains::SCREE_LANES
