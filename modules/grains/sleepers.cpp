// The store of sleepers: hashed cells, contact lists, and what they leave over on the ground.
#include "modules/grains/sleepers.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scree::grains {

template <class Node>
uint32_t Sleepers::Pool<Node>::take() {
  if (free == kNoSlot) {
    append(node, Node{});
    return static_cast<uint32_t>(node.size() - 1);
  }
  const uint32_t at = free;
  free = node[at].freeLink();
  return at;
}

template <class Node>
void Sleepers::Pool<Node>::give(uint32_t at) {
  node[at].freeLink() = free;
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

uint32_t Sleepers::lay(const Sleeper& sleeper, const GrainMaterial& material) {
  uint32_t berth = free_;
  if (berth == kNoSlot) {
    berth = static_cast<uint32_t>(sleeper_.size());
    append(sleeper_, Sleeper{});
    append(spot_, Spot{});
  } else {
    free_ = spot_[berth].next;
  }
  Sleeper& own = sleeper_[berth] = sleeper;
  own.pairs = own.walls = own.slot_before = kNoSlot;
  own.material = materials_.numberOf(material);
  if (materials_.stale(count_))
    materials_.renew([&](const auto& visit) { each([&](uint32_t other) { visit(sleeper_[other].material); }); });
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

void Sleepers::insertPair(uint32_t owner, uint32_t at) {
  const Entity other = sleeper_[pair_.node[at].other(owner)].entity;
  uint32_t* link = &sleeper_[owner].pairs;
  while (*link != kNoSlot && sleeper_[pair_.node[*link].other(owner)].entity < other)
    link = &pair_.node[*link].nextOf(owner);
  pair_.node[at].nextOf(owner) = *link;
  *link = at;
}

vec3 Sleepers::rollingOn(uint32_t owner, uint32_t at) const {
  const vec3 rolling = at < rolling_.size() ? rolling_[at] : vec3(0);
  return pair_.node[at].side(owner) == 0 ? rolling : -rolling;
}

void Sleepers::setRolling(uint32_t at, vec3 rolling) {
  const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
  const bool nothing = (bits(rolling.x) | bits(rolling.y) | bits(rolling.z)) == 0;
  if (at >= rolling_.size()) {
    if (nothing) return;  // as those beyond the end are
    makeRoomFor(rolling_, at + 1);
    rolling_.resize(at + 1, vec3(0));
  }
  rolling_[at] = rolling;
}

void Sleepers::lean(uint32_t a, uint32_t b, vec3 impulse, vec3 rolling) {
  const uint32_t at = pair_.take();
  pair_.node[at] = {{a, b}, {kNoSlot, kNoSlot}, impulse};
  setRolling(at, rolling);
  insertPair(a, at);
  insertPair(b, at);
  ++contacts_;
}

Sleepers::WallLoad& Sleepers::wallLoad(uint32_t key) {
  const auto at =
      std::lower_bound(wall_load_.begin(), wall_load_.end(), key,
                       [](const WallLoad& load, uint32_t wanted) { return load.key < wanted; });
  if (at != wall_load_.end() && at->key == key) return *at;
  return *wall_load_.insert(at, WallLoad{key, 0, 0, {}});
}

void Sleepers::dropIfIdle(WallLoad& load) {
  if (load.contacts == 0 && load.bookings == 0)
    wall_load_.erase(wall_load_.begin() + (&load - wall_load_.data()));
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
  wall_.node[at] = {contact.key,    kNoSlot,          contact.impulse, contact.rolling,
                    contact.normal, contact.friction, contact.pull};
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
  own.load = {massOf(berth) * gravity_step, vec3(0), 0};
  const auto add = [&](vec3 normal, vec3 impulse, vec3 rolling) {
    own.load.impulse += impulse;
    own.load.moment += rolling / own.radius - glm::cross(normal, impulse);
    own.load.carried += std::sqrt(glm::dot(impulse, impulse));
  };
  for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next)
    add(wall_.node[at].normal, wall_.node[at].impulse, wall_.node[at].rolling);
  for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].nextOf(berth)) {
    const PairNode& node = pair_.node[at];
    add(normalOf(own, sleeper_[node.other(berth)]), node.impulseOn(berth), rollingOn(berth, at));
  }
}

void Sleepers::pressWall(WallNode& node, vec3 impulse) {
  WallLoad& load = wallLoad(colliderKey(node.key));
  for (int axis = 0; axis < 3; ++axis) {
    ExactSum& sum = load.impulse[static_cast<size_t>(axis)];
    sum.add(-node.impulse[axis]);
    sum.add(impulse[axis]);
  }
  node.impulse = impulse;
}

uint32_t Sleepers::groundUnder(uint32_t berth, vec3 up) const {
  constexpr int kMostSteps = 1024;  // clumps that hook into each other could lead round for ever
  uint32_t other_way = kNoSlot;     // where a way ends on a grain awake: the last second support
  for (int step = 0; step < kMostSteps && berth != kNoSlot; ++step) {
    float most = 0, second = 0;
    uint32_t next = kNoSlot, ground = kNoSlot;
    eachOfClump(berth, [&](uint32_t member) {
      const Sleeper& own = sleeper_[member];
      for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].nextOf(member)) {
        const uint32_t next_way = pair_.node[at].other(member);
        const Sleeper& other = sleeper_[next_way];
        const float bears = glm::dot(pair_.node[at].impulseOn(member), up);
        if (!(bears > second) || !(glm::dot(own.position - other.position, up) > 0)) continue;
        if (!(bears > most)) {
          second = bears;
          other_way = next_way;
          continue;
        }
        if (next != kNoSlot) other_way = next;
        second = most;
        most = bears;
        next = next_way;
        ground = kNoSlot;
      }
      for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next) {
        const float bears = glm::dot(wall_.node[at].impulse, up);
        if (!(bears > most)) continue;
        most = bears;
        ground = colliderKey(wall_.node[at].key);
      }
    });
    if (ground != kNoSlot) return ground;
    berth = next != kNoSlot ? next : std::exchange(other_way, kNoSlot);
  }
  return kNoSlot;
}

void Sleepers::unbook(uint32_t berth) {
  Sleeper& own = sleeper_[berth];
  if (own.booked_on == kNoSlot) return;
  WallLoad& load = wallLoad(own.booked_on);
  for (int axis = 0; axis < 3; ++axis) load.impulse[static_cast<size_t>(axis)].add(-own.booked[axis]);
  --load.bookings;
  dropIfIdle(load);
  own.booked_on = kNoSlot;
}

void Sleepers::unbookAll(uint32_t key, std::vector<uint32_t>& berths) {
  each([&](uint32_t berth) {
    if (sleeper_[berth].booked_on != key) return;
    unbook(berth);
    berths.push_back(berth);
  });
}

void Sleepers::book(uint32_t berth, vec3 gravity_step, vec3 pressed) {
  Sleeper& own = sleeper_[berth];
  const float g = std::sqrt(glm::dot(gravity_step, gravity_step));
  const vec3 left = own.load.impulse + pressed;
  if (!(g > 0) || left == vec3(0)) return unbook(berth);
  if (own.booked_on == kNoSlot) {
    own.booked_on = groundUnder(berth, gravity_step * (-1 / g));
    if (own.booked_on == kNoSlot) return;
    ++wallLoad(own.booked_on).bookings;
    own.booked = vec3(0);
  }
  WallLoad& load = wallLoad(own.booked_on);
  for (int axis = 0; axis < 3; ++axis) {
    ExactSum& sum = load.impulse[static_cast<size_t>(axis)];
    sum.add(-own.booked[axis]);
    sum.add(-left[axis]);
  }
  own.booked = -left;
}

void Sleepers::wake(uint32_t berth, std::vector<WokenPair>& pairs, std::vector<WokenWall>& walls,
                    std::vector<uint32_t>& partners) {
  unbook(berth);
  Sleeper& own = sleeper_[berth];
  for (uint32_t at = own.pairs, next = kNoSlot; at != kNoSlot; at = next) {
    const PairNode& node = pair_.node[at];
    next = node.nextOf(berth);
    const uint32_t other = node.other(berth);
    pairs.push_back({own.entity, sleeper_[other].entity, node.impulseOn(berth), rollingOn(berth, at)});
    uint32_t* link = &sleeper_[other].pairs;
    while (*link != at) link = &pair_.node[*link].nextOf(other);
    *link = node.nextOf(other);
    pair_.give(at);
    partners.push_back(other);
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
    dropIfIdle(load);
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

void Sleepers::trim() {
  const size_t smaller = need_.shrinks(count_, sleeper_.capacity());
  if (smaller == 0 || count_ > 0) return;  // berths keep their numbers
  sleeper_ = {};
  spot_ = {};
  free_ = kNoSlot;
  pair_ = {};
  rolling_ = {};
  wall_ = {};
  touches_ = {};
  bucket_ = {};
  occupied_ = {};
}

size_t Sleepers::memoryBytes() const {
  return materials_.memoryBytes() + sleeper_.capacity() * sizeof(Sleeper) + spot_.capacity() * sizeof(Spot) +
         pair_.node.capacity() * sizeof(PairNode) + rolling_.capacity() * sizeof(vec3) + wall_.node.capacity() * sizeof(WallNode) +
         wall_load_.capacity() * sizeof(WallLoad) + bucket_.capacity() * sizeof(uint32_t) +
         occupied_.capacity() * sizeof(uint64_t) + touches_.capacity() * sizeof(Touch);
}

}  // namespace scree::grains
