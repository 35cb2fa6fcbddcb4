// Schedule: systems in phases; those without a conflict run in parallel.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/ecs/access.h"

namespace scree {

class World;

enum class Phase : uint8_t {
  Input,     // actions of this tick
  Simulate,  // fixed step
  Animate,   // once a rendered frame: poses, interpolation
  Prepare,   // once a rendered frame: the one place where the CPU uploads
};
inline constexpr int kPhaseCount = 4;
std::string_view phaseName(Phase phase);

struct SystemDesc {
  std::string name;  // "module.verb"; timer and trace label
  Phase phase = Phase::Simulate;
  // Lists from reads<A, B>() and writes<A, B>(); only for systems that are not exclusive.
  std::vector<AccessId> reads, writes;
  // Conflicts with all systems, may touch everything and may change the structure of the World.
  // Otherwise: what the system touches beyond its lists, and structural changes other than by
  // World::commands(), end the program with one line.
  bool exclusive = true;
  std::function<bool()> needs;  // empty: always met
  std::function<void(World&)> run;
};

struct SystemReport {
  std::string name;
  Phase phase = Phase::Simulate;
  bool on = false;  // its needs were met when its phase last ran
  uint64_t runs = 0;
  double cpu_ms = 0;   // wall time of the last run on its thread
  double begin_s = 0;  // when the last run began, seconds of std::chrono::steady_clock
};

class Schedule {
 public:
  Schedule();
  ~Schedule();
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  // Ends the program if the name is taken.
  void add(SystemDesc desc);
  // Runs the phase's systems whose needs are met. Of two systems that conflict (one writes what
  // the other reads or writes, or one is exclusive) the one that was added first runs first. Then
  // flushes the commands, in the order in which the systems were added.
  void run(Phase phase, World& world);

  // In the order of phases, then of adding.
  const std::vector<SystemReport>& report() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree
