// Contact lists to bytes and back: who touches whom, in the order of the passes, and the impulses.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>

#include "modules/grains/contacts.h"
#include "modules/grains/grains.h"
#include "modules/grains/saved.h"
#include "modules/grains/saved_collider.h"

namespace scree::grains {
namespace {

// Lanes, used or not, of all slabs; more are refused: 3 GB.
constexpr uint64_t kMostSavedContacts = uint64_t{16} * kMaxGrains;

// Lanes of a batch whose vectors are not zero to the bit.
uint8_t filledLanes(const float (&v)[3][kBatch]) {
  uint32_t lanes = 0;
  for (uint32_t lane = 0; lane < kBatch; ++lane)
    for (const auto& axis : v)
      if (std::bit_cast<uint32_t>(axis[lane]) != 0) lanes |= 1u << lane;
  return static_cast<uint8_t>(lanes);
}

void writeLanes(ByteWriter& out, const float (&v)[3][kBatch]) {
  const uint8_t lanes = filledLanes(v);
  out.number(lanes);
  for (uint32_t lane = 0; lane < kBatch; ++lane)
    if ((lanes >> lane & 1) != 0) out.number(vec3(v[0][lane], v[1][lane], v[2][lane]));
}

// False: lanes that are not used, or not finite.
bool readLanes(ByteReader& in, uint8_t used, float (&v)[3][kBatch]) {
  const auto lanes = in.number<uint8_t>();
  for (uint32_t lane = 0; lane < kBatch; ++lane) {
    if ((lanes >> lane & 1) == 0) continue;
    const auto value = in.number<vec3>();
    if (!finite(value)) return false;
    for (int axis = 0; axis < 3; ++axis) v[axis][lane] = value[axis];
  }
  return (lanes & ~used) == 0;
}

}  // namespace

void PairLists::save(ByteWriter& out) const {
  const uint32_t listed = bodyCount();
  for (uint32_t s = 0; s < slab_count; ++s) {
    const PairSlab& own = slab[s];
    const uint32_t batches = own.count / kBatch;
    out.number(batches);
    for (uint32_t b = 0; b < batches; ++b) {
      const uint32_t *i = &own.i[size_t{kBatch} * b], *j = &own.j[size_t{kBatch} * b];
      uint8_t used = 0;  // of the first lanes
      while (used < kBatch && i[used] < listed) ++used;
      out.number(used);
      for (uint32_t lane = 0; lane < used; ++lane) {
        out.number(i[lane]);
        out.number(j[lane]);
      }
      out.number(own.trust[b]);
      writeLanes(out, own.impulse[b].impulse);
      if (rolling) writeLanes(out, own.rolling[b].impulse);
    }
    out.number(static_cast<uint32_t>(own.border.size()));
    for (const uint32_t contact : own.border) out.number(contact);
  }
}

std::string PairLists::restore(ByteReader& in, std::span<const uint32_t> slab_begin,
                               const Bodies& bodies, bool in_force) {
  slab_count = slab_begin.empty() ? 0 : static_cast<uint32_t>(slab_begin.size() - 1);
  slab.resize(slab_count);
  listed_ = slab_count > 0 ? slab_begin.back() : 0;
  std::vector<uint32_t> met(listed_, 0);  // the last batch with the grain, counted from 1
  uint32_t batch = 0;
  uint64_t lanes = 0;
  pair_count = 0;
  for (uint32_t s = 0; s < slab_count; ++s) {
    PairSlab& own = slab[s];
    const auto batches = in.number<uint32_t>();
    lanes += uint64_t{batches} * kBatch;
    if (!in.has(batches, 11) || lanes > kMostSavedContacts)
      return fmt::format("slab {}: {} batches of contacts reach beyond the end, or are too many", s,
                         batches);
    own.count = batches * kBatch;
    layOut(Contents::Keep);
    layOutImpulses(Contents::Keep);
    clearLanes(own);
    fillIdle(s);
    own.colour_end.clear();
    for (uint32_t b = 0; b < batches; ++b) {
      ++batch;
      const auto used = in.number<uint8_t>();
      if (used == 0 || used > kBatch) return fmt::format("a batch of {} contacts; 1 to 8 are allowed", used);
      bool goes_on = b > 0;  // the colour: no grain is in the batch before
      for (uint32_t lane = 0; lane < used; ++lane) {
        const uint32_t c = b * kBatch + lane;
        const auto i = in.number<uint32_t>(), j = in.number<uint32_t>();
        for (const uint32_t slot : {i, j}) {
          const uint32_t above = (s + 1) & (slab_count - 1);
          const bool here = (slot >= slab_begin[s] && slot < slab_begin[s + 1]) ||
                            (slot >= slab_begin[above] && slot < slab_begin[above + 1]);
          if (!here || met[slot] == batch)
            return fmt::format("slab {}, contact {}: bodies {} and {} of {} are not there, or there twice",
                               s, c, i, j, listed_);
          goes_on = goes_on && met[slot] != batch - 1;
          met[slot] = batch;
        }
        if (in_force && !isAwake(bodies, i) && !isAwake(bodies, j))
          return fmt::format("slab {}, contact {}: both grains sleep", s, c);
        own.i[c] = i;
        own.j[c] = j;
        mixMaterials(own, c, bodies);
        ++pair_count;
      }
      if (!goes_on) own.colour_end.push_back(0);
      own.colour_end.back() = (b + 1) * kBatch;
      const auto filled = static_cast<uint8_t>((1u << used) - 1);
      own.trust[b] = in.number<uint8_t>() & filled;
      if (!readLanes(in, filled, own.impulse[b].impulse) ||
          (rolling && !readLanes(in, filled, own.rolling[b].impulse)))
        return fmt::format("slab {}, batch {}: impulses of no contact, or not finite", s, b);
    }
    const auto borders = in.number<uint32_t>();
    if (!in.has(borders, 4)) return fmt::format("slab {}: {} borders reach beyond the end", s, borders);
    own.border.reserve(borders);
    for (uint32_t k = 0; k < borders; ++k) {
      const auto c = in.number<uint32_t>();
      const bool listed = c < own.count && own.i[c] < listed_;
      if (!listed || (in_force && isAwake(bodies, own.i[c]) == isAwake(bodies, own.j[c])))
        return fmt::format("slab {}: contact {} is no border of sleepers", s, c);
      own.border.push_back(c);
    }
  }
  return {};
}

void ColliderLists::save(ByteWriter& out) const {
  out.number(extra_);
  out.number(static_cast<uint32_t>(swept_.size()));
  for (const Swept& swept : swept_) writeCollider(out, swept.collider);
  for (uint32_t s = 0; s < slab_count; ++s) {
    out.number(static_cast<uint32_t>(slab[s].contact.size()));
    for (const ColliderContact& contact : slab[s].contact) {
      out.number(contact.grain);
      out.number(contact.collider);
      out.number(static_cast<uint8_t>(contact.key / kKeyLimit));  // partKey
      out.number(static_cast<uint8_t>(contact.guarded));
      out.number(contact.impulse);
      out.number(contact.rolling);
      out.number(contact.normal);
      out.number(vec3(contact.friction, contact.rolling_friction, contact.restitution));
      out.number(contact.pull);
      out.number(static_cast<uint8_t>(contact.trust != 0));
    }
  }
}

std::string ColliderLists::restore(ByteReader& in, std::span<const uint32_t> slab_begin,
                                   const Bodies& bodies, bool in_force) {
  const auto extra = in.number<float>();
  if (!(extra >= 0) || !finite(extra)) return fmt::format("a drift by {} m; allowed is 0 or more", extra);
  const auto count = in.number<uint32_t>();
  if (!in.has(count, 144)) return fmt::format("{} colliders reach beyond the end", count);
  std::vector<Collider> colliders(count);
  for (uint32_t k = 0; k < count; ++k)
    if (!readCollider(in, colliders[k]) || (k > 0 && colliders[k - 1].key >= colliders[k].key))
      return fmt::format("collider {} has no shape or key, or comes before the last one", k);
  sweep(colliders);
  lacking_ = true;
  extra_ = extra;
  slab_count = slab_begin.empty() ? 0 : static_cast<uint32_t>(slab_begin.size() - 1);
  slab.resize(slab_count);
  for (uint32_t s = 0; s < slab_count; ++s) {
    ColliderSlab& own = slab[s];
    own.begin = slab_begin[s];
    own.end = slab_begin[s + 1];
    const auto contacts = in.number<uint32_t>();
    if (!in.has(contacts, 63))
      return fmt::format("slab {}: {} contacts with colliders reach beyond the end", s, contacts);
    own.contact_begin = contact_count;
    own.contact_size = contacts;
    contact_.extend(contact_count + contacts);
    for (uint32_t c = 0; c < contacts; ++c) {
      ColliderContact contact;
      contact.grain = in.number<uint32_t>();
      contact.collider = in.number<uint32_t>();
      const auto part = in.number<uint8_t>();
      contact.guarded = in.number<uint8_t>() != 0;
      contact.impulse = in.number<vec3>();
      contact.rolling = in.number<vec3>();
      contact.normal = in.number<vec3>();
      const auto mixed = in.number<vec3>();
      contact.pull = in.number<float>();
      contact.trust = in.number<uint8_t>() != 0 ? 1.0f : 0.0f;
      const bool there = contact.grain >= own.begin && contact.grain < own.end && contact.collider < count;
      if (!there || part >= (colliders[contact.collider].shape == Shape::Field ? DistanceField::kMostTouches : 1))
        return fmt::format("slab {}, contact {}: body {} and part {} of collider {} are not there", s, c,
                           contact.grain, part, contact.collider);
      contact.key = partKey(colliders[contact.collider].key, part);
      const auto place = [](const ColliderContact& x) { return std::tuple(x.grain, x.collider, x.key); };
      if (c > 0 && place(contact_[contact_count + c - 1]) >= place(contact))
        return fmt::format("slab {}: contacts with colliders are out of order at {}", s, c);
      if (in_force && !isAwake(bodies, contact.grain))
        return fmt::format("slab {}, contact {} with a collider: the grain sleeps", s, c);
      if (!finite(contact.impulse) || !finite(contact.rolling) || !finite(contact.normal) ||
          !finite(mixed) || !(mixed.x >= 0 && mixed.y >= 0 && mixed.z >= 0) || !finite(contact.pull) ||
          !(contact.pull >= 0))
        return fmt::format("slab {}, contact {} with a collider: numbers that are not allowed", s, c);
      contact.friction = mixed.x;
      contact.rolling_friction = mixed.y;
      contact.restitution = mixed.z;
      contact_[contact_count + c] = contact;
    }
    contact_count += contacts;
  }
  shareOut();
  return {};
}

}  // namespace scree::grains
