// The grain solver over plain spans: one step moves all grains by one tick. No ECS storage, no GL.
//
// A substep: predict velocities; search neighbours again if a grain left its margin; apply the kept
// impulses; some passes over all contacts; move. Contacts are grouped in slabs, one a layer of grid
// cells along z. A slab's contacts touch grains of that slab and the next only, so all even slabs
// may run at once, then all odd ones; inside a slab the order is fixed. No result depends on the
// thread count, nor on the order of the rows: grains are sorted by cell, then by entity.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/collider.h"
#include "modules/grains/contacts.h"
#include "modules/grains/grains.h"
#include "modules/grains/grid.h"

namespace scree::grains {

// The longest tick that is simulated, s; a longer one is cut to it.
inline constexpr float kLongestTick = 0.1f;
// What a grain may measure; others are refused. Mass and its inverse stay far inside float's range.
inline constexpr float kLeastRadius = 1e-5f, kMostRadius = 1e4f;      // m
inline constexpr float kLeastDensity = 1e-3f, kMostDensity = 1e6f;    // kg/m^3
inline constexpr float kMostSpeed = 1e5f;                             // m/s and rad/s at the surface
inline constexpr float kMostDistance = 1e9f;                          // from the field's origin, m

// Rows of one table; all spans have the same length.
struct GrainRows {
  std::span<const Entity> entity;
  std::span<Grain> grain;
  std::span<GrainVelocity> velocity;
  std::span<GrainSpin> spin;
  std::span<GrainOrientation> orientation;
  std::span<GrainPrevious> previous;
  std::span<const GrainMaterial> material;
  std::span<GrainRest> rest;  // empty: these grains never sleep
};

// Which instructions the pair passes use; the results are the same to the bit.
enum class Lanes : uint32_t { Widest, Baseline };

struct StepParameters {
  float dt = 1.0f / 60;  // s; 0 or less, or NaN: nothing happens
  vec3 gravity{0, -9.81f, 0};
  int substeps = 4;
  int passes = 3;
  float damping = 0;  // 1/s
  vec3 bounds_min{-500, -50, -500}, bounds_max{500, 500, 500};
  Lanes lanes = Lanes::Widest;
};

class GrainSolver {
 public:
  // Advances all rows by one tick. Colliders' `load` fields are written.
  void step(std::span<const GrainRows> tables, std::span<Collider> colliders,
            const StepParameters& parameters);

  // A tick in which all grains sleep on and nothing is searched or solved: true, and the colliders
  // have their loads. False if something may wake: step() is due. The rows must be as the last
  // step() left them.
  bool sleepOn(std::span<Collider> colliders, const StepParameters& parameters);

  // After a step: grains with numbers that are not allowed (not simulated) and grains outside the
  // bounds. The caller removes them; until then they are reported, and stay as they are.
  const std::vector<Entity>& refused() const { return refused_; }
  const std::vector<Entity>& lost() const { return lost_; }
  const GrainStats& stats() const { return stats_; }

  // For tests: pairs in the neighbour lists, each once, lower entity index first, sorted.
  std::vector<std::pair<uint32_t, uint32_t>> neighbourPairs() const;
  // Bytes of all arrays: capacity, not use.
  size_t memoryBytes() const;

 private:
  bool adopt(std::span<const GrainRows> tables);
  void readRows(std::span<const GrainRows> tables);
  void writeRows(std::span<const GrainRows> tables, const StepParameters& parameters, float dt);
  void scaleKeptImpulses(float factor);
  // Sleep, in sleep.cpp.
  void wakeDisturbed(std::span<const GrainRows> tables, std::span<const Collider> colliders,
                     const StepParameters& parameters, float h);
  void wakeNeighboursOfRemoved(std::span<const GrainRows> tables);
  void loadSleepers(vec3 gravity_step);
  void wakeUnbalanced(vec3 gravity_step);
  void settle(std::span<const GrainRows> tables, vec3 gravity_step, float dt);
  template <class Visit>
  void eachRest(std::span<const GrainRows> tables, const Visit& visit) const;
  void passLoads(std::span<Collider> colliders, int substeps);
  struct Load {
    vec3 impulse{0};    // left over: of all contacts and gravity, N s
    float carried = 0;  // sum of the contacts' sizes, N s
  };
  void addPairLoad(std::vector<Load>& load, const PairSlab& slab, uint32_t contact) const;
  float weight(uint32_t slot, vec3 gravity_step) const;
  void shareHeavyLoads();
  bool predict(vec3 gravity_step, float h);
  void chooseMargins(float h);
  void searchNeighbours(float h);
  void listColliders(std::span<const Collider> colliders, float dt);
  void relax(std::span<Collider> colliders, const StepParameters& parameters, float h, int substep);
  void bounce();
  void collectLoads(std::span<Collider> colliders, bool last_substep);
  void move(vec3 gravity_step, float h, float keep);
  void measure();

  // A slot is a grain's place in the solver's arrays: sorted by cell, changed by each search.
  Bodies bodies_, sorted_;
  Grid grid_;
  const Kernels* kernels_ = &kBaselineKernels;
  PairLists pairs_;
  ColliderLists walls_;
  std::vector<uint32_t> order_;    // slot -> slot before the last sort
  std::vector<uint32_t> history_;  // slot -> slot in the contact lists; kNoSlot: not in them
  std::vector<float> margin_;      // by slot, m
  std::vector<Entity> row_entity_;      // by input row, over all tables
  std::vector<uint32_t> slot_of_row_;   // kNoSlot: refused
  std::vector<uint32_t> slot_moved_;    // slot before the sort -> slot
  // Working memory of adopt().
  std::vector<uint32_t> slot_of_index_, old_history_;
  std::vector<PosedCollider> posed_;  // at the substep's begin
  std::vector<uint8_t> chunk_flags_;
  // Of sleepers: what the contacts among them and with colliders leave over, and with those awake.
  std::vector<Load> load_asleep_, load_;
  uint32_t asleep_ = 0;
  bool adopted_ = false;  // in this tick grains came or went
  vec3 last_gravity_{0};
  std::vector<Entity> refused_, lost_;
  GrainStats stats_;
  size_t memory_ = 0;
  vec3 drift_{0};         // velocity that margins are measured against, m/s
  float drift_time_ = 0;  // since the last search, s
  float last_h_ = 0;
  bool search_due_ = true;
  bool walls_due_ = true;
  bool searched_ = false;  // since the colliders were listed
};

}  // namespace scree::grains
