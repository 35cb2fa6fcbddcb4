// Listing the grains near colliders; impulses are taken over from the lists before.
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "engine/core/parallel.h"
#include "modules/grains/cohesion.h"
#include "modules/grains/contacts.h"

namespace scree::grains {
namespace {

bool apart(const Bounds& a, const Bounds& b) {
  return a.max.x < b.min.x || b.max.x < a.min.x || a.max.y < b.min.y || b.max.y < a.min.y ||
         a.max.z < b.min.z || b.max.z < a.min.z;
}

// In all that lists depend on.
bool alike(const Collider& a, const Collider& b) {
  return a.shape == b.shape && a.position0 == b.position0 && a.position1 == b.position1 &&
         a.rotation0 == b.rotation0 && a.rotation1 == b.rotation1 &&
         a.half_extent == b.half_extent && a.a == b.a && a.b == b.b && a.radius == b.radius &&
         (a.field == b.field || (a.field_identity != 0 && a.field_identity == b.field_identity)) &&
         a.friction == b.friction && a.rolling_friction == b.rolling_friction &&
         a.restitution == b.restitution && a.cohesion == b.cohesion &&
         a.surface_velocity == b.surface_velocity && a.slack == b.slack;
}

// As a saved world tells of it: the first tick brings the field.
bool lacksField(const Collider& collider) {
  return collider.shape == Shape::Field && collider.field == nullptr;
}

// How far a grain's surface may be from its reference until the next listing.
float reachOf(const Bodies& bodies, uint32_t i, const Going& going) {
  const vec3 relative = bodies.body[i].velocity - going.drift;
  const float way = going.h * going.h * glm::dot(relative, relative);
  float margin = bodies.margin[i];
  if (way > margin * margin) margin = std::sqrt(way);  // it is searched for in every substep
  return bodies.body[i].radius + margin + going.extra;
}

}  // namespace

void ColliderLists::place(Swept& swept) {
  swept.bounds = sweptBounds(swept.collider);
  swept.motion = motionBound(swept.collider);
  swept.thickness = thicknessOf(swept.collider);
  swept.begin = poseCollider(swept.collider, 0, 0, 0);
}

void ColliderLists::bringFields(std::span<const Collider> colliders) {
  if (!lacking_) return;
  lacking_ = false;
  for (Swept& swept : swept_) {
    if (!lacksField(swept.collider)) continue;
    const auto now = std::lower_bound(
        colliders.begin(), colliders.end(), swept.collider.key,
        [](const Collider& collider, uint32_t key) { return collider.key < key; });
    if (now == colliders.end() || now->key != swept.collider.key || now->field == nullptr ||
        now->field_identity == 0 || now->field_identity != swept.collider.field_identity)
      continue;
    swept.collider.field = now->field;
    place(swept);
  }
}

// Notes where the colliders go; true if any is not as it was.
bool ColliderLists::sweep(std::span<const Collider> colliders) {
  bool same_keys = swept_.size() == colliders.size();
  for (size_t k = 0; k < colliders.size() && same_keys; ++k)
    same_keys = swept_[k].collider.key == colliders[k].key;
  bool any = !same_keys;
  swept_.resize(colliders.size());
  for (size_t k = 0; k < colliders.size(); ++k) {
    Swept& swept = swept_[k];
    swept.fresh = !same_keys || !alike(swept.collider, colliders[k]);
    any = any || swept.fresh;
    if (!swept.fresh && swept.collider.field == colliders[k].field) continue;
    swept.collider = colliders[k];
    if (!lacksField(swept.collider)) place(swept);
  }
  if (!same_keys)  // indices have moved: nothing can stay in its place
    for (Swept& swept : swept_) swept.fresh = true;
  return any;
}

const ColliderLists::Swept* ColliderLists::sweptLast(const Collider& collider) const {
  const auto at = std::lower_bound(
      swept_.begin(), swept_.end(), collider.key,
      [](const Swept& swept, uint32_t wanted) { return swept.collider.key < wanted; });
  return at != swept_.end() && at->collider.key == collider.key && alike(at->collider, collider)
             ? &*at
             : nullptr;
}

void ColliderLists::build(const Grid& grid, const Bodies& bodies,
                          std::span<const Collider> colliders, const Going& going, bool searched,
                          std::span<const uint32_t> before,
                          std::span<const JoiningWall> joining, Workspace& workspace) {
  const bool changed = sweep(colliders), wider = going.extra > 0 || extra_ > 0;
  if (!searched && !changed && !wider) return;
  if (searched || wider)
    for (Swept& swept : swept_) swept.fresh = true;
  extra_ = going.extra;
  const TakeOver over{searched, before, joining, slab_count};
  slab_count = grid.slabCount();
  if (slab.size() < slab_count) slab.resize(slab_count);
  const std::span<ColliderContact> was = workspace.take<ColliderContact>(contact_count);
  std::ranges::copy(contact_.all().first(contact_count), was.begin());
  for (uint32_t s = 0; s < slab.size(); ++s) {
    ColliderSlab& own = slab[s];
    own.was = was.subspan(own.contact_begin, own.contact_size);
    own.contact = {};
    own.contact_size = 0;
    own.was_begin = own.begin;
    own.begin = s < slab_count ? grid.slabBegin(s) : 0;
    own.end = s < slab_count ? grid.slabEnd(s) : 0;
  }
  const Worth worth = worthOf(bodies.count, kFewGrains);
  scratch_.resize(static_cast<size_t>(threadCount()));
  for (Scratch& scratch : scratch_) {
    scratch.listed.clear();
    fitTo(scratch.listed, most_listed_);
  }

  // Each slab is listed by a thread, and then moved behind those that were listed earlier. Where there is
  // no room any more, it is made, and the slabs that are left are listed again.
  std::atomic<size_t> listed = 0;
  contact_.remake(contact_count);
  const size_t room = contact_.capacity();
  contact_.extend(room);
  const auto copy = [&](const ColliderSlab& own, const Scratch& scratch) {
    for (size_t k = 0; k < scratch.listed.size(); ++k) {
      ColliderContact& contact = contact_[own.contact_begin + k];
      contact = contactOf(scratch.listed[k], own, bodies, going);
      takeOver(contact, over);
    }
  };
  const auto listSlab = [&](size_t s) -> const Scratch& {
    Scratch& scratch = scratch_[threadIndex()];
    list(static_cast<uint32_t>(s), grid, bodies, going, scratch);
    return scratch;
  };
  parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) {
    const Scratch& scratch = listSlab(s);
    ColliderSlab& own = slab[s];
    own.bounces.clear();
    own.contact_size = scratch.listed.size();
    own.contact_begin = listed.fetch_add(own.contact_size, std::memory_order_relaxed);
    if (own.contact_begin + own.contact_size <= room) copy(own, scratch);
  }, worth);
  contact_count = listed;
  most_listed_ = 0;
  for (uint32_t s = 0; s < slab_count; ++s) most_listed_ = std::max(most_listed_, slab[s].contact_size);
  if (contact_count > room) {
    contact_.extend(contact_count);
    parallelChunks(slab_count, 1, [&](size_t s, size_t, size_t) {
      const ColliderSlab& own = slab[s];
      if (own.contact_begin + own.contact_size > room) copy(own, listSlab(s));
    }, worth);
  }
  shareOut();
}

ColliderLists::ColliderLists(const ColliderLists& other) : ColliderArrays(other) { shareOut(); }

void ColliderLists::shareOut() {
  for (ColliderSlab& own : slab) {
    own.contact = {contact_.data() + own.contact_begin, own.contact_size};
    own.was = {};
  }
}

void ColliderLists::takeOver(ColliderContact& contact, const TakeOver& over) const {
  if (!swept_[contact.collider].fresh) return;
  const uint32_t was = over.searched ? over.before[contact.grain] : contact.grain;
  if (was != kNoSlot) {
    if (const ColliderContact* last = formerly(was, contact.key, over.slabs)) {
      contact.impulse = last->impulse;
      contact.rolling = last->rolling;
      contact.trust = last->trust;
      contact.normal = last->normal;
      return;
    }
  }
  auto at = std::lower_bound(over.joining.begin(), over.joining.end(), contact.grain,
                             [](const JoiningWall& a, uint32_t g) { return a.grain < g; });
  for (; at != over.joining.end() && at->grain == contact.grain; ++at) {
    if (at->key != contact.key) continue;
    contact.impulse = at->impulse;
    contact.rolling = at->rolling;
    contact.trust = 1;
    contact.normal = at->normal;
  }
}

void ColliderLists::list(uint32_t s, const Grid& grid, const Bodies& bodies,
                         const Going& going, Scratch& scratch) const {
  const ColliderSlab& own = slab[s];
  std::vector<uint32_t>& near = scratch.near;
  scratch.listed.clear();
  Bounds bounds{vec3(3e38f), vec3(-3e38f)};
  for (uint32_t i = own.begin; i < own.end; ++i) {
    if (!isAwake(bodies, i)) continue;
    const float reach = reachOf(bodies, i, going);
    const vec3 at = grid.listedAt(i) + going.drifted;
    bounds.min = glm::min(bounds.min, at - reach);
    bounds.max = glm::max(bounds.max, at + reach);
  }
  near.clear();
  if (!(bounds.min.x <= bounds.max.x)) return;  // nobody is awake
  const vec3 centre = 0.5f * (bounds.min + bounds.max);
  const float around = 1.001f * glm::length(bounds.max - centre);
  for (uint32_t k = 0; k < swept_.size(); ++k) {
    const Swept& swept = swept_[k];
    // Whatever lies farther than the corners from the centre is apart from all within.
    if (!swept.fresh || (!apart(bounds, swept.bounds) &&
                         !(distanceTo(swept.begin, centre, 2 * (around + swept.motion)) > around + swept.motion)))
      near.push_back(k);
  }
  if (near.empty()) return;
  auto stays = own.was.begin();
  for (uint32_t i = own.begin; i < own.end; ++i) {
    if (!isAwake(bodies, i)) continue;
    const float reach = reachOf(bodies, i, going);
    const vec3 at = grid.listedAt(i) + going.drifted;
    const Bounds own_bounds{at - reach, at + reach};
    for (const uint32_t k : near) {
      const Swept& swept = swept_[k];
      if (!swept.fresh) {
        while (stays != own.was.end() &&
               (stays->grain < i || (stays->grain == i && stays->collider < k)))
          ++stays;
        for (; stays != own.was.end() && stays->grain == i && stays->collider == k; ++stays)
          append(scratch.listed, {i, k, kStays | static_cast<uint32_t>(stays - own.was.begin())});
        continue;
      }
      if (apart(own_bounds, swept.bounds) ||
          !(distanceTo(swept.begin, at, 2 * (reach + swept.motion)) < reach + swept.motion))
        continue;
      const bool field = swept.collider.shape == Shape::Field;
      const uint32_t parts = field ? std::min(swept.collider.field->mostTouches(), DistanceField::kMostTouches) : 1;
      for (uint32_t part = 0; part < parts; ++part) append(scratch.listed, {i, k, part});
    }
  }
}

ColliderContact ColliderLists::contactOf(const Listed& listed, const ColliderSlab& own, const Bodies& bodies,
                                         const Going& going) const {
  if ((listed.part & kStays) != 0) return own.was[listed.part & ~kStays];
  const Swept& swept = swept_[listed.collider];
  const Collider& collider = swept.collider;
  const GrainMaterial& material = bodies.materialOf(listed.grain);
  const float radius = bodies.body[listed.grain].radius;
  ColliderContact contact;
  contact.grain = listed.grain;
  contact.collider = listed.collider;
  contact.key = collider.shape == Shape::Field ? partKey(collider.key, listed.part) : collider.key;
  contact.friction = std::sqrt(material.friction * collider.friction);
  contact.rolling_friction = std::max(material.rolling_friction, collider.rolling_friction);
  contact.restitution = std::max(material.restitution, collider.restitution);
  contact.pull = pullOf(material.cohesion, collider.cohesion, radius);
  contact.guarded = collider.shape == Shape::Field || swept.thickness < 0.5f * radius ||
                    swept.motion * going.share > 0.5f * radius;
  return contact;
}

bool ColliderLists::misses(uint32_t slot, uint32_t in_slab, vec3 position, float reach) const {
  const float around = reach + extra_;
  const Bounds bounds{position - around, position + around};
  const std::span<const ColliderContact> listed = slab[in_slab].contact;
  for (uint32_t k = 0; k < swept_.size(); ++k) {
    const Swept& swept = swept_[k];
    if (lacksField(swept.collider)) return true;
    if (apart(bounds, swept.bounds) ||
        !(distanceTo(swept.begin, position, 2 * (around + swept.motion)) < around + swept.motion))
      continue;
    const auto at = std::lower_bound(listed.begin(), listed.end(), std::pair(slot, k),
                                     [](const ColliderContact& contact, const auto& wanted) {
                                       return std::pair(contact.grain, contact.collider) < wanted;
                                     });
    if (at == listed.end() || at->grain != slot || at->collider != k) return true;
  }
  return false;
}

// The contact of a former slot with a collider in the lists before; null: none.
const ColliderContact* ColliderLists::formerly(uint32_t slot, uint32_t key, uint32_t slabs) const {
  const auto above = std::upper_bound(
      slab.begin(), slab.begin() + slabs, slot,
      [](uint32_t at, const ColliderSlab& one) { return at < one.was_begin; });
  if (above == slab.begin()) return nullptr;
  const std::span<const ColliderContact> from = std::prev(above)->was;
  auto it = std::lower_bound(from.begin(), from.end(), slot,
                             [](const ColliderContact& a, uint32_t at) { return a.grain < at; });
  for (; it != from.end() && it->grain == slot; ++it)
    if (it->key == key) return &*it;
  return nullptr;
}

size_t ColliderLists::memoryBytes() const {
  size_t bytes = swept_.capacity() * sizeof(Swept) + contact_.memoryBytes() +
                 slab.capacity() * sizeof(ColliderSlab);
  for (const Scratch& scratch : scratch_)
    bytes += scratch.listed.capacity() * sizeof(Listed) + scratch.near.capacity() * sizeof(uint32_t);
  for (const ColliderSlab& s : slab)
    bytes += s.bounces.capacity() * sizeof(Bounce) + s.guards.capacity() * sizeof(Guard);
  return bytes;
}

}  // namespace scree::grains
