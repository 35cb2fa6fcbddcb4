// Rigid bodies in the solver: state, contacts with colliders and each other, sleep.
//
// A body answers an impulse J at arm r from its base with the velocity M J of the base and the spin
// G (r x J): its freedom is in M and G alone. Free: base = centre of mass, M = 1/m, G = inverse inertia.
// On a hinge: base = pivot, M = 0, G = a a^T / (moment about the line). On a slider: M = s s^T / m,
// G = 0. So joints need no passes and do not drift. Springs and resistances of joints are implicit: they
// add to the mass that M and G stand for.
//
// Grains are in contact with bodies by the lists of colliders. Slabs of the pair passes run in
// parallel, so the contacts with bodies awake are left out there and solved in a row after each pass,
// by slab, grain, collider.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/core/bytes.h"
#include "modules/grains/contacts.h"
#include "modules/grains/forces.h"
#include "modules/grains/rigid_form.h"

namespace scree::grains {

using glm::dmat3;
using glm::dquat;

enum class Freedom : uint32_t { Free, Hinge, Slider };

// One body over one tick, in and out; relative to the field's origin.
struct RigidRow {
  uint32_t key = 0;  // of its collider
  dvec3 position{0};  // of the collider
  quat rotation{1, 0, 0, 0};
  vec3 velocity{0};  // of the centre of mass
  vec3 spin{0};
  float density = 500, mass = 0;  // mass 0: by density
  float damping = 0;
  Freedom freedom = Freedom::Free;
  dvec3 pivot{0};  // of a hinge; home of a slider
  vec3 line{0, 0, 1};        // unit length, world axes
  vec3 line_local{0, 0, 1};  // of a hinge
  vec3 point_local{0};       // of a hinge: the pivot
  float stiffness = 0, resistance = 0, low = 0, high = 0;
  bool asleep = false;  // out
  bool lost = false;    // out: outside the bounds
};

struct Rigid {
  uint32_t key = 0;
  uint32_t collider = 0;  // index in this tick
  std::shared_ptr<const RigidForm> form;
  RigidRow row;
  double mass = 0;
  double eased = 1;   // mass that the solver uses / true mass: see ease()
  dvec3 centre{0};    // of mass, local
  dmat3 inertia{0};   // local, about the centre
  // State.
  dvec3 base{0};      // centre of mass, or the pivot
  dquat rotation{1, 0, 0, 0};
  dvec3 velocity{0};  // of the base
  dvec3 spin{0};
  // Of the substep.
  dmat3 give_linear{0}, give_angular{0};  // M, G
  dmat3 turned{1};    // world from local at its begin
  dvec3 position{0};  // of the collider then
  dvec3 velocity_before{0};
  dvec3 shift{0}, twist{0};  // how positions are put right
  double limit = 0;          // impulse of a slider's stop, N s
  double reach = 0;          // of the surface from the base, m
  // Of rest.
  bool asleep = false;
  bool slept = false;        // at the tick's begin
  bool rouse = false;        // wakes at the next tick's begin
  float still = 0;           // s
  double unbalanced = 0;     // change of velocity in the last substep, m/s
  dvec3 anchor{0};
  dquat anchor_rotation{1, 0, 0, 0};
  dvec3 borne{0};            // impulse of the grains when it fell asleep, N s a substep
  double borne_size = 0;
  // The lists of colliders are right while the collider's points are within `slack` of this pose.
  vec3 listed_position{0};
  quat listed_rotation{1, 0, 0, 0};
  float slack = 0;
};

// A point where a body touches a collider or another body.
struct RigidContact {
  uint32_t key_a = 0, key_b = 0, feature = 0;  // identify it
  uint32_t a = 0, b = kNoSlot;  // bodies; kNoSlot: b is a collider alone
  uint32_t collider = 0;        // of b
  dvec3 impulse{0};  // on a, N s
  dvec3 normal{0};   // towards a
  bool trusted = false;  // a substep old: its impulse is taken over
  // Of the substep.
  dvec3 arm_a{0}, arm_b{0};
  dvec3 surface{0};  // velocity of b's surface, beside what the body b has
  double gap = 0, approach = 0, friction = 0, restitution = 0;
  double give_normal = 0, give_across = 0;  // velocity an impulse, 1/kg
};

struct StepParameters;

class Rigids {
 public:
  bool empty() const { return body_.empty(); }
  bool anyAwake() const { return awake_ > 0; }
  std::span<const Rigid> bodies() const { return body_; }
  bool awake(const Collider& collider) const {
    return collider.rigid != kNoSlot && !body_[collider.rigid].asleep;
  }

  // The tick's begin: takes the rows over, and gives their colliders the poses that lists depend on.
  void begin(std::span<RigidRow> rows, std::span<Collider> colliders);
  // Wakes those asleep that what is around them wakes; true if any. `moved(k)`: collider k is new, or
  // changed, or moves.
  void wakeAll();
  bool wakeRoused(std::span<const Collider> colliders, std::span<const uint8_t> moved, vec3 gravity, float dt);
  void rouse(uint32_t key);
  // How far an awake body's surface goes in the tick if nothing stops it, m.
  float motionOf(const Rigid& body, vec3 gravity, float dt) const;

  // As GrainSolver::shareHeavyLoads(): a body has at least a thousandth of the mass of a grain or body that
  // it touches while it does; forces stay those of its true mass. Grains keep theirs: made heavier, those
  // under a boulder would throw their neighbours about.
  void ease(std::span<const ColliderSlab> slabs, const Bodies& grains);
  void predict(vec3 gravity_step, float h, std::span<const Force> forces);
  // Gives the colliders of bodies that may leave their slack within the substep new poses; true if any.
  bool relist(std::span<Collider> colliders, float h, float dt);
  // Poses at the substep's begin.
  void pose(std::span<PosedCollider> posed, std::span<const Collider> colliders) const;
  // One body's collider where the body is now.
  PosedCollider posed(const Collider& collider, PosedCollider was) const;
  // The collider of a body awake as one that stays where it is now, with all that the tick may bring.
  Collider overTick(Collider collider, vec3 gravity, float dt) const;
  void findContacts(std::span<const Collider> colliders, std::span<const PosedCollider> posed,
                    std::span<const ColliderLists::Swept> swept, float h, float dt);
  void applyKept(std::span<ColliderSlab> slabs, Body* grains, std::span<const Collider> colliders);
  void relax(std::span<ColliderSlab> slabs, Body* grains, std::span<const Collider> colliders,
             std::span<const PosedCollider> posed, const PassSettings& settings);
  void relaxContacts(const PassSettings& settings);
  // What bodies stand on has the last word, as colliders have for grains.
  void endPasses(PassSettings settings) {
    for (settings.standing = false; true; settings.standing = true) {
      for (int k = 0; k < kRounds; ++k) relaxContacts(settings);
      if (settings.standing) return;
    }
  }
  void move(vec3 gravity_step, float h);
  // Adds what contacts of bodies awake, or those of sleepers alone, press on colliders in so many substeps.
  void addLoads(std::span<Collider> colliders, bool awake, int times) const;
  // The tick's end: who falls asleep, whom to wake in the next tick. pressed() is filled before.
  void settle(float dt, vec3 gravity_step);
  void end(std::span<RigidRow> rows, const StepParameters& parameters);

  // By body, of the last substep.
  struct Pressed {
    dvec3 impulse{0};  // of the grains on it
    double size = 0;   // sum of the sizes of those impulses
    bool stirred = false;  // one of the grains is not still
  };
  std::vector<Pressed>& pressed() { return pressed_; }
  void scaleKept(double scale);
  uint32_t contactCount() const;
  uint64_t solved() const { return solved_; }

  // Of solver saves (saved.h).
  void save(ByteWriter& out) const;
  std::string restore(ByteReader& in);
  size_t memoryBytes() const;

 private:
  void ready(Rigid& body, const RigidRow& row, const Collider& collider);
  void place(Rigid& body) const;
  void freedom(Rigid& body, double h) const;
  void wakeBody(Rigid& body);
  uint32_t number(uint32_t key) const;
  void touch(uint32_t a, uint32_t b, uint32_t collider, std::span<const Collider> colliders,
             std::span<const PosedCollider> posed, float margin);
  void faceEachOther(const RigidForm& form, const PosedCollider& own, const RigidForm& other_form,
                     const PosedCollider& other);
  void thinOut(float reach);
  void features(const RigidForm& form, const PosedCollider& own, const PosedCollider& other, float margin,
                uint32_t base);
  void relaxGrain(ColliderContact& contact, Body& grain, Rigid& body, const PosedCollider& posed,
                  const PassSettings& settings, float& deepest);
  std::shared_ptr<const RigidForm> outline(const Collider& collider);

  std::vector<Rigid> body_;  // by key
  std::vector<Rigid> before_;
  uint32_t awake_ = 0;
  uint64_t solved_ = 0;
  std::vector<RigidContact> contact_, last_;  // by key_a, key_b, feature
  std::vector<Pressed> pressed_;
  static constexpr int kRounds = 4;  // of a pass: bodies are few, stand on each other, and bear many grains
  struct Candidate {
    uint32_t feature;
    vec3 point, normal;  // normal of the other's surface
    float distance;
    bool carried;
    vec3 normal_before{0};  // if it carried
  };
  std::vector<Candidate> candidate_;
  std::vector<float> distance_;  // of points, while their edges are looked at
  struct Outline {
    uint32_t key;
    Shape shape;
    vec3 half, a, b;
    float radius;
    const DistanceField* field;
    std::shared_ptr<const DistanceField> held;
    std::shared_ptr<const RigidForm> form;
    bool filled;
  };
  std::vector<Outline> outline_;  // by key
};

// Velocity of the body's material at an arm from its base, and what an impulse there does.
inline dvec3 velocityAt(const Rigid& body, const dvec3& arm) {
  return body.velocity + glm::cross(body.spin, arm);
}
inline void push(Rigid& body, const dvec3& arm, const dvec3& impulse) {
  body.velocity += body.give_linear * impulse;
  body.spin += body.give_angular * glm::cross(arm, impulse);
}
// Velocity along n at the arm, of an impulse of 1 N s along n there, 1/kg.
inline double giveAlong(const Rigid& body, const dvec3& arm, const dvec3& n) {
  const dvec3 torque = glm::cross(arm, n);
  return glm::dot(n, body.give_linear * n) + glm::dot(torque, body.give_angular * torque);
}
// The most that an impulse across n gives in its direction, 1/kg.
double giveAcross(const Rigid& body, const dvec3& arm, const dvec3& n);

// Distance of two rotations, as far as a point 1 m out may be moved (an upper bound).
inline double apartBy(const dquat& a, const dquat& b) {
  const dquat same = glm::dot(a, b) < 0 ? -b : b;
  return 2 * glm::length(same - a);
}

// Share of an overlap that a pass undoes, and the speed at which it does at most, m/s.
inline constexpr double kBodyProjection = 0.4, kBodyProjectionSpeed = 3;

}  // namespace scree::grains
