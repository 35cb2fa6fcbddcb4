// The store of sleepers: hashed cells, contact lists, and what is passed down to the ground.
#include "modules/grains/sleepers.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace scree::grains {

template <class Node>
uint32_t Sleepers::Pool<Node>::take() {
  if (free == kNoSlot) {
    node.emplace_back();
    return static_cast<uint32_t>(node.size() - 1);
  }
  const uint32_t at = free;
  free = node[at].next;
  return at;
}

template <class Node>
void Sleepers::Pool<Node>::give(uint32_t at) {
  node[at].next = free;
  free = at;
}

// The level whose cells are the smallest that are at least a diameter wide.
int Sleepers::levelOf(float radius) {
  int exponent = 0;
  std::frexp(2 * radius, &exponent);  // 2 radius < 2^exponent
  return std::clamp(exponent - kLowestLevel, 0, kLevels - 1);
}

uint32_t Sleepers::bucketRow(int level, int32_t y, int32_t z) {
  const uint32_t h = static_cast<uint32_t>(y) * 0xd8163841u ^ static_cast<uint32_t>(z) * 0xcb1ab31fu ^
                     static_cast<uint32_t>(level) * 0x9e3779b9u;
  return h ^ h >> 15;
}

uint32_t Sleepers::bucketOf(const Spot& spot) const {
  const double inverse = std::ldexp(1.0, -(spot.level + kLowestLevel));
  const vec3 p = spot.position;
  const uint32_t row = bucketRow(spot.level, cellOf(p.y, inverse), cellOf(p.z, inverse));
  return (row + static_cast<uint32_t>(cellOf(p.x, inverse))) &
         static_cast<uint32_t>(bucket_.size() - 1);
}

void Sleepers::putInBucket(uint32_t berth) {
  const uint32_t bucket = bucketOf(spot_[berth]);
  spot_[berth].next = bucket_[bucket];
  bucket_[bucket] = berth;
  occupied_[bucket / 64] |= uint64_t{1} << bucket % 64;
}

void Sleepers::growTable() {
  bucket_.assign(std::max<size_t>(256, 2 * bucket_.size()), kNoSlot);
  occupied_.assign(bucket_.size() / 64, 0);
  each([&](uint32_t berth) { putInBucket(berth); });
}

uint32_t Sleepers::lay(const Sleeper& sleeper) {
  uint32_t berth = free_;
  if (berth == kNoSlot) {
    berth = static_cast<uint32_t>(sleeper_.size());
    sleeper_.emplace_back();
    spot_.emplace_back();
  } else {
    free_ = spot_[berth].next;
  }
  Sleeper& own = sleeper_[berth] = sleeper;
  own.pairs = own.walls = own.slot_before = kNoSlot;
  const int level = levelOf(own.radius);
  spot_[berth] = {own.position, own.radius, kNoSlot, level};
  ++members_[static_cast<size_t>(level)];
  ++changes_;
  if (++count_ > bucket_.size() / 2) {
    growTable();  // finds this one too
  } else {
    putInBucket(berth);
  }
  return berth;
}

void Sleepers::insertPair(uint32_t owner, const PairNode& node) {
  const uint32_t at = pair_.take();
  pair_.node[at] = node;
  uint32_t* link = &sleeper_[owner].pairs;
  while (*link != kNoSlot &&
         sleeper_[pair_.node[*link].other].entity < sleeper_[node.other].entity)
    link = &pair_.node[*link].next;
  pair_.node[at].next = *link;
  *link = at;
}

void Sleepers::lean(uint32_t a, uint32_t b, vec3 impulse, vec3 rolling) {
  insertPair(a, {b, kNoSlot, impulse, rolling});
  insertPair(b, {a, kNoSlot, -impulse, -rolling});
  ++contacts_;
}

Sleepers::WallLoad& Sleepers::wallLoad(uint32_t key) {
  const auto at =
      std::lower_bound(wall_load_.begin(), wall_load_.end(), key,
                       [](const WallLoad& load, uint32_t wanted) { return load.key < wanted; });
  if (at != wall_load_.end() && at->key == key) return *at;
  return *wall_load_.insert(at, WallLoad{key, 0, {}});
}

const Sleepers::WallLoad* Sleepers::loadOn(uint32_t key) const {
  const auto at =
      std::lower_bound(wall_load_.begin(), wall_load_.end(), key,
                       [](const WallLoad& load, uint32_t wanted) { return load.key < wanted; });
  return at != wall_load_.end() && at->key == key && at->contacts > 0 ? &*at : nullptr;
}

bool Sleepers::leansOn(uint32_t node, uint32_t key) const {
  for (; node != kNoSlot; node = wall_.node[node].next)
    if (colliderKey(wall_.node[node].key) == key) return true;
  return false;
}

void Sleepers::leanOn(uint32_t berth, const ColliderContact& contact) {
  const uint32_t key = colliderKey(contact.key);
  const bool leans = leansOn(sleeper_[berth].walls, key);  // at another point
  const uint32_t at = wall_.take();
  wall_.node[at] = {contact.key, kNoSlot, contact.impulse, contact.rolling, contact.normal};
  uint32_t* link = &sleeper_[berth].walls;
  while (*link != kNoSlot && wall_.node[*link].key < contact.key) link = &wall_.node[*link].next;
  wall_.node[at].next = *link;
  *link = at;
  WallLoad& load = wallLoad(key);
  load.contacts += leans ? 0 : 1;
  for (int axis = 0; axis < 3; ++axis)
    load.impulse[static_cast<size_t>(axis)].add(contact.impulse[axis]);
  ++contacts_;
}

void Sleepers::weigh(uint32_t berth, vec3 gravity_step) {
  Sleeper& own = sleeper_[berth];
  own.load = {grainMass(own.radius, own.material.density) * gravity_step, 0};
  const auto add = [&](vec3 impulse) {
    own.load.impulse += impulse;
    own.load.carried += std::sqrt(glm::dot(impulse, impulse));
  };
  for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next) add(wall_.node[at].impulse);
  for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].next) add(pair_.node[at].impulse);
}

float Sleepers::heightOf(uint32_t berth, vec3 up) const {
  if (sleeper_[berth].ring == kNoSlot) return glm::dot(sleeper_[berth].position, up);
  float mass = 0, sum = 0;
  eachOfClump(berth, [&](uint32_t at) {
    const float own = grainMass(sleeper_[at].radius, sleeper_[at].material.density);
    mass += own;
    sum += own * glm::dot(sleeper_[at].position, up);
  });
  return sum / mass;
}

void Sleepers::passDown(std::vector<uint32_t>& berths, vec3 gravity_step) {
  const float g = std::sqrt(glm::dot(gravity_step, gravity_step));
  const vec3 up = g > 0 ? gravity_step * (-1 / g) : vec3(0);
  std::vector<uint32_t>& hooks = hooks_;
  hooks.clear();
  const auto lower = [&](uint32_t a, uint32_t b) {  // the highest is on top of the heap
    const float ha = glm::dot(sleeper_[a].position, up), hb = glm::dot(sleeper_[b].position, up);
    return ha != hb ? ha < hb : sleeper_[b].entity < sleeper_[a].entity;
  };
  std::make_heap(berths.begin(), berths.end(), lower);
  while (!berths.empty()) {
    std::pop_heap(berths.begin(), berths.end(), lower);
    const uint32_t berth = berths.back();
    berths.pop_back();
    // Of a clump, as a whole.
    vec3 left(0);
    float weight = 0;
    bool propped = false;
    eachOfClump(berth, [&](uint32_t member) {
      weigh(member, gravity_step);
      const Sleeper& own = sleeper_[member];
      left = own.ring == kNoSlot || own.member == 0 ? own.load.impulse : left + own.load.impulse;
      weight += grainMass(own.radius, own.material.density) * g;
      propped = propped || own.propped;
    });
    if (propped || !(glm::dot(left, left) > 1e-10f * weight * weight)) continue;
    // Of the contacts at the lower side, the one that bears most.
    constexpr float kSteep = 0.3f;  // a support's direction, at least so much down
    float most = 0, most_hooked = 0;
    uint32_t pair = kNoSlot, wall = kNoSlot, bearer = berth, hooked = kNoSlot, hook = kNoSlot;
    eachOfClump(berth, [&](uint32_t member) {
      const Sleeper& own = sleeper_[member];
      for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].next) {
        const Sleeper& other = sleeper_[pair_.node[at].other];
        const float bears = glm::dot(pair_.node[at].impulse, up);
        const bool steep = glm::dot(own.position - other.position, up) > kSteep * (own.radius + other.radius);
        const bool clumps = own.ring != kNoSlot || other.ring != kNoSlot;
        if (clumps && !(steep && heightOf(pair_.node[at].other, up) < heightOf(member, up))) {
          if (!(bears > most_hooked)) continue;
          most_hooked = bears;
          hooked = at;
          hook = member;
          continue;
        }
        if (!(bears > most && steep)) continue;
        most = bears;
        pair = at;
        bearer = member;
      }
      for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next) {
        const float bears = glm::dot(wall_.node[at].impulse, up);
        if (bears > most && glm::dot(wall_.node[at].normal, up) > kSteep) {
          most = bears;
          pair = kNoSlot;
          wall = at;
          bearer = member;
        }
      }
    });
    // Clumps that hook into each other could pass it round for ever: each does so a few times.
    constexpr uint8_t kMostHooks = 8;
    if (pair == kNoSlot && wall == kNoSlot && hooked != kNoSlot && sleeper_[hook].hooks < kMostHooks) {
      if (sleeper_[hook].hooks++ == 0) hooks.push_back(hook);
      pair = hooked;
      bearer = hook;
    }
    if (pair != kNoSlot) {
      pair_.node[pair].impulse -= left;
      const uint32_t other = pair_.node[pair].other;
      uint32_t back = sleeper_[other].pairs;
      while (pair_.node[back].other != bearer) back = pair_.node[back].next;
      pair_.node[back].impulse = -pair_.node[pair].impulse;
      berths.push_back(other);
      std::push_heap(berths.begin(), berths.end(), lower);
    } else if (wall != kNoSlot) {
      WallLoad& load = wallLoad(colliderKey(wall_.node[wall].key));
      for (int axis = 0; axis < 3; ++axis) {
        const size_t a = static_cast<size_t>(axis);
        load.impulse[a].add(-wall_.node[wall].impulse[axis]);
        wall_.node[wall].impulse[axis] -= left[axis];
        load.impulse[a].add(wall_.node[wall].impulse[axis]);
      }
    }
    weigh(bearer, gravity_step);
  }
  for (const uint32_t berth : hooks) sleeper_[berth].hooks = 0;
}

void Sleepers::wake(uint32_t berth, std::vector<WokenPair>& pairs, std::vector<WokenWall>& walls,
                    std::vector<uint32_t>& partners) {
  Sleeper& own = sleeper_[berth];
  for (uint32_t at = own.pairs, next = kNoSlot; at != kNoSlot; at = next) {
    const PairNode node = pair_.node[at];
    next = node.next;
    pair_.give(at);
    pairs.push_back({own.entity, sleeper_[node.other].entity, node.impulse, node.rolling});
    uint32_t* link = &sleeper_[node.other].pairs;
    while (pair_.node[*link].other != berth) link = &pair_.node[*link].next;
    const uint32_t other = *link;
    *link = pair_.node[other].next;
    pair_.give(other);
    partners.push_back(node.other);
    --contacts_;
  }
  for (uint32_t at = own.walls, next = kNoSlot; at != kNoSlot; at = next) {
    const WallNode node = wall_.node[at];
    next = node.next;
    wall_.give(at);
    walls.push_back({own.entity, node.key, node.impulse, node.rolling, node.normal});
    const uint32_t key = colliderKey(node.key);
    WallLoad& load = wallLoad(key);
    load.contacts -= leansOn(next, key) ? 0 : 1;
    for (int axis = 0; axis < 3; ++axis)
      load.impulse[static_cast<size_t>(axis)].add(-node.impulse[axis]);
    --contacts_;
    if (load.contacts == 0) wall_load_.erase(wall_load_.begin() + (&load - wall_load_.data()));
  }
  Spot& spot = spot_[berth];
  const uint32_t bucket = bucketOf(spot);
  uint32_t* link = &bucket_[bucket];
  while (*link != berth) link = &spot_[*link].next;
  *link = spot.next;
  if (bucket_[bucket] == kNoSlot) occupied_[bucket / 64] &= ~(uint64_t{1} << bucket % 64);
  --members_[static_cast<size_t>(spot.level)];
  --count_;
  ++changes_;
  own = Sleeper{};
  spot = Spot{};
  spot.next = free_;
  free_ = berth;
}

size_t Sleepers::memoryBytes() const {
  return sleeper_.capacity() * sizeof(Sleeper) + spot_.capacity() * sizeof(Spot) +
         pair_.node.capacity() * sizeof(PairNode) + wall_.node.capacity() * sizeof(WallNode) +
         wall_load_.capacity() * sizeof(WallLoad) + bucket_.capacity() * sizeof(uint32_t) +
         occupied_.capacity() * sizeof(uint64_t) + hooks_.capacity() * sizeof(uint32_t);
}

}  // namespace scree::grains
