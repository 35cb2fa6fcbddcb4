// The distance tests of the neighbour search, eight grains at a time. Included several times, once
// for each instruction set: see lanes.h.

namespace scree::grains::SCREE_LANES {

inline uint32_t scan(const Reaches& grains, uint32_t slot, const SlotRange* range,
                     uint32_t range_count, uint32_t* hits) {
  using namespace simd::SCREE_LANES;
  const Float8 px = splat<Float8>(grains.x[slot]), py = splat<Float8>(grains.y[slot]),
               pz = splat<Float8>(grains.z[slot]);
  const Float8 radius = splat<Float8>(grains.radius[slot]), reach = splat<Float8>(grains.reach[slot]);
  uint32_t count = 0;
  for (const SlotRange* end_of_ranges = range + range_count; range != end_of_ranges; ++range) {
    for (uint32_t k = range->begin; k < range->end; k += kMostLanes) {
      const Float8 dx = load<Float8>(grains.x + k) - px, dy = load<Float8>(grains.y + k) - py,
                   dz = load<Float8>(grains.z + k) - pz;
      const Float8 square = dx * dx + dy * dy + dz * dz;
      const Float8 sum = load<Float8>(grains.reach + k) + reach;
      unsigned within = bits(less(square, sum * sum));
      if (range->end - k < kMostLanes) within &= (1u << (range->end - k)) - 1;
      if (within == 0) continue;
      const Float8 near = splat<Float8>(kNearlyTouching) * (load<Float8>(grains.radius + k) + radius);
      count += pack(k, less(square, near * near), within, hits + count);
    }
  }
  return count;
}

}  // namespace scree::grains::SCREE_LANES
