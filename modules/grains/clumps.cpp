// Clumps as rigid bodies: masses, projection onto rigid motion, free rotation, placing.
#include "modules/grains/clumps.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

using glm::dmat3;
using glm::dquat;

// Clumps a task, and fewer than which are not worth a second thread.
constexpr size_t kClumpChunk = 256, kFewClumps = 512;

// Inertia of a solid sphere of mass m about a point that is `arm` away.
dmat3 inertiaAt(double m, dvec3 arm, double radius) {
  const double square = glm::dot(arm, arm) + 0.4 * radius * radius;
  return m * (dmat3(square) - glm::outerProduct(arm, arm));
}

// The most that a member of solver mass 1 answers an impulse, set against a free sphere of mass 1: an
// upper bound of the largest eigenvalue (its translation's plus its rotation's).
double answerOf(const Clump& clump, uint32_t k) {
  const dmat3 d = clump.inverse_inertia * inertiaAt(1, dvec3(clump.arm[k]), clump.radius[k]);
  const dmat3 square = d * d;
  return 1.0 / static_cast<double>(clump.total) +
         std::sqrt(std::max(0.0, square[0][0] + square[1][1] + square[2][2]));
}

void chooseSolverMasses(Clump& clump) {
  const double n = clump.count;
  float least = clump.mass[0];
  for (uint32_t k = 1; k < clump.count; ++k) least = std::min(least, clump.mass[k]);
  const double lent = 0.5 * std::clamp(1 - n * static_cast<double>(least / clump.total), 0.0, 1.0);
  for (uint32_t k = 0; k < clump.count; ++k)
    clump.solver_mass[k] = static_cast<float>((1 - lent) * static_cast<double>(clump.mass[k]) +
                                              lent / (n * answerOf(clump, k)));
}

// Adds to `shift` what it lacks along `way` to be as far.
void goAlong(vec3& shift, vec3 way) {
  const float length = glm::length(way);
  if (!(length > 0)) return;
  const vec3 direction = way / length;
  shift += std::max(0.0f, length - glm::dot(shift, direction)) * direction;
}

// The angular momentum in the body's frame in the middle of h seconds of free rotation.
dvec3 midMomentum(dvec3 momentum, const dmat3& inverse_inertia, double h) {
  constexpr int kMost = 12;
  const double square = glm::dot(momentum, momentum);
  dvec3 middle = momentum;
  for (int k = 0; k < kMost; ++k) {
    const dvec3 last = middle;
    middle = momentum + 0.5 * h * glm::cross(last, inverse_inertia * last);
    // The mean of two vectors of one length is no longer than they: so fast a spin stays finite.
    const double now = glm::dot(middle, middle);
    if (now > square) middle *= std::sqrt(square / now);
    const dvec3 change = middle - last;
    if (glm::dot(change, change) <= 1e-28 * square) break;
  }
  return middle;
}

dquat turned(dquat q, dvec3 half) { return glm::normalize(q + dquat(0, half.x, half.y, half.z) * q); }

}  // namespace

Clump makeClump(std::span<const Entity> entity, std::span<const vec3> arm, std::span<const float> radius,
                std::span<const float> mass) {
  Clump clump;
  clump.count = static_cast<uint32_t>(entity.size());
  double total = 0;
  dvec3 centre(0);
  for (size_t k = 0; k < entity.size(); ++k) {
    total += static_cast<double>(mass[k]);
    centre += static_cast<double>(mass[k]) * dvec3(arm[k]);
  }
  centre /= total;
  clump.total = static_cast<float>(total);
  clump.inertia = dmat3(0);
  for (size_t k = 0; k < entity.size(); ++k) {
    clump.entity[k] = entity[k];
    clump.arm[k] = vec3(dvec3(arm[k]) - centre);
    clump.radius[k] = radius[k];
    clump.mass[k] = mass[k];
    clump.inertia += inertiaAt(mass[k], dvec3(clump.arm[k]), radius[k]);
  }
  clump.inverse_inertia = glm::inverse(clump.inertia);
  chooseSolverMasses(clump);
  return clump;
}

void Clumps::clear() {
  for (const Clump& clump : clump_)
    for (uint32_t k = 0; k < clump.count; ++k) of_[clump.entity[k].index] = kNoSlot;
  clump_.clear();
  moving_.clear();
}

uint32_t Clumps::add(const Clump& clump) {
  const auto at = static_cast<uint32_t>(clump_.size());
  clump_.push_back(clump);
  for (uint32_t k = 0; k < clump.count; ++k) {
    const uint32_t index = clump.entity[k].index;
    if (index >= of_.size()) of_.resize(std::max<size_t>(index + 1, of_.size() + of_.size() / 8), kNoSlot);
    of_[index] = at;
  }
  return at;
}

void Clumps::rouse(uint32_t clump, const std::array<uint32_t, kMostMembers>& slot) {
  clump_[clump].moving = true;
  Moving moving;
  moving.clump = clump;
  moving.slot = slot;
  moving_.push_back(moving);
}

void Clumps::follow(std::span<const uint32_t> moved, std::span<const uint32_t> slot_of) {
  for (Moving& m : moving_)
    for (uint32_t k = 0; k < clump_[m.clump].count; ++k) m.slot[k] = slot_of[moved[m.slot[k]]];
}

void Clumps::mark(Bodies& bodies) const {
  bodies.clump.clear();
  if (moving_.empty()) return;
  refill(bodies.clump, bodies.count, kNoSlot);
  for (const Moving& m : moving_)
    for (uint32_t k = 0; k < clump_[m.clump].count; ++k) bodies.clump[m.slot[k]] = m.clump;
}

template <class Visit>
void Clumps::each(const Visit& visit) {
  parallelChunks(moving_.size(), kClumpChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t at = begin; at < end; ++at) visit(clump_[moving_[at].clump], moving_[at]);
  }, worthOf(moving_.size(), kFewClumps));
}

void Clumps::giveMasses(Bodies& bodies) const {
  for (const Moving& m : moving_)
    for (uint32_t k = 0; k < clump_[m.clump].count; ++k)
      bodies.body[m.slot[k]].inverse_mass = 1 / clump_[m.clump].solver_mass[k];
}

void Clumps::shareScales(Bodies& bodies) const {
  for (const Moving& m : moving_) {
    const Clump& clump = clump_[m.clump];
    float scale = 1;
    for (uint32_t k = 0; k < clump.count; ++k)
      scale = std::min(scale, bodies.body[m.slot[k]].gravity_scale);
    for (uint32_t k = 0; k < clump.count; ++k) {
      bodies.body[m.slot[k]].inverse_mass = scale / clump.solver_mass[k];
      bodies.body[m.slot[k]].gravity_scale = scale;
    }
  }
}

void Clumps::begin(Bodies& bodies) {
  each([&](Clump& clump, Moving& m) {
    // In double: what is lost here is lost in each substep.
    const dmat3 world_from_clump = glm::mat3_cast(dquat(clump.rotation));
    const dmat3 inverse_inertia = world_from_clump * clump.inverse_inertia * glm::transpose(world_from_clump);
    m.inverse_inertia = mat3(inverse_inertia);
    dvec3 centre(0), velocity(0), before(0), momentum(0);
    for (uint32_t k = 0; k < clump.count; ++k) {
      const Body& body = bodies.body[m.slot[k]];
      m.place[k] = body.position;
      const dvec3 reach = world_from_clump * dvec3(clump.arm[k]);
      m.reach[k] = vec3(reach);
      const double mass = clump.mass[k], radius = clump.radius[k];
      centre += mass * dvec3(body.position);
      velocity += mass * dvec3(body.velocity);
      before += mass * dvec3(body.velocity_before);
      momentum += mass * (glm::cross(reach, dvec3(body.velocity)) + 0.4 * radius * radius * dvec3(body.spin));
    }
    const double inverse = 1 / static_cast<double>(clump.total);
    m.centre = inverse * centre;
    m.velocity = vec3(inverse * velocity);
    m.velocity_before = vec3(inverse * before);
    m.pushed = glm::length(m.velocity - m.velocity_before);
    m.spin = m.spin_before = vec3(inverse_inertia * momentum);
    m.shift = m.turn = m.bounce = vec3(0);
    for (uint32_t k = 0; k < clump.count; ++k) {
      Body& body = bodies.body[m.slot[k]];
      body.velocity = m.given[k] = m.velocity + glm::cross(m.spin, m.reach[k]);
      body.spin = m.spin;
    }
  });
}

void Clumps::project(Bodies& bodies) {
  each([&](Clump& clump, Moving& m) {
    bool touched = false;
    for (uint32_t k = 0; k < clump.count; ++k) {
      const Body& body = bodies.body[m.slot[k]];
      touched = touched || body.velocity != m.given[k] || body.spin != m.spin;
    }
    if (!touched) return;
    vec3 impulse(0), moment(0);
    for (uint32_t k = 0; k < clump.count; ++k) {
      const Body& body = bodies.body[m.slot[k]];
      const vec3 taken = clump.solver_mass[k] * (body.velocity - m.given[k]);
      impulse += taken;
      moment += glm::cross(m.reach[k], taken) +
                0.4f * clump.solver_mass[k] * clump.radius[k] * clump.radius[k] * (body.spin - m.spin);
    }
    m.velocity += impulse / clump.total;
    m.spin += m.inverse_inertia * moment;
    for (uint32_t k = 0; k < clump.count; ++k) {
      Body& body = bodies.body[m.slot[k]];
      body.velocity = m.given[k] = m.velocity + glm::cross(m.spin, m.reach[k]);
      body.spin = m.spin;
    }
  });
}

void Clumps::noteShifts(const Bodies& bodies) {
  each([&](Clump& clump, Moving& m) {
    vec3 sum(0), moment(0);
    for (uint32_t k = 0; k < clump.count; ++k) {
      const vec3 at = bodies.body[m.slot[k]].position;
      const vec3 shift = clump.solver_mass[k] * (at - m.place[k]);
      sum += shift;
      moment += glm::cross(m.reach[k], shift);
      m.place[k] = at;
    }
    m.shift = sum / clump.total;
    constexpr float kMostTurn = 0.5f;  // rad
    m.turn = m.inverse_inertia * moment;
    const float turn = glm::length(m.turn);
    if (turn > kMostTurn) m.turn *= kMostTurn / turn;
  });
}

// A bounce displaces a member so that the move takes it to where the impact leaves it: the clump as a
// whole.
void Clumps::noteBounces(const Bodies& bodies) {
  each([&](Clump& clump, Moving& m) {
    for (uint32_t k = 0; k < clump.count; ++k)
      goAlong(m.bounce, bodies.body[m.slot[k]].position - m.place[k]);
  });
}

// As GrainSolver::move() does with grains, by the mean of the velocities where nothing but gravity and
// forces changed them, else by those after.
void Clumps::place(Bodies& bodies, vec3 gravity_step, float h, float keep) {
  each([&](Clump& clump, Moving& m) {
    const vec3 change = m.velocity - m.velocity_before;
    const float smooth = 1.01f * std::max(glm::length(gravity_step), m.pushed);
    const float half = glm::dot(change, change) <= smooth * smooth ? 0.5f : 0.0f;
    const dvec3 centre = m.centre + dvec3(m.shift + m.bounce + h * (m.velocity - half * change));

    const dmat3 start = glm::mat3_cast(dquat(clump.rotation));
    const auto momentumOf = [&](vec3 spin) { return start * (clump.inertia * (dvec3(spin) * start)); };
    const dvec3 momentum = momentumOf(m.spin);
    const dvec3 on_the_way = half == 0 ? momentum : momentumOf(m.spin - half * (m.spin - m.spin_before));
    const dquat corrected = turned(dquat(clump.rotation), 0.5 * dvec3(m.turn));
    const dvec3 middle = midMomentum(on_the_way * glm::mat3_cast(corrected), clump.inverse_inertia, h);
    const dvec3 half_turn = 0.5 * static_cast<double>(h) * (clump.inverse_inertia * middle);
    clump.rotation =
        quat(glm::normalize(corrected + corrected * dquat(0, half_turn.x, half_turn.y, half_turn.z)));
    const dmat3 end = glm::mat3_cast(dquat(clump.rotation));
    vec3 spin = vec3(end * (clump.inverse_inertia * (momentum * end)));
    vec3 velocity = m.velocity;

    // Only numbers beyond all physics are zeroed; they must not spread.
    float fastest = glm::dot(velocity, velocity);
    for (uint32_t k = 0; k < clump.count; ++k) {
      const vec3 v = velocity + glm::cross(spin, vec3(end * dvec3(clump.arm[k])));
      fastest = std::max({fastest, glm::dot(v, v),
                          glm::dot(spin, spin) * clump.radius[k] * clump.radius[k]});
      if (!(glm::dot(v, v) <= kMostSpeed * kMostSpeed)) fastest = 3e38f;
    }
    if (!(fastest <= kMostSpeed * kMostSpeed)) velocity = spin = vec3(0);
    for (uint32_t k = 0; k < clump.count; ++k) {
      Body& body = bodies.body[m.slot[k]];
      const dvec3 reach = end * dvec3(clump.arm[k]);
      body.position = m.place[k] = vec3(centre + reach);
      body.velocity = keep * (velocity + glm::cross(spin, vec3(reach)));
      body.spin = keep * spin;
    }
  });
}

bool Clumps::mend(Bodies& bodies) {
  bool any = false;
  for (Moving& m : moving_) {
    const Clump& clump = clump_[m.clump];
    vec3 back(0);
    for (uint32_t k = 0; k < clump.count; ++k)
      goAlong(back, bodies.body[m.slot[k]].position - m.place[k]);
    if (back == vec3(0)) continue;
    any = true;
    for (uint32_t k = 0; k < clump.count; ++k)
      bodies.body[m.slot[k]].position = m.place[k] = m.place[k] + back;
  }
  return any;
}

size_t Clumps::memoryBytes() const {
  return clump_.capacity() * sizeof(Clump) + 4 * of_.capacity() + moving_.capacity() * sizeof(Moving);
}

}  // namespace scree::grains
