// The two steps of a run: a tick of the simulation, and a rendered frame.
#include "engine/app/app.h"

#include <exception>

#include "engine/app/app_state.h"
#include "engine/core/parallel.h"
#include "shaders/shared/jitter.h"

namespace scree {

// Whatever ends the passes, the ticks beside them end before anything of theirs goes.
class App::TicksBeside {
 public:
  explicit TicksBeside(State* state) : state_(state) {
    if (state_) state_->drawing = true;
  }
  ~TicksBeside() noexcept(false) {
    if (!state_) return;
    state_->drawing = false;
    state_->drawing.notify_all();
    if (std::uncaught_exceptions() == exceptions_) {
      state_->beside.wait();
      return;
    }
    try {
      state_->beside.wait();
    } catch (...) {  // what ended the passes goes on; one exception is enough
    }
  }
  TicksBeside(const TicksBeside&) = delete;
  TicksBeside& operator=(const TicksBeside&) = delete;

 private:
  State* state_;
  int exceptions_ = std::uncaught_exceptions();
};

App::App(AppOptions options) : state_(std::make_unique<State>()) {
  setThreadCount(options.threads);
  state_->options = std::move(options);
  World& world = state_->world;
  world.singleton<Tick>();
  world.singleton<Simulation>();
  world.singleton<ActionState>();
  world.singleton<FrameInput>();
  world.singleton<QuitRequest>();
}

App::~App() = default;

const AppOptions& App::options() const { return state_->options; }
World& App::world() { return state_->world; }
Schedule& App::schedule() { return state_->schedule; }
Frame& App::frame() { return state_->frame; }
ActionMap& App::actions() { return state_->actions; }
uint64_t App::tickIndex() const { return state_->tick; }

void App::addSystem(SystemDesc desc) { state_->schedule.add(std::move(desc)); }
void App::addPass(PassDesc desc) { state_->frame.addPass(std::move(desc)); }
void App::addTarget(std::string name, TargetDesc desc) {
  state_->frame.addTarget(std::move(name), desc);
}
void App::addGauge(std::string name, std::function<double()> read) {
  state_->gauges.push_back({std::move(name), std::move(read)});
}

void App::waitForPasses() { state_->drawing.wait(true); }

void App::tick() {
  World& world = state_->world;
  world.singleton<Tick>().index = ++state_->tick;
  state_->schedule.run(Phase::Input, world);
  if (!world.singleton<Simulation>().paused) state_->schedule.run(Phase::Simulate, world);
}

void App::render(ivec2 size, float alpha, float motion_scale, int samples,
                 const std::function<void()>& meanwhile) {
  World& world = state_->world;
  FrameInput& input = world.singleton<FrameInput>();
  input.size = size;
  input.frame = state_->rendered_frames++;
  input.tick = state_->tick;
  input.alpha = alpha;
  input.motion_scale = motion_scale;
  input.sample_count = samples;
  input.sample = 0;
  input.jitter_px = {0, 0};
  state_->schedule.run(Phase::Animate, world);
  for (int sample = 0; sample < samples; ++sample) {
    input.sample = sample;
    input.jitter_px = rules::jitterOffset(static_cast<uint32_t>(sample));
    state_->schedule.run(Phase::Prepare, world);
    const bool with_ticks = meanwhile && sample + 1 == samples;
    const TicksBeside ticks(with_ticks ? state_.get() : nullptr);
    state_->frame.run(input, [&] {
      if (with_ticks) state_->beside.start(meanwhile);
    });
  }
}

}  // namespace scree
