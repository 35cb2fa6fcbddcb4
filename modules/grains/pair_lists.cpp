// Building the pair lists: search, batches of disjoint pairs, impulses taken over from the old lists.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>

#include "engine/core/parallel.h"
#include "modules/grains/cohesion.h"
#include "modules/grains/contacts.h"

namespace scree::grains {
namespace {

// Of a grain in a slab's found_j.
uint32_t slotOf(uint32_t found) { return found & ~kNearBit; }

}  // namespace

void PairLists::build(const Grid& grid, const Bodies& bodies, const PairLists& old,
                      std::span<const uint32_t> before, std::span<const JoiningPair> joining) {
  keep(old, before, joining);
  slab_count = grid.slabCount();
  if (slab.size() < slab_count) slab.resize(slab_count);
  remake(slab_of, bodies.count);
  remake(found_end, bodies.count);
  remake(mask[0], bodies.count);
  remake(mask[1], bodies.count);
  rolling = bouncing = cohesive = false;
  for (const GrainMaterial& material : std::span(bodies.material).first(bodies.count)) {
    rolling = rolling || material.rolling_friction > 0;
    bouncing = bouncing || material.restitution > 0;
    cohesive = cohesive || material.cohesion > 0;
  }
  rolling = rolling || bouncing || cohesive;
  const Worth worth = worthOf(bodies.count, kFewGrains);
  parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) { find(grid, bodies, uint32_t(s)); },
                 worth);
  parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) {
    batch(grid, bodies, uint32_t(s));
    fill(uint32_t(s), bodies);
  }, worth);
  pair_count = 0;
  for (uint32_t s = 0; s < slab_count; ++s) pair_count += slab[s].found_j.size();
}

// Lists the impulses of `old` by the slots of now. The order within a grain's list may vary with
// the threads; nothing depends on it.
void PairLists::keep(const PairLists& old, std::span<const uint32_t> before,
                     std::span<const JoiningPair> joining) {
  const uint32_t n = static_cast<uint32_t>(before.size());
  refill(kept_.begin, n, 0u);
  kept_.contact.clear();
  kept_.rolling.clear();
  if (old.slab_count == 0 && joining.empty()) return;
  refill(slot_now_, old.slab_of.size(), kNoSlot);
  for (uint32_t k = 0; k < n; ++k)
    if (before[k] != kNoSlot) slot_now_[before[k]] = k;

  const Worth worth = worthOf(n, kFewGrains);
  const auto eachContact = [&](const auto& visit) {
    parallelChunks(old.slab_count, 1, [&](size_t s, size_t, size_t) {
      const PairSlab& from = old.slab[s];
      for (uint32_t c = 0; c < from.count; ++c) {
        if (from.i[c] >= slot_now_.size() || !from.carriesImpulse(c)) continue;
        const uint32_t i = slot_now_[from.i[c]], j = slot_now_[from.j[c]];
        if (i != kNoSlot && j != kNoSlot) visit(from, c, i, j);
      }
    }, worth);
  };
  const bool alone = threadCount() == 1 || worth == Worth::OneThread;
  const auto next = [&](uint32_t slot) {
    uint32_t& counter = kept_.begin[slot];
    return alone ? counter++ : std::atomic_ref(counter).fetch_add(1, std::memory_order_relaxed);
  };
  eachContact([&](const PairSlab&, uint32_t, uint32_t i, uint32_t j) { next(std::min(i, j)); });
  for (const JoiningPair& pair : joining) next(std::min(pair.i, pair.j));
  uint32_t total = 0;
  for (uint32_t& begin : kept_.begin) {
    const uint32_t count = begin;
    begin = total;
    total += count;
  }
  remake(kept_.contact, total);
  if (old.rolling || !joining.empty()) refill(kept_.rolling, total, vec3(0));
  eachContact([&](const PairSlab& from, uint32_t c, uint32_t i, uint32_t j) {
    const uint32_t at = next(std::min(i, j)), b = c / kBatch, lane = c % kBatch;
    const float sign = i < j ? 1.0f : -1.0f;
    const auto signedAt = [&](const float(&p)[3][kBatch]) {
      return sign * vec3(p[0][lane], p[1][lane], p[2][lane]);
    };
    const bool trusted = (from.trust[b] >> lane & 1) != 0;
    kept_.contact[at] = {std::max(i, j) | (trusted ? KeptPairs::kTrusted : 0),
                         signedAt(from.impulse[b].impulse)};
    if (old.rolling) kept_.rolling[at] = signedAt(from.rolling[b].impulse);
  });
  for (const JoiningPair& pair : joining) {
    const uint32_t at = next(std::min(pair.i, pair.j));
    const float sign = pair.i < pair.j ? 1.0f : -1.0f;
    kept_.contact[at] = {std::max(pair.i, pair.j) | KeptPairs::kTrusted, sign * pair.impulse};
    if (!kept_.rolling.empty()) kept_.rolling[at] = sign * pair.rolling;
  }
}

void PairLists::find(const Grid& grid, const Bodies& bodies, uint32_t s) {
  PairSlab& own = slab[s];
  own.found_j.clear();
  for (uint32_t i = grid.slabBegin(s); i < grid.slabEnd(s); ++i) {
    slab_of[i] = s;
    const auto before = static_cast<std::ptrdiff_t>(own.found_j.size());
    grid.neighbours(i, own.found_j);
    if (!isAwake(bodies, i))
      own.found_j.erase(std::remove_if(own.found_j.begin() + before, own.found_j.end(),
                                       [&](uint32_t j) { return !isAwake(bodies, slotOf(j)); }),
                        own.found_j.end());
    if (!bodies.clump.empty() && bodies.clump[i] != kNoSlot)
      own.found_j.erase(std::remove_if(own.found_j.begin() + before, own.found_j.end(),
                                       [&](uint32_t j) { return bodies.clump[slotOf(j)] == bodies.clump[i]; }),
                        own.found_j.end());
    found_end[i] = static_cast<uint32_t>(own.found_j.size());
  }
}

// Greedy colouring: a contact gets the lowest colour that neither of its grains has; contacts of a
// colour are disjoint. Grains with more than 32 contacts take part in several rounds.
void PairLists::batch(const Grid& grid, const Bodies& bodies, uint32_t s) {
  PairSlab& own = slab[s];
  const uint32_t above = grid.slabAbove(s), below = (s + slab_count - 1) & (slab_count - 1);
  std::vector<uint64_t>& taken = mask[s & 1];
  const auto clear = [&] {
    std::fill(taken.begin() + grid.slabBegin(s), taken.begin() + grid.slabEnd(s), 0);
    std::fill(taken.begin() + grid.slabBegin(above), taken.begin() + grid.slabEnd(above), 0);
  };
  own.foreign.clear();
  if (grid.mixed()) {
    uint32_t k = 0;
    for (uint32_t i = grid.slabBegin(above); i < grid.slabEnd(above); ++i)
      for (; k < found_end[i]; ++k)
        if (slab_of[slotOf(slab[above].found_j[k])] == s)
          own.foreign.emplace_back(i, slab[above].found_j[k]);
  }
  // Calls visit(k, i, found j) for all pairs of this slab, numbered in order.
  const auto eachPair = [&](const auto& visit) {
    uint32_t k = 0, at = 0;
    for (uint32_t i = grid.slabBegin(s); i < grid.slabEnd(s); ++i)
      for (; at < found_end[i]; ++at)
        if (!grid.mixed() || slab_of[slotOf(own.found_j[at])] != below)
          visit(k++, i, own.found_j[at]);
    for (const auto& [i, j] : own.foreign) visit(k++, i, j);
    return k;
  };
  // A round has colours 0 to 31 for pairs that touch and 32 to 63 for the rest: whole batches of
  // which nothing comes cost little.
  constexpr uint32_t kWaits = 0xffffffffu;
  remake(own.colour, own.found_j.size() + own.foreign.size());
  own.colour_count.clear();
  uint32_t waiting = 1;
  for (uint32_t round = 0; waiting > 0; ++round) {
    clear();
    waiting = 0;
    own.colour_count.resize(64 * (round + 1), 0);
    eachPair([&](uint32_t k, uint32_t i, uint32_t found) {
      if (round > 0 && own.colour[k] != kWaits) return;
      const uint32_t j = slotOf(found);
      const int side = found != j ? 0 : 32;
      const uint32_t free = static_cast<uint32_t>(~(taken[i] | taken[j]) >> side);
      if (free == 0) {
        own.colour[k] = kWaits;
        ++waiting;
        return;
      }
      const uint32_t colour = static_cast<uint32_t>(std::countr_zero(free) + side);
      taken[i] |= uint64_t{1} << colour;
      taken[j] |= uint64_t{1} << colour;
      own.colour[k] = 64 * round + colour;
      ++own.colour_count[own.colour[k]];
    });
  }
  uint32_t end = 0;
  for (uint32_t& n : own.colour_count) {
    const uint32_t begin = end;
    end += (n + kBatch - 1) & ~(kBatch - 1);
    n = begin;
  }
  own.count = end;
  own.border.clear();
  fillIdle(s);
  eachPair([&](uint32_t k, uint32_t i, uint32_t found) {
    const uint32_t j = slotOf(found);
    const uint32_t contact = own.colour_count[own.colour[k]]++;
    if (!isAwake(bodies, i) || !isAwake(bodies, j)) own.border.push_back(contact);
    own.i[contact] = i;
    own.j[contact] = j;
  });
}

void PairLists::fillIdle(uint32_t s) {
  PairSlab& own = slab[s];
  remake(own.i, own.count);
  remake(own.j, own.count);
  const uint32_t idle = static_cast<uint32_t>(slab_of.size()) + s * kIdleBodies;
  for (uint32_t k = 0; k < own.count; ++k) {
    own.i[k] = idle + k % kBatch;
    own.j[k] = idle + kBatch + k % kBatch;
  }
}

void PairLists::mixMaterials(PairSlab& own, uint32_t contact, const Bodies& bodies) const {
  const uint32_t b = contact / kBatch, lane = contact % kBatch;
  const GrainMaterial &i = bodies.material[own.i[contact]], &j = bodies.material[own.j[contact]];
  if (rolling) own.rolling[b].friction[lane] = std::max(i.rolling_friction, j.rolling_friction);
  if (bouncing) own.bouncing[b].restitution[lane] = std::max(i.restitution, j.restitution);
  if (cohesive) {
    const float reduced =
        reducedRadius(bodies.body[own.i[contact]].radius, bodies.body[own.j[contact]].radius);
    own.cohesion[b].pull[lane] = pullOf(i.cohesion, j.cohesion, reduced);
  }
}

void PairLists::fill(uint32_t s, const Bodies& bodies) {
  PairSlab& own = slab[s];
  const size_t batches = own.count / kBatch;
  refill(own.impulse, batches, ImpulseBatch{});
  refill(own.trust, batches, uint8_t{0});
  refill(own.rolling, rolling ? batches : 0, RollingBatch{});
  refill(own.bouncing, bouncing ? batches : 0, BouncingBatch{});
  refill(own.cohesion, cohesive ? batches : 0, CohesionBatch{});
  own.bounces.clear();
  for (uint32_t c = 0; c < own.count; ++c) {
    const uint32_t i = own.i[c], j = own.j[c], b = c / kBatch, lane = c % kBatch;
    if (i >= bodies.count) continue;
    mixMaterials(own, c, bodies);
    if (kept_.contact.empty()) continue;
    const uint32_t low = std::min(i, j), high = std::max(i, j);
    const float sign = i < j ? 1.0f : -1.0f;
    for (uint32_t k = low > 0 ? kept_.begin[low - 1] : 0; k < kept_.begin[low]; ++k) {
      const KeptPairs::Contact& kept = kept_.contact[k];
      if ((kept.other & ~KeptPairs::kTrusted) != high) continue;
      for (int axis = 0; axis < 3; ++axis)
        own.impulse[b].impulse[axis][lane] = sign * kept.impulse[axis];
      if (rolling && !kept_.rolling.empty())
        for (int axis = 0; axis < 3; ++axis)
          own.rolling[b].impulse[axis][lane] = sign * kept_.rolling[k][axis];
      if ((kept.other & KeptPairs::kTrusted) != 0)
        own.trust[b] = static_cast<uint8_t>(own.trust[b] | 1u << lane);
      break;
    }
  }
}

size_t PairLists::memoryBytes() const {
  size_t bytes = 4 * (slab_of.capacity() + found_end.capacity() + slot_now_.capacity() +
                      kept_.begin.capacity()) +
                 8 * (mask[0].capacity() + mask[1].capacity()) +
                 sizeof(KeptPairs::Contact) * kept_.contact.capacity() +
                 sizeof(vec3) * kept_.rolling.capacity();
  for (const PairSlab& s : slab)
    bytes += 4 * (s.found_j.capacity() + s.i.capacity() + s.j.capacity() +
                  s.colour_count.capacity() + s.colour.capacity()) +
             sizeof(s.foreign[0]) * s.foreign.capacity() + 4 * s.border.capacity() +
             sizeof(ImpulseBatch) * s.impulse.capacity() + s.trust.capacity() +
             sizeof(RollingBatch) * s.rolling.capacity() +
             sizeof(BouncingBatch) * s.bouncing.capacity() +
             sizeof(CohesionBatch) * s.cohesion.capacity() + sizeof(Bounce) * s.bounces.capacity();
  return bytes;
}

}  // namespace scree::grains
