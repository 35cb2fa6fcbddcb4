// The store of sleepers to bytes and back: berths and list nodes are numbered anew, on which nothing
// depends; cells and the sums on colliders follow from the rest.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <tuple>

#include "modules/grains/saved.h"
#include "modules/grains/sleepers.h"
#include "modules/grains/solver.h"

namespace scree::grains {

void Sleepers::save(ByteWriter& out, std::vector<uint32_t>& saved_berth) const {
  saved_berth.assign(sleeper_.size(), kNoSlot);
  uint32_t next = 0, pairs = 0, walls = 0;
  out.number(count_);
  each([&](uint32_t berth) {
    saved_berth[berth] = next++;
    const Sleeper& own = sleeper_[berth];
    out.number(own.position);
    out.number(own.radius);
    out.number(own.entity);
    out.number(materialOf(berth));
    out.number(own.load);
    out.number(own.booked_on);
    out.number(own.booked);
    out.number(static_cast<uint8_t>(own.propped));
    for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].nextOf(berth)) ++pairs;
    for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next) ++walls;
  });
  out.number(pairs / 2);
  each([&](uint32_t berth) {
    for (uint32_t at = sleeper_[berth].pairs; at != kNoSlot; at = pair_.node[at].nextOf(berth)) {
      const PairNode& node = pair_.node[at];
      const uint32_t other = node.other(berth);
      if (other < berth) continue;
      out.number(saved_berth[berth]);
      out.number(saved_berth[other]);
      out.number(node.impulseOn(berth));
      out.number(rollingOn(berth, at));
    }
  });
  out.number(walls);
  each([&](uint32_t berth) {
    for (uint32_t at = sleeper_[berth].walls; at != kNoSlot; at = wall_.node[at].next) {
      const WallNode& node = wall_.node[at];
      out.number(saved_berth[berth]);
      out.number(node.key);
      out.number(node.impulse);
      out.number(node.rolling);
      out.number(node.normal);
      out.number(node.friction);
      out.number(node.pull);
    }
  });
}

std::string Sleepers::restore(ByteReader& in, uint32_t handles) {
  const auto count = in.number<uint32_t>();
  if (!in.has(count, 89)) return fmt::format("{} sleepers reach beyond the end", count);
  sleeper_.reserve(count);
  spot_.reserve(count);
  for (uint32_t k = 0; k < count; ++k) {
    Sleeper own;
    own.position = in.number<vec3>();
    own.radius = in.number<float>();
    own.entity = in.number<Entity>();
    const auto material = in.number<GrainMaterial>();
    own.load = in.number<Load>();
    own.booked_on = in.number<uint32_t>();
    own.booked = in.number<vec3>();
    own.propped = in.number<uint8_t>() != 0;
    if (!allowed(own.radius, material) || !finite(own.position) || own.entity.index >= handles)
      return fmt::format("sleeper {}: radius {} m, entity {} of {}, a material or a place that is not allowed",
                         k, own.radius, own.entity.index, handles);
    if (!finite(own.load.impulse) || !finite(own.load.moment) || !finite(own.load.carried) || !finite(own.booked))
      return fmt::format("sleeper {}: a load that is not finite", k);
    lay(own, material);
  }
  std::string wrong = restorePairs(in);
  if (wrong.empty()) wrong = restoreWalls(in);
  return wrong;
}

std::string Sleepers::restorePairs(ByteReader& in) {
  const auto count = in.number<uint32_t>();
  if (!in.has(count, 32)) return fmt::format("{} contacts of sleepers reach beyond the end", count);
  struct End {
    uint32_t owner, node;
  };
  std::vector<End> ends;
  ends.reserve(size_t{2} * count);
  pair_.node.reserve(count);
  for (uint32_t k = 0; k < count; ++k) {
    const auto a = in.number<uint32_t>(), b = in.number<uint32_t>();
    const auto impulse = in.number<vec3>(), rolling = in.number<vec3>();
    if (a >= b || b >= count_)
      return fmt::format("contact {} is of sleepers {} and {} of {}", k, a, b, count_);
    if (!finite(impulse) || !finite(rolling))
      return fmt::format("contact {} of sleepers has an impulse that is not finite", k);
    const auto node = static_cast<uint32_t>(pair_.node.size());
    ends.push_back({a, node});
    ends.push_back({b, node});
    // Which of the two is the first shows in the sign of a zero: nothing that rolls need not be kept.
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
    const bool turned = (bits(rolling.x) & bits(rolling.y) & bits(rolling.z)) == 0x80000000u && rolling == vec3(0);
    if (turned) {
      pair_.node.push_back({{b, a}, {kNoSlot, kNoSlot}, -impulse});
    } else {
      pair_.node.push_back({{a, b}, {kNoSlot, kNoSlot}, impulse});
      setRolling(node, rolling);
    }
  }
  std::sort(ends.begin(), ends.end(), [&](const End& a, const End& b) {
    if (a.owner != b.owner) return a.owner < b.owner;
    const uint32_t x = pair_.node[a.node].other(a.owner), y = pair_.node[b.node].other(b.owner);
    return std::tie(sleeper_[x].entity, x) < std::tie(sleeper_[y].entity, y);
  });
  for (size_t k = ends.size(); k-- > 0;) {  // from the last: each goes to the front of its list
    const uint32_t owner = ends[k].owner;
    uint32_t& first = sleeper_[owner].pairs;
    PairNode& node = pair_.node[ends[k].node];
    if (first != kNoSlot && pair_.node[first].other(owner) == node.other(owner))
      return fmt::format("sleepers {} and {} touch twice", owner, node.other(owner));
    node.nextOf(owner) = first;
    first = ends[k].node;
  }
  contacts_ += count;
  return {};
}

std::string Sleepers::restoreWalls(ByteReader& in) {
  const auto count = in.number<uint32_t>();
  if (!in.has(count, 52)) return fmt::format("{} sleepers on colliders reach beyond the end", count);
  std::vector<uint32_t> owner;
  owner.reserve(count);
  wall_.node.reserve(count);
  for (uint32_t k = 0; k < count; ++k) {
    owner.push_back(in.number<uint32_t>());
    WallNode node;
    node.key = in.number<uint32_t>();
    node.impulse = in.number<vec3>();
    node.rolling = in.number<vec3>();
    node.normal = in.number<vec3>();
    node.friction = in.number<float>();
    node.pull = in.number<float>();
    const bool later =
        k == 0 || owner[k - 1] < owner[k] ||
        (owner[k - 1] == owner[k] && wall_.node.back().key < node.key);
    if (owner[k] >= count_ || !later)
      return fmt::format("sleepers on colliders are out of order at {}: sleeper {} of {}", k, owner[k],
                         count_);
    if (!finite(node.impulse) || !finite(node.rolling) || !finite(node.normal) ||
        !(node.friction >= 0) || !(node.pull >= 0) || !finite(node.friction) || !finite(node.pull) ||
        !(glm::dot(node.normal, node.normal) < 1.01f))
      return fmt::format("sleeper {} presses on a collider with numbers that are not allowed", owner[k]);
    wall_.node.push_back(node);
  }
  for (uint32_t k = count; k-- > 0;) {
    uint32_t& first = sleeper_[owner[k]].walls;
    wall_.node[k].next = first;
    first = k;
  }
  std::vector<uint32_t> keys;
  keys.reserve(count);
  for (const WallNode& node : wall_.node) keys.push_back(colliderKey(node.key));
  each([&](uint32_t berth) {
    if (sleeper_[berth].booked_on != kNoSlot) keys.push_back(sleeper_[berth].booked_on);
  });
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (const uint32_t key : keys) wall_load_.push_back({key, 0, 0, {}});
  for (uint32_t k = 0; k < count; ++k) {
    const WallNode& node = wall_.node[k];
    const uint32_t key = colliderKey(node.key);
    WallLoad& load = wallLoad(key);
    bool again = false;  // the sleeper touches it at another point
    for (uint32_t other = k; other-- > 0 && owner[other] == owner[k];)
      again = again || colliderKey(wall_.node[other].key) == key;
    load.contacts += again ? 0 : 1;
    for (int axis = 0; axis < 3; ++axis)
      load.impulse[static_cast<size_t>(axis)].add(node.impulse[axis]);
  }
  each([&](uint32_t berth) {
    const Sleeper& own = sleeper_[berth];
    if (own.booked_on == kNoSlot) return;
    WallLoad& load = wallLoad(own.booked_on);
    ++load.bookings;
    for (int axis = 0; axis < 3; ++axis) load.impulse[static_cast<size_t>(axis)].add(own.booked[axis]);
  });
  contacts_ += count;
  return {};
}

}  // namespace scree::grains
