// Building the pair lists: search, batches of disjoint pairs, impulses taken over from the old lists.
#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/core/parallel.h"
#include "modules/grains/contacts.h"

namespace scree::grains {
namespace {

uint32_t laneCount(bool rolling, bool bouncing) {
  if (bouncing) return static_cast<uint32_t>(Lane::Count);
  return static_cast<uint32_t>(rolling ? Lane::LastRolling : Lane::LastPlain) + 1;
}

}  // namespace

void PairLists::build(const Grid& grid, const Bodies& bodies, const PairLists& old,
                      std::span<const uint32_t> order, std::span<const uint32_t> history) {
  slab_count = grid.slabCount();
  if (slab.size() < slab_count) slab.resize(slab_count);
  slab_of.resize(bodies.count);
  found_begin.resize(bodies.count);
  found_end.resize(bodies.count);
  mask[0].resize(bodies.count);
  mask[1].resize(bodies.count);
  rolling = bouncing = false;
  for (const GrainMaterial& material : std::span(bodies.material).first(bodies.count)) {
    rolling = rolling || material.rolling_friction > 0;
    bouncing = bouncing || material.restitution > 0;
  }
  parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) { find(grid, uint32_t(s)); });
  parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) {
    batch(grid, uint32_t(s));
    fill(uint32_t(s), bodies, old, order, history);
  });
  pair_count = 0;
  for (uint32_t s = 0; s < slab_count; ++s) pair_count += slab[s].found_j.size();
}

void PairLists::find(const Grid& grid, uint32_t s) {
  PairSlab& own = slab[s];
  own.found_i.clear();
  own.found_j.clear();
  own.found_below = 0;
  for (uint32_t i = grid.slabBegin(s); i < grid.slabEnd(s); ++i) {
    slab_of[i] = s;
    found_begin[i] = static_cast<uint32_t>(own.found_j.size());
    grid.neighbours(i, own.found_j);
    found_end[i] = static_cast<uint32_t>(own.found_j.size());
    own.found_i.resize(own.found_j.size(), i);
  }
  refill(own.found_at, own.found_j.size(), kNoSlot);
}

// Greedy colouring: a contact gets the lowest colour that neither of its grains has; contacts of a
// colour are disjoint. Grains with more than 64 contacts take part in several rounds.
void PairLists::batch(const Grid& grid, uint32_t s) {
  PairSlab& own = slab[s];
  const uint32_t above = grid.slabAbove(s), below = (s + slab_count - 1) & (slab_count - 1);
  std::vector<uint64_t>& taken = mask[s & 1];
  const auto clear = [&] {
    std::fill(taken.begin() + grid.slabBegin(s), taken.begin() + grid.slabEnd(s), 0);
    std::fill(taken.begin() + grid.slabBegin(above), taken.begin() + grid.slabEnd(above), 0);
  };
  // Bit 31 of a pending contact: found by the slab above.
  constexpr uint32_t kAbove = 0x80000000u;
  own.pending.clear();
  for (uint32_t k = 0; k < own.found_j.size(); ++k)
    if (!grid.mixed() || slab_of[own.found_j[k]] != below) own.pending.push_back(k);
  if (grid.mixed()) {
    const PairSlab& upper = slab[above];
    for (uint32_t k = 0; k < upper.found_j.size(); ++k)
      if (slab_of[upper.found_j[k]] == s) own.pending.push_back(k | kAbove);
  }
  remake(own.colour, own.pending.size());
  own.colour_count.clear();
  const uint32_t total = static_cast<uint32_t>(own.pending.size());
  // Contacts in order of their colours; `again` holds those that wait for the next round.
  uint32_t round = 0;
  std::vector<uint32_t>& waiting = own.again;
  remake(waiting, total);
  for (uint32_t k = 0; k < total; ++k) waiting[k] = k;
  while (!waiting.empty()) {
    clear();
    own.colour_count.resize(64 * (round + 1), 0);
    size_t left = 0;
    for (const uint32_t k : waiting) {
      const PairSlab& finder = (own.pending[k] & kAbove) != 0 ? slab[above] : own;
      const uint32_t at = own.pending[k] & ~kAbove;
      uint64_t& a = taken[finder.found_i[at]];
      uint64_t& b = taken[finder.found_j[at]];
      if ((a | b) == ~uint64_t{0}) {
        waiting[left++] = k;
        continue;
      }
      const uint32_t colour = static_cast<uint32_t>(std::countr_one(a | b));
      a |= uint64_t{1} << colour;
      b |= uint64_t{1} << colour;
      own.colour[k] = 64 * round + colour;
      ++own.colour_count[own.colour[k]];
    }
    waiting.resize(left);
    ++round;
  }
  uint32_t end = 0;
  for (uint32_t& n : own.colour_count) {
    const uint32_t begin = end;
    end += (n + 3) & ~3u;
    n = begin;
  }
  own.count = end;
  remake(own.i, end);
  remake(own.j, end);
  const uint32_t idle = static_cast<uint32_t>(slab_of.size()) + s * kIdleBodies;
  for (uint32_t k = 0; k < end; ++k) {
    own.i[k] = idle + (k & 3);
    own.j[k] = idle + 4 + (k & 3);
  }
  for (uint32_t k = 0; k < total; ++k) {
    PairSlab& finder = (own.pending[k] & kAbove) != 0 ? slab[above] : own;
    const uint32_t at = own.pending[k] & ~kAbove;
    const uint32_t contact = own.colour_count[own.colour[k]]++;
    own.i[contact] = finder.found_i[at];
    own.j[contact] = finder.found_j[at];
    finder.found_at[at] = contact;
  }
}

void PairLists::fill(uint32_t s, const Bodies& bodies, const PairLists& old,
                     std::span<const uint32_t> order, std::span<const uint32_t> history) {
  PairSlab& own = slab[s];
  refill(own.lanes, size_t{own.count} * laneCount(rolling, bouncing), 0.0f);
  own.bounces.clear();
  float* friction = own.lane(Lane::Friction);
  const bool any_old = old.slab_count > 0;
  const uint32_t copied = laneCount(rolling && old.rolling, false);
  for (uint32_t c = 0; c < own.count; ++c) {
    const uint32_t i = own.i[c], j = own.j[c];
    if (i >= bodies.count) continue;
    const GrainMaterial &a = bodies.material[i], &b = bodies.material[j];
    friction[c] = std::sqrt(a.friction * b.friction);
    if (rolling)
      own.lane(Lane::RollingFriction)[c] = std::max(a.rolling_friction, b.rolling_friction);
    if (bouncing) own.lane(Lane::Restitution)[c] = std::max(a.restitution, b.restitution);
    if (!any_old) continue;
    const uint32_t old_i = history[order[i]], old_j = history[order[j]];
    if (old_i == kNoSlot || old_j == kNoSlot) continue;
    const auto take = [&](uint32_t finder, uint32_t other, float sign) {
      const PairSlab& from = old.slab[old.slab_of[finder]];
      for (uint32_t k = old.found_begin[finder]; k < old.found_end[finder]; ++k) {
        if (from.found_j[k] != other) continue;
        const uint32_t owner_slab = [&] {
          const uint32_t fs = old.slab_of[finder], os = old.slab_of[other];
          const uint32_t below = (fs + old.slab_count - 1) & (old.slab_count - 1);
          return os == below ? below : fs;
        }();
        const PairSlab& owner = old.slab[owner_slab];
        const uint32_t at = from.found_at[k];
        for (uint32_t l = 0; l < copied; ++l) {
          const Lane lane = static_cast<Lane>(l);
          if (lane == Lane::Friction || lane == Lane::RollingFriction) continue;
          const bool flips = lane <= Lane::ImpulseZ || lane >= Lane::RollingX;
          own.lane(lane)[c] = (flips ? sign : 1.0f) * owner.lane(lane)[at];
        }
        return true;
      }
      return false;
    };
    if (!take(old_i, old_j, 1)) take(old_j, old_i, -1);
  }
}

size_t PairLists::memoryBytes() const {
  size_t words = slab_of.capacity() + found_begin.capacity() + found_end.capacity() +
                 2 * (mask[0].capacity() + mask[1].capacity());
  for (const PairSlab& s : slab)
    words += s.found_i.capacity() + s.found_j.capacity() + s.found_at.capacity() +
             s.i.capacity() + s.j.capacity() + s.lanes.capacity() + s.pending.capacity() +
             s.again.capacity() + s.colour.capacity() + s.colour_count.capacity() +
             s.bounces.capacity() * (sizeof(Bounce) / 4);
  return words * 4;
}

}  // namespace scree::grains
