// The solver's neighbour searches: who takes part, margins, lists.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "modules/grains/company.h"
#include "modules/grains/solver.h"

namespace scree::grains {

// Chooses each grain's margin: how far it may go before the next search. A wide margin makes
// searches rare and lists long; see kLifetimes.
void GrainSolver::chooseMargins(float h) {
  const uint32_t n = bodies_.count;  // all awake
  // Margins are measured from the mean motion, so that what falls together needs no search. Sums
  // are of integers: they do not depend on the order of the grains.
  constexpr float kScale = 1024;
  int64_t sum[3] = {0, 0, 0};
  for (uint32_t k = 0; k < n; ++k)
    for (int axis = 0; axis < 3; ++axis)
      sum[axis] += static_cast<int64_t>(bodies_.body[k].velocity[axis] * kScale);
  const auto mean = [&](int axis) {
    return static_cast<float>(static_cast<double>(sum[axis]) / (kScale * static_cast<double>(n)));
  };
  drift_ = sleepers_.count() == 0 ? vec3(mean(0), mean(1), mean(2)) : vec3(0);
  if (glm::dot(drift_, drift_) < 0.25f) drift_ = vec3(0);
  drift_time_ = 0;

  // Wide margins make searches rare and lists long. How long depends on how dense what moves is: a
  // stream that falls has few neighbours however wide its margins. So the widths follow what came
  // of them: the age that the last lists reached, and their length.
  constexpr float kLongest = 8, kShortest = 1.5f;  // substeps that a search should last
  constexpr float kWidest = 0.3f, kNarrowest = 0.1f;  // least margin, radii
  constexpr uint64_t kManyPairs = 6;                // a grain
  const uint64_t pairs = pairs_.pair_count;
  if (pairs > kManyPairs * listed_awake_) {
    lifetime_ *= 0.8f;
    least_margin_ *= 0.9f;
  } else if (left_margin_ && age_ < 6) {
    lifetime_ *= 1.25f;
    least_margin_ *= 1.1f;
  } else if (age_ > 12) {
    least_margin_ *= 0.9f;
  }
  lifetime_ = std::clamp(lifetime_, kShortest, kLongest);
  least_margin_ = std::clamp(least_margin_, kNarrowest, kWidest);
  left_margin_ = false;
  age_ = 0;
  listed_awake_ = n;
  least_margin_way_ = 3e38f;
  for (uint32_t k = 0; k < n; ++k) {
    const float margin = bodies_.margin[k] = marginOf(bodies_.body[k], h);
    least_margin_way_ = std::min(least_margin_way_, margin);
  }
}

float GrainSolver::marginOf(const Body& grain, float h) const {
  const vec3 relative = grain.velocity - drift_;
  const float speed = std::sqrt(glm::dot(relative, relative));
  return std::min(least_margin_ * grain.radius + lifetime_ * h * speed, 4 * grain.radius);
}

// One fast grain in free flight would call for a search of all every other substep. Where a stray
// has come to nobody, its margin is laid around where it is now, and the lists
// stay as they are. False if a search is due.
bool GrainSolver::followStrays(float h) {
  if (strays_.size() > kMostStrays) return false;
  for (const uint32_t slot : strays_) {
    const Body& grain = bodies_.body[slot];
    const Reference reference{grain.position - drift_ * drift_time_, marginOf(grain, h)};
    const vec3 relative = grain.velocity - drift_;
    if (!(h * std::sqrt(glm::dot(relative, relative)) <= reference.margin)) return false;
    const float reach = grain.radius + reference.margin;
    if (!grid_.moveAlone(slot, reference.position, reach, met_) && !meetsOwnOnly(slot)) return false;
    bool meets = walls_.misses(slot, grid_.slabOf(slot), grain.position, reach);
    sleepers_.near(grain.position - reach, grain.position + reach, [&](uint32_t berth) {
      const Sleepers::Spot& spot = sleepers_.spot(berth);
      const vec3 d = spot.position - grain.position;
      const float sum = reach + spot.radius;
      meets = meets || (glm::dot(d, d) < sum * sum && sleepers_[berth].slot == kNoSlot);
    });
    if (meets) return false;
    bodies_.margin[slot] = reference.margin;
    least_margin_way_ = std::min(least_margin_way_, reference.margin);
  }
  return true;
}

// Keeps the bodies awake, chooses their margins, and adds the sleepers within reach. Returns the slots
// after that by those before, and in `were` the slots before of those awake.
std::span<uint32_t> GrainSolver::gatherNear(float h, std::span<uint32_t>& were) {
  const uint32_t listed = pairs_.bodyCount();
  const std::span<uint32_t> moved = workspace_.take<uint32_t>(bodies_.count, kNoSlot);
  were = workspace_.take<uint32_t>(bodies_.count);
  uint32_t n = 0;
  for (uint32_t k = 0; k < bodies_.count; ++k) {
    const uint32_t before = k < listed ? k : kNoSlot;
    if (!isAwake(bodies_, k)) {
      if (!isAsleep(bodies_, k)) continue;
      Sleeper& sleeper = sleepers_[bodies_.berth[k]];
      sleeper.slot = kNoSlot;
      if (std::exchange(sleeper.propped, false)) append(to_book_, bodies_.berth[k]);
      sleeper.slot_before = before;
      append(partners_, bodies_.berth[k]);
      continue;
    }
    moved[k] = n;
    were[n] = before;
    if (n != k) bodies_.move(k, n);
    ++n;
  }
  bodies_.cut(n);
  chooseMargins(h);
  for (uint32_t k = 0; k < n && sleepers_.count() > 0;) {
    Company company;
    while (k < n && company.admits(bodies_.body[k], bodies_.margin[k])) ++k;
    company.close();
    sleepers_.near(company.low(), company.high(), [&](uint32_t berth) {
      const Sleepers::Spot& spot = sleepers_.spot(berth);
      if (!company.reaches(spot.position, spot.radius)) return;
      Sleeper& sleeper = sleepers_[berth];
      if (sleeper.slot != kNoSlot) return;
      sleeper.slot = appendBody(sleeper.entity, sleepers_.materialOf(berth), sleeper.position, sleeper.radius);
      bodies_.berth[sleeper.slot] = berth;
      bodies_.body[sleeper.slot].inverse_mass = 0;
      bodies_.body[sleeper.slot].gravity_scale = 0;
    });
  }
  return moved;
}

// The lists of those awake, and of sleepers that something happens to, hold no more than there are bodies,
// but for the moment in which many wake or sleep.
void GrainSolver::trim(size_t bodies) {
  const auto trimmed = [&](auto&... list) { (fitTo(list, std::max(list.size(), std::min(list.capacity(), bodies))), ...); };
  trimmed(awake_, settled_, waking_, partners_, falling_, uneasy_, waiting_, to_book_, pressed_, touches_, touching_,
          woken_pairs_, woken_walls_, joining_pairs_, joining_walls_);
  sleepers_.trim();
}

void GrainSolver::padBodies() {
  const size_t n = bodies_.count, padded = n + size_t{grid_.slabCount()} * kIdleBodies;
  makeRoomFor(bodies_.body, padded);
  bodies_.body.resize(padded);
  for (size_t k = n; k < padded; ++k) {
    Body idle;
    idle.radius = 1;
    idle.position = vec3(1e6f * static_cast<float>((k - n) % kIdleBodies), 0, 0);
    bodies_.body[k] = idle;
  }
}

void GrainSolver::searchNeighbours(float h) {
  workspace_.reset();
  std::span<uint32_t> were;
  const std::span<uint32_t> moved = gatherNear(h, were);
  const uint32_t n = bodies_.count;
  trim(n);
  before_ = workspace_.take<uint32_t>(n);
  const std::span<uint32_t> slot_of = workspace_.take<uint32_t>(n);
  const std::span<uint32_t> order = grid_.plan(bodies_, workspace_);
  for (uint32_t k = 0; k < n; ++k) {
    const uint32_t from = order[k], berth = bodies_.berth[from];
    before_[k] = berth == kAwake ? were[from] : sleepers_[berth].slot_before;
    slot_of[from] = k;
    if (berth == kAwake) {
      place_[bodies_.entity[from].index] = k;
    } else {
      sleepers_[berth].slot = k;
    }
  }
  for (const uint32_t berth : partners_) sleepers_[berth].slot_before = kNoSlot;
  partners_.clear();
  bodies_.permute(order);
  padBodies();
  for (AwakeRow& awake : awake_) awake.slot = slot_of[moved[awake.slot]];
  clumps_.follow(moved, slot_of);
  workspace_.giveBack({});
  before_ = workspace_.keep(before_);
  const Workspace::Mark searched = workspace_.mark();
  grid_.keepSearch(workspace_);
  clumps_.mark(bodies_);
  joinWoken();
  grid_.read(bodies_);
  pairs_.build(grid_, bodies_, pairs_, before_, joining_pairs_, workspace_);
  workspace_.giveBack(searched);
  search_due_ = false;
  walls_due_ = true;
  searched_ = true;
  ++stats_.rebuilds;
}

// Gives the contacts that woken grains brought along the slots of now.
void GrainSolver::joinWoken() {
  joining_pairs_.clear();
  joining_walls_.clear();
  const auto slotOf = [&](Entity entity) {
    const uint32_t place = placeOf(entity);
    return place == kNoSlot || (place & kBerthBit) == 0 ? place
                                                        : sleepers_[place & ~kBerthBit].slot;
  };
  for (const WokenPair& pair : woken_pairs_) {
    const uint32_t a = slotOf(pair.a), b = slotOf(pair.b);
    if (a != kNoSlot && b != kNoSlot) joining_pairs_.push_back({a, b, pair.impulse, pair.rolling});
  }
  for (const WokenWall& wall : woken_walls_) {
    const uint32_t slot = slotOf(wall.grain);
    if (slot != kNoSlot)
      joining_walls_.push_back({slot, wall.key, wall.impulse, wall.rolling, wall.normal});
  }
  std::sort(joining_walls_.begin(), joining_walls_.end(),
            [](const JoiningWall& a, const JoiningWall& b) {
              return a.grain != b.grain ? a.grain < b.grain : a.key < b.key;
            });
  woken_pairs_.clear();
  woken_walls_.clear();
}

// Lists the grains near colliders; impulses are kept across this and across searches.
void GrainSolver::listColliders(std::span<const Collider> colliders, float dt, float h) {
  // With a drift the lists are made anew every tick, without it when a collider changes.
  const float extra = std::sqrt(glm::dot(drift_, drift_)) * dt;
  const Going going{extra, drift_ * drift_time_, drift_, h, h / dt};
  walls_.build(grid_, bodies_, colliders, going, searched_, before_, joining_walls_, workspace_);
  before_ = {};
  workspace_.giveBack({});
  searched_ = false;
  walls_due_ = false;
}

}  // namespace scree::grains
