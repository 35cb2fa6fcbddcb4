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

template <class T>
std::span<T> makeRoom(Room<T>& room, size_t n, Contents contents) {
  return contents == Contents::Keep ? room.extend(n) : room.remake(n);
}

}  // namespace

PairLists::PairLists(const PairLists& other) : PairArrays(other) {
  layOut(Contents::Keep);
  layOutImpulses(Contents::Keep);
}

void PairLists::build(const Grid& grid, const Bodies& bodies, const PairLists& old,
                      std::span<const uint32_t> before, std::span<const JoiningPair> joining,
                      Workspace& workspace) {
  keep(old, before, joining, workspace);
  slab_count = grid.slabCount();
  if (slab.size() < slab_count) slab.resize(slab_count);
  listed_ = bodies.count;
  rolling = bouncing = cohesive = false;
  for (uint32_t k = 0; k < bodies.count; ++k) {
    const GrainMaterial& material = bodies.materialOf(k);
    rolling = rolling || material.rolling_friction > 0;
    bouncing = bouncing || material.restitution > 0;
    cohesive = cohesive || material.cohesion > 0;
  }
  rolling = rolling || bouncing || cohesive;
  found_end_ = workspace.take<uint32_t>(bodies.count);
  find(grid, bodies);
  uint64_t colours = 0;
  for (uint32_t s = 0; s < slab_count; ++s) {
    slab[s].colour_begin = colours;
    colours += slab[s].found_count - slab[s].found_below + slab[grid.slabAbove(s)].found_below;
  }
  const Worth worth = worthOf(bodies.count, kFewGrains);
  const auto eachSlab = [&](const auto& visit) {
    parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) { visit(static_cast<uint32_t>(s)); }, worth);
  };
  eachSlab([&](uint32_t s) { colour(grid, s); });
  layOut(Contents::Drop);
  eachSlab([&](uint32_t s) { place(grid, bodies, s); });
  layOutImpulses(Contents::Drop);
  eachSlab([&](uint32_t s) { fill(s, bodies); });
}

// Shares an array out among the slabs, `a_batch` of it for each of their batches.
template <class T>
void PairLists::share(std::span<T> all, std::span<T> PairSlab::* part, uint32_t a_batch) {
  size_t begin = 0;
  for (uint32_t s = 0; s < slab_count; ++s) {
    const size_t n = slab[s].count / kBatch * a_batch;
    slab[s].*part = all.empty() ? all : all.subspan(begin, n);
    begin += n;
  }
}

void PairLists::layOut(Contents contents) {
  size_t lanes = 0;
  for (uint32_t s = 0; s < slab_count; ++s) lanes += slab[s].count;
  share(makeRoom(i_, lanes, contents), &PairSlab::i, kBatch);
  share(makeRoom(j_, lanes, contents), &PairSlab::j, kBatch);
}

void PairLists::layOutImpulses(Contents contents) {
  const size_t batches = i_.size() / kBatch;
  makeRoom(impulse_, batches * sizeof(ImpulseBatch), contents);
  share(std::span(reinterpret_cast<ImpulseBatch*>(impulse_.data()), batches), &PairSlab::impulse, 1);
  share(makeRoom(trust_, batches, contents), &PairSlab::trust, 1);
  share(makeRoom(rolling_, rolling ? batches : 0, contents), &PairSlab::rolling, 1);
  share(makeRoom(bouncing_, bouncing ? batches : 0, contents), &PairSlab::bouncing, 1);
  share(makeRoom(cohesion_, cohesive ? batches : 0, contents), &PairSlab::cohesion, 1);
}

// Lists the impulses of `old` by the slots of now. The order within a grain's list may vary with
// the threads; nothing depends on it.
void PairLists::keep(const PairLists& old, std::span<const uint32_t> before,
                     std::span<const JoiningPair> joining, Workspace& workspace) {
  const uint32_t n = static_cast<uint32_t>(before.size());
  kept_ = {};
  if (old.slab_count == 0 && joining.empty()) return;
  kept_.begin = workspace.take<uint32_t>(n, 0);
  const std::span<uint32_t> slot_now = workspace.take<uint32_t>(old.listed_, kNoSlot);
  for (uint32_t k = 0; k < n; ++k)
    if (before[k] != kNoSlot) slot_now[before[k]] = k;

  const Worth worth = worthOf(n, kFewGrains);
  const auto eachContact = [&](const auto& visit) {
    parallelChunks(old.slab_count, 1, [&](size_t s, size_t, size_t) {
      const PairSlab& from = old.slab[s];
      for (uint32_t c = 0; c < from.count; ++c) {
        if (from.i[c] >= slot_now.size() || !from.carriesImpulse(c)) continue;
        const uint32_t i = slot_now[from.i[c]], j = slot_now[from.j[c]];
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
  kept_.contact = workspace.take<KeptPairs::Contact>(total);
  kept_.rolling = workspace.take<vec3>(old.rolling || !joining.empty() ? total : 0, vec3(0));
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

// Each slab's pairs are found into a list of the thread, and then moved behind those of slabs that were
// found earlier. Where there is no room any more, it is made, and the slabs that are left are searched again.
void PairLists::find(const Grid& grid, const Bodies& bodies) {
  const Worth worth = worthOf(bodies.count, kFewGrains);
  size_t most = 0;  // grains of two slabs
  for (uint32_t s = 0; s < slab_count; ++s) {
    const uint32_t above = grid.slabAbove(s);
    most = std::max<size_t>(most, grid.slabEnd(s) - grid.slabBegin(s) + grid.slabEnd(above) - grid.slabBegin(above));
  }
  scratch_.resize(static_cast<size_t>(threadCount()));
  for (Scratch& scratch : scratch_) {
    scratch.taken.remake(most);
    scratch.found.clear();
    fitTo(scratch.found, most_found_);
  }

  std::atomic<uint64_t> found_so_far = 0;
  impulse_.extend(impulse_.capacity());
  const uint64_t room = impulse_.size() / (2 * sizeof(uint32_t));  // beside the colours
  const auto copy = [&](const PairSlab& own, const std::vector<uint32_t>& pairs) {
    std::copy(pairs.begin(), pairs.end(), found() + own.found_begin);
  };
  parallelChunks(slab_count, 1, [&](size_t k, size_t, size_t) {
    std::vector<uint32_t>& pairs = scratch_[threadIndex()].found;
    PairSlab& own = slab[k];
    findOf(grid, bodies, static_cast<uint32_t>(k), pairs);
    own.found_count = static_cast<uint32_t>(pairs.size());
    own.found_begin = found_so_far.fetch_add(own.found_count, std::memory_order_relaxed);
    if (own.found_begin + own.found_count <= room) copy(own, pairs);
  }, worth);
  pair_count = found_so_far;
  most_found_ = 0;
  for (uint32_t s = 0; s < slab_count; ++s) most_found_ = std::max<size_t>(most_found_, slab[s].found_count);
  impulse_.extend(2 * sizeof(uint32_t) * pair_count);
  if (pair_count <= room) return;
  parallelChunks(slab_count, 1, [&](size_t k, size_t, size_t) {
    const PairSlab& own = slab[k];
    if (own.found_begin + own.found_count <= room) return;
    std::vector<uint32_t>& pairs = scratch_[threadIndex()].found;
    findOf(grid, bodies, static_cast<uint32_t>(k), pairs);
    copy(own, pairs);
  }, worth);
}

void PairLists::findOf(const Grid& grid, const Bodies& bodies, uint32_t s, std::vector<uint32_t>& found) {
  found.clear();
  const uint32_t below = (s + slab_count - 1) & (slab_count - 1);
  const uint32_t below_begin = grid.slabBegin(below), below_count = grid.slabEnd(below) - below_begin;
  PairSlab& own = slab[s];
  own.found_below = 0;
  for (uint32_t i = grid.slabBegin(s); i < grid.slabEnd(s); ++i) {
    const auto before = static_cast<std::ptrdiff_t>(found.size());
    grid.neighbours(i, found);
    if (!isAwake(bodies, i))
      found.erase(std::remove_if(found.begin() + before, found.end(),
                                 [&](uint32_t j) { return !isAwake(bodies, slotOf(j)); }),
                  found.end());
    if (!bodies.clump.empty() && bodies.clump[i] != kNoSlot)
      found.erase(std::remove_if(found.begin() + before, found.end(),
                                 [&](uint32_t j) { return bodies.clump[slotOf(j)] == bodies.clump[i]; }),
                  found.end());
    found_end_[i] = static_cast<uint32_t>(found.size());
    if (!grid.mixed()) continue;
    for (size_t k = static_cast<size_t>(before); k < found.size(); ++k)
      own.found_below += slotOf(found[k]) - below_begin < below_count;
  }
}

// Calls visit(k, i, found j) for all pairs of the slab, numbered in order: those that its grains find, and
// those with its grains that are found from above.
template <class Visit>
void PairLists::eachPair(const Grid& grid, uint32_t s, const Visit& visit) {
  const auto eachFound = [&](uint32_t by, uint32_t in, const auto& pair) {
    const uint32_t begin = grid.slabBegin(in), count = grid.slabEnd(in) - begin;
    const uint32_t* pairs = found() + slab[by].found_begin;
    uint32_t at = 0;
    for (uint32_t i = grid.slabBegin(by); i < grid.slabEnd(by); ++i)
      for (; at < found_end_[i]; ++at) pair(i, pairs[at], slotOf(pairs[at]) - begin < count);
  };
  uint32_t k = 0;
  if (!grid.mixed()) {
    eachFound(s, s, [&](uint32_t i, uint32_t j, bool) { visit(k++, i, j); });
    return;
  }
  eachFound(s, (s + slab_count - 1) & (slab_count - 1), [&](uint32_t i, uint32_t j, bool below) {
    if (!below) visit(k++, i, j);
  });
  eachFound(grid.slabAbove(s), s, [&](uint32_t i, uint32_t j, bool here) {
    if (here) visit(k++, i, j);
  });
}

// Greedy colouring: a contact gets the lowest colour that neither of its grains has; contacts of a
// colour are disjoint. Grains with more than 32 contacts take part in several rounds.
void PairLists::colour(const Grid& grid, uint32_t s) {
  PairSlab& own = slab[s];
  const uint32_t begin = grid.slabBegin(s), above = grid.slabAbove(s);
  const size_t grains = grid.slabEnd(s) - begin + grid.slabEnd(above) - grid.slabBegin(above);
  const std::span<uint64_t> masks = scratch_[threadIndex()].taken.all().first(grains);
  // The slab above the last one is the first.
  const auto taken = [&](uint32_t slot) -> uint64_t& {
    return masks[slot >= begin ? slot - begin : slot + (listed_ - begin)];
  };
  // A round has colours 0 to 31 for pairs that touch and 32 to 63 for the rest: whole batches of
  // which nothing comes cost little.
  constexpr uint32_t kWaits = 0xffffffffu;
  uint32_t* const colour = colours() + own.colour_begin;
  own.colour_end.clear();
  uint32_t waiting = 1;
  for (uint32_t round = 0; waiting > 0; ++round) {
    std::ranges::fill(masks, 0);
    waiting = 0;
    own.colour_end.resize(64 * (round + 1), 0);
    eachPair(grid, s, [&](uint32_t k, uint32_t i, uint32_t found) {
      if (round > 0 && colour[k] != kWaits) return;
      const uint32_t j = slotOf(found);
      const int side = found != j ? 0 : 32;
      uint64_t &taken_i = taken(i), &taken_j = taken(j);
      const uint32_t free = static_cast<uint32_t>(~(taken_i | taken_j) >> side);
      if (free == 0) {
        colour[k] = kWaits;
        ++waiting;
        return;
      }
      const uint32_t lowest = static_cast<uint32_t>(std::countr_zero(free) + side);
      taken_i |= uint64_t{1} << lowest;
      taken_j |= uint64_t{1} << lowest;
      colour[k] = 64 * round + lowest;
      ++own.colour_end[colour[k]];  // counts first; ends after the sums below
    });
  }
  uint32_t end = 0;
  for (uint32_t& n : own.colour_end) {
    const uint32_t first = end;
    end += (n + kBatch - 1) & ~(kBatch - 1);
    n = first;
  }
  own.count = end;
}

void PairLists::place(const Grid& grid, const Bodies& bodies, uint32_t s) {
  PairSlab& own = slab[s];
  const uint32_t* const colour = colours() + own.colour_begin;
  own.border.clear();
  fillIdle(s);
  eachPair(grid, s, [&](uint32_t k, uint32_t i, uint32_t found) {
    const uint32_t j = slotOf(found);
    const uint32_t contact = own.colour_end[colour[k]]++;
    if (!isAwake(bodies, i) || !isAwake(bodies, j)) append(own.border, contact);
    own.i[contact] = i;
    own.j[contact] = j;
  });
  fitTo(own.border, own.border.size());
}

void PairLists::fillIdle(uint32_t s) {
  PairSlab& own = slab[s];
  const uint32_t idle = listed_ + s * kIdleBodies;
  for (uint32_t k = 0; k < own.count; ++k) {
    own.i[k] = idle + k % kBatch;
    own.j[k] = idle + kBatch + k % kBatch;
  }
}

void PairLists::mixMaterials(PairSlab& own, uint32_t contact, const Bodies& bodies) const {
  const uint32_t b = contact / kBatch, lane = contact % kBatch;
  const GrainMaterial &i = bodies.materialOf(own.i[contact]), &j = bodies.materialOf(own.j[contact]);
  if (rolling) own.rolling[b].friction[lane] = std::max(i.rolling_friction, j.rolling_friction);
  if (bouncing) own.bouncing[b].restitution[lane] = std::max(i.restitution, j.restitution);
  if (cohesive) {
    const float reduced =
        reducedRadius(bodies.body[own.i[contact]].radius, bodies.body[own.j[contact]].radius);
    own.cohesion[b].pull[lane] = pullOf(i.cohesion, j.cohesion, reduced);
  }
}

void PairLists::clearLanes(PairSlab& own) {
  std::ranges::fill(own.impulse, ImpulseBatch{});
  std::ranges::fill(own.trust, uint8_t{0});
  std::ranges::fill(own.rolling, RollingBatch{});
  std::ranges::fill(own.bouncing, BouncingBatch{});
  std::ranges::fill(own.cohesion, CohesionBatch{});
  own.bounces.clear();
}

void PairLists::fill(uint32_t s, const Bodies& bodies) {
  PairSlab& own = slab[s];
  clearLanes(own);
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
  size_t bytes = i_.memoryBytes() + j_.memoryBytes() + impulse_.memoryBytes() +
                 trust_.memoryBytes() + rolling_.memoryBytes() + bouncing_.memoryBytes() +
                 cohesion_.memoryBytes() + slab.capacity() * sizeof(PairSlab);
  for (const Scratch& scratch : scratch_) bytes += 4 * scratch.found.capacity() + scratch.taken.memoryBytes();
  for (const PairSlab& s : slab)
    bytes += 4 * (s.colour_end.capacity() + s.border.capacity()) + sizeof(Bounce) * s.bounces.capacity();
  return bytes;
}

}  // namespace scree::grains
