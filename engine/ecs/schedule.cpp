// Ordering systems into waves, and running them.
#include "engine/ecs/schedule.h"

#include <algorithm>
#include <chrono>

#include "engine/core/log.h"
#include "engine/core/parallel.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

using Clock = std::chrono::steady_clock;

struct System {
  SystemDesc desc;
  SystemAccess access;
  size_t report = 0;  // index in the list of reports
};

// Systems of a wave have no conflict; every system comes in a later wave than those that it
// conflicts with and that were added before it.
struct PhaseSystems {
  std::vector<std::unique_ptr<System>> systems;  // in the order of adding
  std::vector<std::vector<uint32_t>> waves;      // indices in `systems`
};

template <size_t n>
void insertAll(std::array<uint64_t, n>& set, const std::vector<AccessId>& ids) {
  for (AccessId id : ids) set[id / 64] |= uint64_t{1} << id % 64;
}

template <size_t n>
bool intersect(const std::array<uint64_t, n>& a, const std::array<uint64_t, n>& b) {
  for (size_t i = 0; i < n; ++i)
    if (a[i] & b[i]) return true;
  return false;
}

bool conflict(const System& a, const System& b) {
  if (a.desc.exclusive || b.desc.exclusive) return true;
  return intersect(a.access.writes, b.access.writes) ||
         intersect(a.access.writes, b.access.reads) || intersect(a.access.reads, b.access.writes);
}

void addToWave(PhaseSystems& phase, uint32_t added) {
  size_t wave = 0;
  for (size_t i = 0; i < phase.waves.size(); ++i)
    for (uint32_t other : phase.waves[i])
      if (conflict(*phase.systems[other], *phase.systems[added])) wave = i + 1;
  if (wave == phase.waves.size()) phase.waves.emplace_back();
  phase.waves[wave].push_back(added);
}

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

std::string_view phaseName(Phase phase) {
  constexpr std::array<std::string_view, kPhaseCount> kNames{"Input", "Simulate", "Animate",
                                                             "Prepare"};
  return kNames[static_cast<size_t>(phase)];
}

struct Schedule::State {
  std::array<PhaseSystems, kPhaseCount> phases;
  std::vector<SystemReport> reports;

  void runSystem(System& system, uint32_t index, World& world, WorldState& state,
                 uint32_t sequence);
};

Schedule::Schedule() : state_(std::make_unique<State>()) {}
Schedule::~Schedule() = default;

const std::vector<SystemReport>& Schedule::report() const {
  return state_->reports;
}

void Schedule::add(SystemDesc desc) {
  if (!desc.run) fail(fmt::format("system '{}' has no function", desc.name));
  std::vector<SystemReport>& reports = state_->reports;
  for (const SystemReport& report : reports)
    if (report.name == desc.name) fail(fmt::format("system '{}' is added twice", desc.name));
  const auto place = std::upper_bound(
      reports.begin(), reports.end(), desc.phase,
      [](Phase phase, const SystemReport& report) { return phase < report.phase; });
  const auto at = static_cast<size_t>(place - reports.begin());
  reports.insert(place, SystemReport{desc.name, desc.phase});
  for (PhaseSystems& phase : state_->phases)
    for (auto& system : phase.systems)
      if (system->report >= at) ++system->report;

  PhaseSystems& phase = state_->phases[static_cast<size_t>(desc.phase)];
  auto system = std::make_unique<System>();
  system->report = at;
  system->access.name = desc.name;
  insertAll(system->access.reads, desc.reads);
  insertAll(system->access.writes, desc.writes);
  system->desc = std::move(desc);
  phase.systems.push_back(std::move(system));
  addToWave(phase, static_cast<uint32_t>(phase.systems.size() - 1));
}

void Schedule::State::runSystem(System& system, uint32_t index, World& world, WorldState& state,
                                uint32_t sequence) {
  SystemReport& report = reports[system.report];
  report.on = !system.desc.needs || system.desc.needs();
  if (!report.on) return;
  const bool exclusive = system.desc.exclusive;
  CommandScope scope(state.root_scope, sequence, index, exclusive ? nullptr : &system.access);
  const Clock::time_point begin = Clock::now();
  if (!exclusive) state.shared_systems.fetch_add(1, std::memory_order_relaxed);
  system.desc.run(world);
  if (!exclusive) state.shared_systems.fetch_sub(1, std::memory_order_relaxed);
  report.cpu_ms = secondsSince(begin) * 1e3;
  report.begin_s = std::chrono::duration<double>(begin.time_since_epoch()).count();
  ++report.runs;
}

void Schedule::run(Phase phase, World& world) {
  WorldState& state = *world.state_;
  PhaseSystems& systems = state_->phases[static_cast<size_t>(phase)];
  const uint32_t sequence = state.root_scope.beginCall();
  for (const std::vector<uint32_t>& wave : systems.waves) {
    const auto run = [&](size_t at, size_t, size_t) {
      state_->runSystem(*systems.systems[wave[at]], wave[at], world, state, sequence);
    };
    parallelChunks(wave.size(), 1, std::ref(run));
  }
  world.flush();
}

}  // namespace scree
