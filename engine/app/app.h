// App: owns the World, the Schedule and the Frame; modules add to it, then it runs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "engine/app/options.h"
#include "engine/core/result.h"
#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/frame/frame.h"
#include "engine/platform/input.h"

namespace scree {

// Seconds of one simulation tick.
inline constexpr double kTickSeconds = 1.0 / 60.0;

// World singleton: which tick is being simulated; set by App before Phase::Input.
struct Tick {
  uint64_t index = 0;  // 1 for the first tick
  double dt_s = kTickSeconds;
};

// World singleton: while paused, ticks count on and Phase::Input runs, but not Phase::Simulate.
struct Simulation {
  bool paused = false;
};

// World singleton: a rule sets it to end the run.
struct QuitRequest {
  bool requested = false;
  std::string error;  // why the run fails, in a line; empty: it does not
};

class Run;

class App {
 public:
  explicit App(AppOptions options);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  const AppOptions& options() const;
  World& world();
  Schedule& schedule();
  Frame& frame();
  // The actions that the game declares before run(); the tick's values are the ActionState singleton.
  ActionMap& actions();

  void addSystem(SystemDesc desc);
  void addPass(PassDesc desc);
  void addTarget(std::string name, TargetDesc desc);
  // A number that the run's statistics report under `name`, read at the end.
  void addGauge(std::string name, std::function<double()> read);

  // Advances the simulation by one tick: Phase::Input, then Phase::Simulate. In a run that may be
  // beside the passes of the frame before: a system that makes meshes, materials or what else passes
  // read calls waitForPasses() first.
  void tick();
  // Renders one frame of the current state into Frame::kOutput: Phase::Animate, then, for each of
  // `samples` sub-pixel offsets (1 = one sample at the pixel's centre), Phase::Prepare and the
  // passes. `alpha`: time between the previous tick (0) and the current one (1); `motion_scale`:
  // frame interval / tick interval. Needs a current GL context. `meanwhile` runs on another thread
  // while the last sample's passes draw, and has ended when this returns: the next ticks.
  void render(ivec2 size, float alpha = 1.0f, float motion_scale = 1.0f, int samples = 1,
              const std::function<void()>& meanwhile = {});
  uint64_t tickIndex() const;
  // For systems of a tick: returns when no pass is drawing beside it, nor will before its end.
  void waitForPasses();

  // Runs until quit, the replay's end, or the tick limit: opens the context if anything is to be
  // drawn, reads input or the replay, ticks, renders, captures, and writes what the options ask for.
  Status run();

 private:
  friend class Run;
  class TicksBeside;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree
