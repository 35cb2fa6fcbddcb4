// Sleepers beside grains awake: what presses on them changes, and their contacts follow, or they wake.
//
// A packing with friction can bear the same load in many ways, and the impulses of those awake wander
// among them. A sleeper that woke whenever they had wandered far would be let go with all that had
// come together, push its neighbours, and wake them in turn. So its contacts are first changed as
// little as balances it, which passes the change on to its neighbours asleep and, as the reaction, to
// those awake; it wakes if contacts that press, within Coulomb's limit, cannot hold it.
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "modules/grains/cohesion.h"
#include "modules/grains/rest.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

using dvec3 = glm::dvec3;

using glm::length;

// Whether more than a share of what is allowed is left over.
bool uneasy(const Load& load, float weight, float share = 1) {
  const float most = share * (kUneasy * weight + kUneasyShare * load.carried);
  return !(glm::dot(load.impulse, load.impulse) <= most * most) ||
         !(glm::dot(load.moment, load.moment) <= most * most);
}

void addTouch(Load& load, const Touch& touch) {
  load.impulse += touch.impulse;
  load.moment += glm::cross(touch.arm, touch.impulse);
  load.carried += length(touch.impulse);
}

// The changes w (l + m x a) of what touches, a = its arm and w = the impulse's size, that take force and moment
// off: the least sum of change^2 / w. Normal equations of l and m, by Cholesky.
class LeastChange {
 public:
  void add(const Touch& touch) {
    const dvec3 a(touch.arm);
    const double w = static_cast<double>(length(touch.impulse));
    // Columns of the cross product with a, and of its square.
    const double x[3][3] = {{0, -a.z, a.y}, {a.z, 0, -a.x}, {-a.y, a.x, 0}};
    const double square = glm::dot(a, a);
    for (size_t r = 0; r < 3; ++r) {
      matrix_[r][r] += w;
      for (size_t c = 0; c < 3; ++c) {
        const int ar = static_cast<int>(r), ac = static_cast<int>(c);
        matrix_[3 + r][c] += w * x[r][c];
        matrix_[3 + r][3 + c] += w * ((r == c ? square : 0.0) - a[ar] * a[ac]);
      }
    }
  }
  // False if nothing touches.
  bool solve(vec3 force, vec3 moment) {
    double trace = 0;
    for (size_t k = 0; k < 6; ++k) trace += matrix_[k][k];
    if (!(trace > 0)) return false;
    for (size_t k = 0; k < 6; ++k) matrix_[k][k] += 1e-6 * trace;  // few contacts: singular
    std::array<double, 6> x{-force.x, -force.y, -force.z, -moment.x, -moment.y, -moment.z};
    for (size_t c = 0; c < 6; ++c) {
      for (size_t k = 0; k < c; ++k) matrix_[c][c] -= matrix_[c][k] * matrix_[c][k];
      matrix_[c][c] = std::sqrt(matrix_[c][c]);
      for (size_t r = c + 1; r < 6; ++r) {
        for (size_t k = 0; k < c; ++k) matrix_[r][c] -= matrix_[r][k] * matrix_[c][k];
        matrix_[r][c] /= matrix_[c][c];
      }
    }
    for (size_t r = 0; r < 6; ++r) {
      for (size_t k = 0; k < r; ++k) x[r] -= matrix_[r][k] * x[k];
      x[r] /= matrix_[r][r];
    }
    for (size_t r = 6; r-- > 0;) {
      for (size_t k = r + 1; k < 6; ++k) x[r] -= matrix_[k][r] * x[k];
      x[r] /= matrix_[r][r];
    }
    l_ = {x[0], x[1], x[2]};
    m_ = {x[3], x[4], x[5]};
    return true;
  }
  vec3 changeOf(const Touch& touch) const {
    return vec3(static_cast<double>(length(touch.impulse)) * (l_ + glm::cross(m_, dvec3(touch.arm))));
  }

 private:
  double matrix_[6][6] = {};  // its lower half
  dvec3 l_{0}, m_{0};
};

// The impulse with the part along the normal and as much across as the contact can bear.
vec3 bearablePart(const Touch& touch, vec3 impulse, float h) {
  const float along = glm::dot(touch.normal, impulse), grip = touch.pull * h;
  const float n = std::max(along, -grip);
  const vec3 across = impulse - along * touch.normal;
  const float size = length(across), most = touch.friction * (n + grip);
  return n * touch.normal + (size > most ? most / size : 1.0f) * across;
}

// What Coulomb's limit cuts off is sought again, at most so often, to a tenth of what is allowed.
constexpr int kTurns = 4;
constexpr float kAim = 0.1f;

}  // namespace

float Sleepers::pullBetween(uint32_t a, uint32_t b) const {
  return pullOf(materialOf(a).cohesion, materialOf(b).cohesion,
                reducedRadius(sleeper_[a].radius, sleeper_[b].radius));
}

Balance Sleepers::balance(uint32_t berth, vec3 gravity_step, float h, std::span<Touch> outer,
                          std::vector<uint32_t>& touched) {
  // Arms are measured from the centre of mass, in radii of the largest member.
  float mass = 0, size = 0;
  vec3 centre(0);
  eachOfClump(berth, [&](uint32_t member) {
    const Sleeper& own = sleeper_[member];
    const float m = massOf(member);
    mass += m;
    centre += m * own.position;
    size = std::max(size, own.radius);
  });
  centre /= mass;
  const auto fromCentre = [&](uint32_t member) { return (sleeper_[member].position - centre) / size; };
  const auto armOf = [&](uint32_t member, vec3 normal) {
    return fromCentre(member) - normal * (sleeper_[member].radius / size);
  };
  Load load;
  eachOfClump(berth, [&](uint32_t member) {
    const Sleeper& own = sleeper_[member];
    load.impulse += own.load.impulse;
    load.moment += (own.radius / size) * own.load.moment + glm::cross(fromCentre(member), own.load.impulse);
    load.carried += own.load.carried;
  });
  const float weight = mass * length(gravity_step), carried = load.carried;
  for (Touch& touch : outer) {
    touch.arm = armOf(touch.berth, touch.normal);
    addTouch(load, touch);
  }
  if (!uneasy(load, weight)) return Balance::Held;
  const auto beyond = [&](float most) { return !(glm::dot(load.impulse, load.impulse) <= most * most); };
  const Balance lost = beyond(std::max(kBlow * (weight + load.carried), kFalls * weight)) ? Balance::Struck : Balance::Lost;
  // Not a wandering, but a blow.
  if (beyond(kBlow * (weight + carried))) return lost;

  touches_.assign(outer.begin(), outer.end());
  eachOfClump(berth, [&](uint32_t member) {
    const Sleeper& own = sleeper_[member];
    for (uint32_t at = own.pairs; at != kNoSlot; at = pair_.node[at].nextOf(member)) {
      const uint32_t partner = pair_.node[at].other(member);
      const Sleeper& other = sleeper_[partner];
      const vec3 normal = normalOf(own, other);
      touches_.push_back({member, normal, pair_.node[at].impulseOn(member),
                          std::sqrt(materialOf(member).friction * materialOf(partner).friction),
                          pullBetween(member, partner), armOf(member, normal)});
    }
    for (uint32_t at = own.walls; at != kNoSlot; at = wall_.node[at].next) {
      const WallNode& node = wall_.node[at];
      touches_.push_back({member, node.normal, node.impulse, node.friction, node.pull,
                          armOf(member, node.normal)});
    }
  });

  for (int turn = 0; turn < kTurns && (turn == 0 || uneasy(load, weight, kAim)); ++turn) {
    LeastChange least;
    for (const Touch& touch : touches_) least.add(touch);
    if (!least.solve(load.impulse, load.moment)) return lost;
    for (Touch& touch : touches_) {
      const vec3 before = touch.impulse;
      touch.impulse = bearablePart(touch, touch.impulse + least.changeOf(touch), h);
      const vec3 change = touch.impulse - before;
      load.impulse += change;
      load.moment += glm::cross(touch.arm, change);
    }
  }
  if (uneasy(load, weight)) return lost;

  size_t k = outer.size();
  std::copy_n(touches_.begin(), k, outer.begin());
  eachOfClump(berth, [&](uint32_t member) {
    for (uint32_t at = sleeper_[member].pairs; at != kNoSlot; at = pair_.node[at].nextOf(member), ++k) {
      PairNode& node = pair_.node[at];
      node.impulse = node.side(member) == 0 ? touches_[k].impulse : -touches_[k].impulse;
      const uint32_t other = node.other(member);
      weigh(other, gravity_step);
      touched.push_back(firstOf(other));
    }
    for (uint32_t at = sleeper_[member].walls; at != kNoSlot; at = wall_.node[at].next, ++k)
      pressWall(wall_.node[at], touches_[k].impulse);
    weigh(member, gravity_step);
  });
  return Balance::Held;
}

// Sleepers on which those awake press otherwise than before.
void GrainSolver::findUnbalanced(vec3 gravity_step) {
  if (sleepers_.count() == 0) return;
  size_t borders = 0, contacts = 0;
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) borders += pairs_.slab[s].border.size();
  const Workspace::Mark before = workspace_.mark();
  border_ = workspace_.take<BorderContact>(borders);
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    const PairSlab& slab = pairs_.slab[s];
    for (const uint32_t c : slab.border) {
      const bool first = isAsleep(bodies_, slab.i[c]);
      const uint32_t sleeper = first ? slab.i[c] : slab.j[c], other = first ? slab.j[c] : slab.i[c];
      if (!isAsleep(bodies_, sleeper) || !isAwake(bodies_, other)) continue;
      border_[contacts++] = {bodies_.entity[sleeper], bodies_.entity[other], bodies_.berth[sleeper], s, c, first};
    }
  }
  border_ = border_.first(contacts);
  std::sort(border_.begin(), border_.end(), [](const BorderContact& a, const BorderContact& b) {
    return a.sleeper != b.sleeper ? a.sleeper < b.sleeper : a.other < b.other;
  });
  uneasy_.clear();
  falling_.assign(to_book_.begin(), to_book_.end());
  to_book_.clear();
  pressed_.clear();
  for (size_t k = 0; k < border_.size(); ++k) {
    const BorderContact& contact = border_[k];
    Sleeper& sleeper = sleepers_[contact.berth];
    if (k == 0 || contact.berth != border_[k - 1].berth) {
      append(uneasy_, sleepers_.firstOf(contact.berth));
      if (std::exchange(sleeper.propped, false)) append(falling_, contact.berth);
      append(pressed_, {contact.berth, vec3(0)});
    }
    const vec3 impulse = pairs_.slab[contact.slab].impulseAt(contact.contact);
    sleeper.propped = sleeper.propped || impulse != vec3(0);
    pressed_.back().impulse += contact.first ? impulse : -impulse;
  }
  const bool may_wake = mayChangeSleepers();
  if (may_wake) {
    for (const uint32_t berth : waiting_) append(uneasy_, berth);
    waiting_.clear();
  }
  // Each round lets the imbalance spread by a grain; what is left is small, and waits for the next tick.
  size_t struck = 0;
  for (int round = 0; round < kSpread && !uneasy_.empty(); ++round) {
    inOrder(uneasy_);
    partners_.clear();
    for (const uint32_t berth : uneasy_) {
      gatherTouches(berth);
      const Balance found = sleepers_.balance(berth, gravity_step, last_h_, touches_, partners_);
      if (found != Balance::Held) {
        struck += found == Balance::Struck;
        append(may_wake ? waking_ : waiting_, berth);
        continue;
      }
      sleepers_.eachOfClump(berth, [&](uint32_t member) { append(falling_, member); });
      for (size_t k = 0; k < touches_.size(); ++k) {
        const BorderContact& contact = *touching_[k];
        pairs_.slab[contact.slab].setImpulse(contact.contact,
                                             contact.first ? touches_[k].impulse : -touches_[k].impulse);
      }
    }
    for (const uint32_t berth : partners_)
      sleepers_.eachOfClump(berth, [&](uint32_t member) { append(falling_, member); });
    std::swap(uneasy_, partners_);
  }
  if (struck * kFew > awake_.size()) waking_.insert(waking_.end(), waiting_.begin(), waiting_.end());
  if (!waking_.empty()) calm_ = 0;
  partners_.clear();
  border_ = {};
  workspace_.giveBack(before);
  bookLeftOver(gravity_step);
  for (const Pressed& pressed : pressed_) sleepers_.book(pressed.berth, gravity_step, pressed.impulse);
}

// By entity, each once.
void GrainSolver::inOrder(std::vector<uint32_t>& berths) const {
  std::sort(berths.begin(), berths.end(), [&](uint32_t a, uint32_t b) {
    return sleepers_[a].entity < sleepers_[b].entity;
  });
  berths.erase(std::unique(berths.begin(), berths.end()), berths.end());
}

// In touches_ and touching_: the contacts of a sleeper, or of its clump, with grains awake.
void GrainSolver::gatherTouches(uint32_t first) {
  touches_.clear();
  touching_.clear();
  sleepers_.eachOfClump(first, [&](uint32_t berth) {
    auto at = std::lower_bound(
        border_.begin(), border_.end(), sleepers_[berth].entity,
        [](const BorderContact& contact, Entity entity) { return contact.sleeper < entity; });
    for (; at != border_.end() && at->berth == berth; ++at) {
      const PairSlab& slab = pairs_.slab[at->slab];
      const Body &i = bodies_.body[slab.i[at->contact]], &j = bodies_.body[slab.j[at->contact]];
      const vec3 d = i.position - j.position;
      const float sign = at->first ? 1.0f : -1.0f, distance = std::max(length(d), 1e-18f);
      touches_.push_back({berth, d * (sign / distance), sign * slab.impulseAt(at->contact),
                          i.friction_root * j.friction_root, slab.pullAt(at->contact), vec3(0)});
      touching_.push_back(&*at);
    }
  });
}

}  // namespace scree::grains
