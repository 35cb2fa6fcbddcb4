// The clumps of the solver: members' velocities made those of one rigid body, and members placed so.
//
// The passes know nothing of clumps: members answer impulses as free spheres, of a mass of their own
// (solver_mass). After the kept impulses, and after each pass, the impulses that the members took up are
// read off their velocities and given to the rigid body: linear and angular momentum are conserved. With
// solver_mass = mass that is the exact solution of the joint (projection onto rigid motion, which only
// lowers the energy), but a small member that bears a heavy clump would get there in as many passes as
// their masses differ; so some of the mass is lent to the small. It stays a relaxation of the same kind
// while the members, with these masses, are together no heavier, and no harder to turn, than the clump
// (mass splitting: Tonge, Benevolenski & Voroshilov 2012).
//
// Free rotation: the implicit midpoint rule of Austin, Krishnaprasad & Wang (1993) in the body's frame,
// which keeps angular momentum and energy.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/bodies.h"

namespace scree::grains {

// What is known of a clump beside its members' rows; of those only the arms and masses count.
struct Clump {
  uint32_t count = 0;
  std::array<Entity, kMostMembers> entity;
  std::array<vec3, kMostMembers> arm{};
  std::array<float, kMostMembers> radius{}, mass{}, solver_mass{};
  float total = 0;  // kg
  glm::dmat3 inertia{1}, inverse_inertia{1};  // at no rotation, kg m^2
  quat rotation{1, 0, 0, 0};
  bool moving = false;  // listed among those awake
};

// A clump of these spheres, about their centre of mass.
Clump makeClump(std::span<const Entity> entity, std::span<const vec3> arm, std::span<const float> radius,
                std::span<const float> mass);

class Clumps {
 public:
  bool empty() const { return clump_.empty(); }
  // Forgets all.
  void clear();
  uint32_t add(const Clump& clump);
  Clump& operator[](uint32_t at) { return clump_[at]; }
  const Clump& operator[](uint32_t at) const { return clump_[at]; }
  // kNoSlot: in no clump.
  uint32_t of(Entity entity) const {
    return entity.index < of_.size() ? of_[entity.index] : kNoSlot;
  }

  // A clump awake, in a substep.
  struct Moving {
    uint32_t clump = 0;
    std::array<uint32_t, kMostMembers> slot{};
    std::array<vec3, kMostMembers> reach{};  // from the centre of mass, world axes
    std::array<vec3, kMostMembers> given{};  // velocities, as last projected
    std::array<vec3, kMostMembers> place{};  // positions: at the substep's begin, then as placed
    dvec3 centre{0};
    vec3 velocity{0}, spin{0};
    vec3 velocity_before{0}, spin_before{0};  // at the substep's begin
    float pushed = 0;                         // m/s, by gravity and forces
    vec3 shift{0}, turn{0};                   // of overlaps, m and rad
    vec3 bounce{0};                           // m
    mat3 inverse_inertia{1};
  };
  std::span<const Moving> moving() const { return moving_; }
  void rouse(uint32_t clump, const std::array<uint32_t, kMostMembers>& slot);
  // Those of which goes(Moving) is true sleep now.
  template <class Goes>
  void rest(const Goes& goes) {
    std::erase_if(moving_, [&](const Moving& m) {
      const bool gone = goes(m);
      if (gone) clump_[m.clump].moving = false;
      return gone;
    });
  }
  // After a search: the members' slots from those before, and by slot who is in which clump.
  void follow(std::span<const uint32_t> moved, std::span<const uint32_t> slot_of);
  void mark(Bodies& bodies) const;

  // ---- Of each tick and substep, in this order.
  void giveMasses(Bodies& bodies) const;
  // Members share the strongest scale that shareHeavyLoads() gave one of them.
  void shareScales(Bodies& bodies) const;
  // What members were pushed by, and what others wrote to them, becomes rigid motion.
  void begin(Bodies& bodies);
  void project(Bodies& bodies);
  // Reads off how overlaps, and then bounces, shifted the members.
  void noteShifts(const Bodies& bodies);
  void noteBounces(const Bodies& bodies);
  // After the members were moved: moves the clumps instead. `keep`: share of the velocities that stays.
  void place(Bodies& bodies, vec3 gravity_step, float h, float keep);
  // After a guard took members back, the clump goes as far: true if any did.
  bool mend(Bodies& bodies);

  size_t memoryBytes() const;

 private:
  template <class Visit>
  void each(const Visit& visit);

  std::vector<Clump> clump_;
  std::vector<uint32_t> of_;  // by entity index
  std::vector<Moving> moving_;
};

}  // namespace scree::grains
