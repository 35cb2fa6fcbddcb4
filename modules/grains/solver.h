// The grain solver over plain spans: one step moves all grains by one tick. No ECS storage, no GL.
//
// A substep: predict velocities; search neighbours again if a grain left its margin; apply the kept
// impulses; some passes over all contacts; move. Contacts are grouped in slabs, one a layer of grid
// cells along z. A slab's contacts touch grains of that slab and the next only, so all even slabs
// may run at once, then all odd ones; inside a slab the order is fixed. No result depends on the
// thread count, nor on the order of the rows: grains are sorted by cell, then by entity.
//
// The bodies are the grains awake and the sleepers near them; all other sleepers cost nothing: see
// sleepers.h and rest.h.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/bytes.h"
#include "engine/core/result.h"
#include "modules/grains/awake_rows.h"
#include "modules/grains/clumps.h"
#include "modules/grains/collider.h"
#include "modules/grains/contacts.h"
#include "modules/grains/forces.h"
#include "modules/grains/grains.h"
#include "modules/grains/grid.h"
#include "modules/grains/rigid.h"
#include "modules/grains/sleepers.h"
#include "modules/grains/strikes.h"

namespace scree::grains {

// The longest tick that is simulated, s; a longer one is cut to it.
inline constexpr float kLongestTick = 0.1f;
// What a grain may measure; others are refused. Mass and its inverse stay far inside float's range.
inline constexpr float kLeastRadius = 1e-5f, kMostRadius = 1e4f;      // m
inline constexpr float kLeastDensity = 1e-3f, kMostDensity = 1e6f;    // kg/m^3
inline constexpr float kMostCohesion = 1e6f;                          // N/m
inline constexpr float kMostSpeed = 1e5f;                             // m/s and rad/s at the surface
inline constexpr float kMostDistance = 1e9f;                          // from the field's origin, m

// Whether the numbers are inside these limits.
bool allowed(float radius, const GrainMaterial& material);

struct StepParameters {
  float dt = 1.0f / 60;  // s; 0 or less, or NaN: nothing happens
  vec3 gravity{0, -9.81f, 0};
  int substeps = 4;
  int passes = 3;
  float damping = 0;  // 1/s
  vec3 bounds_min{-500, -50, -500}, bounds_max{500, 500, 500};
  Lanes lanes = Lanes::Widest;  // a set that the machine lacks: the baseline
  // In a set order, which shows in the last bits.
  std::span<const Force> forces;
  std::span<const Blow> blows;  // at the tick's begin
  StrikeLimits strikes;
  // Rigid bodies, sorted by key; each has its collider. Written to.
  std::span<RigidRow> bodies;
  dvec3 origin{0};  // of the field: places of bodies are kept as they come back from the world
};

// Length of a substep, s.
float substepOf(const StepParameters& parameters);

// Where a member's row is.
struct ClumpRow {
  GrainClump clump;
  Entity entity;
  uint32_t table;
  size_t row;
};

// Whether anybody but step() has written, added, removed or moved rows since the last step.
enum class RowsAre : uint32_t { Unknown, AsLeft };

class GrainSolver {
 public:
  // Advances all rows by one tick. Colliders, sorted by key; their `load` fields are written. With
  // rows as step() left them, those of sleepers are not even read.
  void step(std::span<const GrainRows> tables, std::span<Collider> colliders,
            const StepParameters& parameters, RowsAre rows = RowsAre::Unknown);

  // A tick in which all grains sleep on and nothing is searched or solved: true, and the colliders
  // have their loads. False if something may wake: step() is due. The rows must be as the last
  // step() left them.
  bool sleepOn(std::span<Collider> colliders, const StepParameters& parameters);

  // After a step: grains with numbers that are not allowed (not simulated) and grains outside the
  // bounds. The caller removes them; until then they are reported, and stay as they are.
  const std::vector<Entity>& refused() const { return refused_; }
  const std::vector<Entity>& lost() const { return lost_; }
  // Grains with a GrainClump whose clump is not whole: free from now on. The caller removes it.
  const std::vector<Entity>& broken() const { return broken_; }
  const GrainStats& stats() const { return stats_; }
  // Of the last step, if its parameters asked for them.
  std::span<const Strike> strikes() const { return strikes_.found(); }

  // The grains as the last step() left them: those awake, in no set order, and the sleepers.
  template <class Visit>
  void eachAwake(const Visit& visit) const {
    for (const AwakeRow& row : awake_)
      visit(bodies_.entity[row.slot], bodies_.body[row.slot], bodies_.materialOf(row.slot));
  }
  const Sleepers& sleepers() const { return sleepers_; }
  const Rigids& rigids() const { return rigids_; }
  // Whether these are all that the rows hold, once the lost and the refused are removed.
  bool current() const { return !adopt_due_; }

  // All that the coming ticks depend on beside the rows, the colliders and the parameters, as bytes:
  // see saved.h. Empty before the first tick.
  std::string saved() const;
  // The solver that goes on from there to the bit, given rows, colliders and parameters as they were.
  // Rows may also have changed in the meantime, as between two ticks. Entities have an index below
  // `handles`. Error: what is wrong with the bytes.
  static Result<GrainSolver> restored(std::string_view bytes, uint32_t handles);

  // For tests: pairs in the neighbour lists, each once, lower entity index first, sorted; all, or those
  // that carry an impulse.
  enum class PairsThat : uint32_t { AreNear, Carry };
  std::vector<std::pair<uint32_t, uint32_t>> neighbourPairs(PairsThat which = PairsThat::AreNear) const;
  // Bytes of all arrays: capacity, not use.
  size_t memoryBytes() const;

 private:
  // Rows, in solver_rows.cpp.
  void adopt(std::span<const GrainRows> tables);
  void readRows(std::span<const GrainRows> tables);
  void writeRows(std::span<const GrainRows> tables, const StepParameters& parameters, float dt);
  uint32_t placeOf(Entity entity) const;
  void setPlace(Entity entity, uint32_t place);
  uint32_t appendBody(Entity entity, const GrainMaterial& material, vec3 position, float radius);
  void sortAwake();

  // Clumps, in clump_rows.cpp.
  void adoptClumps(std::span<const GrainRows> tables);
  bool takeClump(std::span<const ClumpRow> rows, std::span<const GrainRows> tables);
  void linkSleepers(const Clump& clump);
  void rouseClumps(size_t first_awake);
  void layClumps();
  void loseClumps();
  bool meetsOwnOnly(uint32_t slot) const;
  void settleClumps(uint8_t still);
  void loadOfClump(uint32_t slot, float& mass, Load& load) const;
  void mend(std::span<const Collider> colliders, float t1);

  // Sleep, in sleep.cpp.
  void findDisturbed(std::span<const Collider> colliders, const StepParameters& parameters);
  void findStruck(const StepParameters& parameters);
  void findUnbalanced(vec3 gravity_step);
  bool mayChangeSleepers() const;
  void inOrder(std::vector<uint32_t>& berths) const;
  void gatherTouches(uint32_t first);
  void wake(std::span<const GrainRows> tables, vec3 gravity_step);
  void settle(std::span<const GrainRows> tables, const StepParameters& parameters,
              vec3 gravity_step, float dt);
  void layToSleep(std::span<const GrainRows> tables, vec3 gravity_step);
  // In settled_ of this tick: has been still for as long as it takes to fall asleep.
  bool isStill(uint32_t slot) const;
  void addPairLoad(const PairSlab& slab, uint32_t contact);
  void bookLeftOver(vec3 gravity_step);
  void bookRest(vec3 gravity_step);
  void addSleepersLoads(std::span<Collider> colliders, int substeps) const;

  // Searches, in solver_search.cpp.
  std::span<uint32_t> gatherNear(float h, std::span<uint32_t>& were);
  void chooseMargins(float h);
  float marginOf(const Body& grain, float h) const;
  bool followStrays(float h);
  void searchNeighbours(float h);
  void joinWoken();
  void listColliders(std::span<const Collider> colliders, float dt, float h);

  // Rigid bodies, in solver_rigids.cpp.
  bool wakeRigids(std::span<const Collider> colliders, const StepParameters& parameters);
  void stepRigids(std::span<Collider> colliders, const StepParameters& parameters);
  void poseColliders(std::span<const Collider> colliders, int substep, int substeps, float h);
  void settleRigids(std::span<Collider> colliders, const StepParameters& parameters, float dt);
  std::span<ColliderSlab> slabsInUse() { return std::span(walls_.slab).first(walls_.slab_count); }

  // Guards, in guard.cpp.
  void guard(std::span<const Collider> colliders, float t1);
  void stopDriven(std::span<const Collider> colliders, float t1);

  // Saves, in solver_save.cpp: what is wrong, or nothing.
  std::string restoreScalars(ByteReader& in, uint32_t handles);
  std::string restoreBodies(ByteReader& in, uint32_t handles);
  std::string restoreWoken(ByteReader& in, uint32_t handles);
  std::string restoreLists(ByteReader& in, uint32_t handles);
  // Puts idle bodies behind the grains.
  void padBodies();
  void trim(size_t bodies);
  // Forces, in forces.cpp.
  void findPushed(const StepParameters& parameters);
  void strikeBlows(std::span<const Blow> blows);

  void readyMasses();
  void shareHeavyLoads();
  void predict(vec3 gravity_step, float h, std::span<const Force> forces);
  void relax(std::span<Collider> colliders, const StepParameters& parameters, float h, int substep);
  bool bounce();
  // Calls visit(slot, shift) for the grains that bounced.
  template <class Visit>
  void eachBounce(const Visit& visit) const;
  void collectLoads(std::span<Collider> colliders, bool last_substep);
  void move(vec3 gravity_step, float h, float keep, std::span<const Force> forces, bool walls);
  void scaleKeptImpulses(float factor);
  void measure();

  // A slot is a grain's place in the solver's arrays: sorted by cell, changed by each search.
  Bodies bodies_;
  Sleepers sleepers_;
  Clumps clumps_;
  std::vector<ClumpRow> clump_rows_;  // working memory
  Grid grid_;
  const Kernels* kernels_ = &kBaselineKernels;
  PairLists pairs_;
  ColliderLists walls_;
  Rigids rigids_;
  std::vector<AwakeRow> awake_;   // by row, over all tables
  size_t awake_sorted_ = 0;       // of them
  std::vector<uint32_t> place_;   // by entity index: slot, or berth with kBerthBit; kNoSlot
  static constexpr uint32_t kBerthBit = 0x80000000u;
  size_t row_count_ = 0;          // when they were adopted
  // Working memory of a search.
  Workspace workspace_;
  std::span<uint32_t> before_;    // slot -> slot at the last search; kNoSlot: not in the lists
  std::vector<PosedCollider> posed_, posed_end_;  // at the substep's begin; at its end, if guarded
  struct Driven {
    uint32_t slot;
    vec3 from;
  };
  std::vector<uint8_t> moved_walls_;  // by collider
  std::vector<std::vector<Driven>> driven_;  // by chunk: grains beyond where they are listed
  std::vector<std::pair<uint32_t, vec3>> shifts_;  // of bounces, by slot
  std::vector<uint8_t> chunk_flags_;
  static constexpr size_t kMostStrays = 16;  // each is tested against all bodies
  std::vector<uint32_t> strays_;  // slots that may leave their margin within the substep; of too many, some
  std::vector<uint32_t> met_;     // by a stray
  // Of sleep.
  std::vector<uint32_t> waking_;  // berths
  std::vector<uint32_t> partners_, falling_;
  // Contacts of sleepers with grains awake, by the sleeper, then the other.
  struct BorderContact {
    Entity sleeper, other;
    uint32_t berth, slab, contact;
    bool first;  // the sleeper is the contact's grain i
  };
  std::span<BorderContact> border_;  // in the workspace
  std::vector<uint32_t> uneasy_;
  std::vector<uint32_t> waiting_;  // berths, some twice: lost their balance, and wake when mayChangeSleepers() if still so
  std::vector<uint32_t> to_book_;  // berths whose load has changed since it was booked; empty between ticks
  struct Pressed {
    uint32_t berth;
    vec3 impulse;  // of all grains awake, in the last substep, N s
  };
  std::vector<Pressed> pressed_;
  std::vector<Touch> touches_;
  std::vector<const BorderContact*> touching_;
  std::vector<uint8_t> settled_;  // by slot
  std::span<Load> load_;          // by slot, in the workspace
  std::vector<WokenPair> woken_pairs_;  // since the last search
  std::vector<WokenWall> woken_walls_;
  std::vector<JoiningPair> joining_pairs_;
  std::vector<JoiningWall> joining_walls_;

  // Forces that leave all who sleep asleep, and who sleeps: as Sleepers::changes() counts.
  std::vector<Force> forces_seen_;
  uint64_t sleepers_seen_ = 0;
  Strikes strikes_;

  vec3 last_gravity_{0};
  std::vector<Entity> refused_, lost_, broken_;
  GrainStats stats_;
  size_t memory_ = 0;
  vec3 drift_{0};         // velocity that margins are measured against, m/s
  float drift_time_ = 0;  // since the last search, s
  float last_h_ = 0;
  float lifetime_ = 4;          // of chooseMargins()
  float least_margin_ = 0.12f;
  float least_margin_way_ = 0;  // the least margin of a body awake, m
  uint32_t listed_awake_ = 0;   // at the last search
  int age_ = 0;           // substeps since the last search
  int calm_ = 0;          // ticks since who sleeps last changed by itself; see kCalm
  bool left_margin_ = false;
  bool adopt_due_ = true;
  bool search_due_ = true;
  bool walls_due_ = true;
  bool searched_ = false;  // since the colliders were listed
};

template <class Visit>
void GrainSolver::eachBounce(const Visit& visit) const {
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) {
    for (const Bounce& b : pairs_.slab[s].bounces) {
      const Body &i = bodies_.body[b.i], &j = bodies_.body[b.j];
      const float inverse = 1 / (i.inverse_mass + j.inverse_mass);
      visit(b.i, b.shift * (i.inverse_mass * inverse));
      visit(b.j, -b.shift * (j.inverse_mass * inverse));
    }
    for (const Bounce& b : walls_.slab[s].bounces) visit(b.i, b.shift);
  }
}

}  // namespace scree::grains
