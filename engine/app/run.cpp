// The run loop: in real time in a window, or tick by tick as fast as it goes.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>

#include "engine/app/app_state.h"
#include "engine/app/capture.h"
#include "engine/app/command_line.h"
#include "engine/app/trace.h"
#include "engine/core/file.h"
#include "engine/core/log.h"
#include "engine/core/parallel.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/load.h"
#include "engine/gpu/program.h"
#include "engine/platform/fixed_step.h"
#include "engine/platform/replay.h"

namespace scree {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Motion of a frame relative to that of a tick is clamped to this: a stalled window must not smear.
constexpr float kMaxMotionScale = 8;
// Changed shader sources are looked for this often, seconds.
constexpr double kReloadInterval = 1;
// A progress line on a terminal at most this often, seconds.
constexpr double kProgressInterval = 0.25;

// SIGINT, SIGTERM and a terminal that goes away end a run in order: what was asked for is still
// written. A second one kills. Nobody reading what is printed ends nothing.
volatile std::sig_atomic_t interrupted = 0;

class Interrupts {
  static constexpr int kEnding[] = {SIGINT, SIGTERM, SIGHUP};

 public:
  Interrupts() {
    interrupted = 0;
    std::signal(SIGPIPE, SIG_IGN);
    for (const int signal : kEnding) {
      struct sigaction action = {};
      action.sa_handler = [](int number) { interrupted = number; };
      action.sa_flags = SA_RESETHAND;
      sigaction(signal, &action, nullptr);
    }
  }
  ~Interrupts() {
    for (const int signal : kEnding) std::signal(signal, SIG_DFL);
    std::signal(SIGPIPE, SIG_DFL);
  }
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
};

}  // namespace

// One run: what App::run() keeps between its steps.
class Run {
 public:
  explicit Run(App& app, App::State& state) : app_(app), state_(state), options_(state.options) {}

  Status operator()() {
    if (Status status = open(); !status.ok()) return status;
    const Interrupts interrupts;
    const double start = now();
    Status status = inRealTime() ? playRealTime() : playLockstep();
    if (!status.ok()) return status;
    // What was asked for is written even if the run goes on to fail.
    if (Status written = finish(now() - start); !written.ok()) return written;
    if (interrupted != 0)
      return Error{fmt::format("ended by signal {} at tick {}", int{interrupted}, app_.tickIndex()),
                   ErrorKind::Failure};
    const std::string& error = app_.world().singleton<QuitRequest>().error;
    if (!error.empty()) return Error{error, ErrorKind::Failure};
    if (const int broken = gpu::brokenPrograms(); broken > 0)
      return Error{fmt::format("{} shader programs did not compile: the pictures lack what they draw",
                               broken),
                   ErrorKind::Failure};
    return Done{};
  }

 private:
  bool wantsFrames() const {
    return !options_.capture.empty() || !options_.stats.empty() || !options_.trace.empty() ||
           options_.print_frame;
  }
  bool inRealTime() const {
    return state_.context && state_.context->presents() && options_.capture.empty();
  }
  bool ended() const {
    return interrupted != 0 || app_.world().singleton<QuitRequest>().requested ||
           (options_.max_ticks > 0 && app_.tickIndex() >= options_.max_ticks) ||
           (player_ && player_->finished());
  }

  Status open() {
    if (Status status = checkOptions(options_); !status.ok()) return status;
    if (!options_.bindings.empty())
      if (Status status = state_.actions.loadBindings(options_.bindings); !status.ok()) return status;
    if (!options_.replay.empty()) {
      Result<Replay> replay = readReplay(options_.replay, &state_.actions);
      if (!replay.ok()) return replay.takeError();
      if (replay->level != options_.level)
        return Error{fmt::format("{}: level is '{}', but the run's level is '{}'",
                                 options_.replay.string(), replay->level, options_.level)};
      if (replay->content != options_.level_content)
        return Error{fmt::format("{}: was recorded on a '{}' of content {:016x}, but the run's has {:016x}; record it anew",
                                 options_.replay.string(), replay->level, replay->content, options_.level_content)};
      if (replay->ticks_per_second != 60)
        return Error{fmt::format("{}: rate is {}, allowed is 60", options_.replay.string(),
                                 replay->ticks_per_second)};
      player_.emplace(std::move(*replay), state_.actions);
    }
    if (!options_.record.empty()) recorder_.emplace(state_.actions, options_.level, options_.level_content);
    if (!options_.capture.empty()) {
      Result<Capture> capture = Capture::open(options_.capture, options_.capture_exr);
      if (!capture.ok()) return capture.takeError();
      capture_.emplace(std::move(*capture));
      if (options_.capture_exr)
        for (const std::string& target : options_.radiance_targets) state_.frame.keep(target, true);
    }
    if (options_.context == ContextKind::Auto || options_.context == ContextKind::Window ||
        wantsFrames()) {
      Result<std::unique_ptr<Context>> context =
          makeContext({.kind = options_.context,
                       .size = options_.size,
                       .title = options_.title,
                       .debug = options_.gl_debug});
      if (!context.ok()) return Error{context.error(), ErrorKind::Failure};
      state_.context = std::move(*context);
      if (Status status = gpu::loadFunctions(state_.context->getProcAddress()); !status.ok())
        return Error{status.error(), ErrorKind::Failure};
      // Not every context has a debug flag; all have debug output.
      if (options_.gl_debug) gpu::enableDebugOutput();
      logInfo("{}", state_.context->description());
    }
    if (!inRealTime() && !player_ && options_.max_ticks == 0)
      return Error{"without a window a run needs an end: --replay FILE or --ticks N"};
    sampler_.emplace(state_.actions);
    if (wantsFrames()) state_.frame.separatePasses(true);
    return Done{};
  }

  void tick() {
    ActionState& actions = app_.world().singleton<ActionState>();
    if (player_)
      player_->tick(actions);
    else
      sampler_->tick(actions);
    if (recorder_) recorder_->record(actions);
    const double start = now();
    app_.tick();
    const double tick_ms = (now() - start) * 1e3;
    if (!options_.stats.empty()) statistics_.addTick(state_.schedule, tick_ms);
    if (!options_.trace.empty())
      trace_.addSystems(state_.schedule, {Phase::Input, Phase::Simulate});
    if (!options_.hash_log.empty())
      fmt::format_to(std::back_inserter(hash_lines_), "{} {:016x}\n", app_.tickIndex(),
                     app_.world().stateHash());
  }

  void render(ivec2 size, float alpha, float motion_scale, int samples,
              const std::function<void()>& meanwhile = {}) {
    const gpu::Counters before = gpu::counters();
    const double start = now();
    app_.render(size, alpha, motion_scale, samples, meanwhile);
    const double frame_ms = (now() - start) * 1e3;
    if (!options_.stats.empty())
      statistics_.addFrame(state_.schedule, state_.frame, frame_ms, gpu::counters() - before);
    if (!options_.trace.empty()) {
      trace_.addSystems(state_.schedule, {Phase::Animate, Phase::Prepare});
      trace_.addPasses(state_.frame);
    }
  }

  // A frame draws the newest state while the ticks that time has brought meanwhile make the next
  // one, so that on a machine with more than one core neither waits for the other.
  Status playRealTime() {
    // Three ticks a frame: a machine that draws fewer than 20 frames a second slows the game down,
    // rather than drawing fewer still.
    FixedStep step(kTickSeconds, 3);
    RawInput input;
    double last = now(), last_reload = last, last_shown = 0;
    while (!ended() && !state_.context->shouldClose()) {
      input.events.clear();
      state_.context->poll(input);
      sampler_->feed(input);
      const double time = now();
      const float alpha = step.alpha();
      const int ticks = step.advance(time - last);
      last = time;
      const auto catch_up = [&] {
        for (int i = 0; i < ticks && !ended(); ++i) tick();
      };
      if (state_.context->minimised()) {
        catch_up();
        usleep(10'000);
        continue;
      }
      if (time - last_reload > kReloadInterval) {
        last_reload = time;
        gpu::reloadPrograms();
      }
      const bool paused = app_.world().singleton<Simulation>().paused;
      // How far the simulation has come since the frame before.
      const double shown = static_cast<double>(app_.tickIndex()) + static_cast<double>(alpha);
      const auto motion = static_cast<float>(shown - last_shown);
      last_shown = shown;
      const ivec2 size = state_.context->framebufferSize();
      render(size, paused ? 1.0f : alpha,
             paused ? 0.0f : std::clamp(motion, 0.0f, kMaxMotionScale), 1, catch_up);
      gpu::copyToWindow(state_.frame.texture(Frame::kOutput), size);
      state_.context->swap();
    }
    return Done{};
  }

  bool isCaptured(uint64_t tick) const {
    if (options_.capture_every > 0 && tick % options_.capture_every == 0) return true;
    return std::binary_search(options_.capture_frames.begin(), options_.capture_frames.end(), tick);
  }

  Status playLockstep() {
    double last_progress = 0;
    RawInput unused;
    while (!ended()) {
      if (state_.context && state_.context->presents()) {
        unused.events.clear();
        state_.context->poll(unused);
        if (state_.context->shouldClose()) break;
      }
      tick();
      const uint64_t index = app_.tickIndex();
      if (capture_ ? isCaptured(index) : wantsFrames())
        render(options_.size, 1.0f, 1.0f, capture_ ? options_.truth : 1);
      if (capture_ && isCaptured(index))
        if (Status status = capture_->add(state_.frame, index, options_.radiance_targets);
            !status.ok())
          return status;
      if (const double time = now(); time - last_progress > kProgressInterval) {
        last_progress = time;
        progress(index);
      }
    }
    progress(app_.tickIndex());
    if (isatty(STDERR_FILENO)) std::fputc('\n', stderr);
    return Done{};
  }

  void progress(uint64_t tick) const {
    if (!isatty(STDERR_FILENO)) return;
    uint64_t total = player_ ? player_->replay().ticks : options_.max_ticks;
    if (player_ && options_.max_ticks > 0) total = std::min(total, options_.max_ticks);
    constexpr int kWidth = 40;
    const int filled = total > 0 ? static_cast<int>(tick * kWidth / total) : 0;
    fmt::print(stderr, "\r[{:=<{}}{:{}}] {}/{} ticks", "", filled, "", kWidth - filled, tick, total);
  }

  // Writes all that was asked for, also after one of it could not be written; the first error.
  Status finish(double wall_s) {
    Status first = Done{};
    const auto wrote = [&first](Status status) {
      const bool ok = status.ok();
      if (!ok && first.ok())
        first = std::move(status);
      else if (!ok)
        logError("{}", status.error());
      return ok;
    };
    if (recorder_) wrote(writeReplay(options_.record, recorder_->replay()));
    if (!options_.hash_log.empty())
      wrote(writeFile(options_.hash_log, std::string_view(hash_lines_.data(), hash_lines_.size())));
    if (capture_ && wrote(capture_->finish())) {
      fmt::print("{} frames: {}\n", capture_->frameCount(), capture_->folder().string());
      if (capture_->frameCount() > 0)
        fmt::print("contact sheet: {}\n", (capture_->folder() / "contact_sheet.png").string());
      if (!options_.capture_frames.empty() && options_.capture_frames.back() > app_.tickIndex())
        logWarning("the run ended at tick {}: later frames of --frames were not captured",
                   app_.tickIndex());
    }
    if (!options_.stats.empty() &&
        wrote(statistics_.write(options_.stats, state_.gauges, state_.context->description(),
                                options_.size, threadCount(), wall_s)))
      fmt::print("statistics: {}\n", options_.stats.string());
    if (!options_.trace.empty() && wrote(trace_.write(options_.trace)))
      fmt::print("trace: {}\n", options_.trace.string());
    if (options_.print_frame) {
      state_.frame.finishTimers();
      fmt::print("{}", state_.frame.describe());
    }
    return first;
  }

  App& app_;
  App::State& state_;
  const AppOptions& options_;
  std::optional<ReplayPlayer> player_;
  std::optional<ReplayRecorder> recorder_;
  std::optional<ActionSampler> sampler_;
  std::optional<Capture> capture_;
  Statistics statistics_;
  Trace trace_;
  fmt::memory_buffer hash_lines_;
};

Status App::run() { return Run(*this, *state_)(); }

}  // namespace scree
