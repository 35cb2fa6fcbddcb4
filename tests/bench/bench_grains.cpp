// Dropped spheres: time against error over the solver's settings, time against count, and Bullet on
// the same scene in the same run.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include "engine/core/hash.h"
#include "engine/core/parallel.h"
#include "tests/bench/bench.h"
#include "tests/bench/drop.h"
#include "tests/bench/drop_bullet.h"
#include "tests/grains/field.h"

namespace scree::bench {
namespace {

using Json = nlohmann::ordered_json;

// One simulation of the scene.
struct Runner {
  std::string label;
  Json knobs;
  bool baseline = false;
  std::function<void()> step;
  std::function<std::vector<vec3>()> positions, velocities;
  int threads = 1;
};

struct Phase {
  const char* name;
  int first, last;  // steps, from 1
  bool settled = false;
};

struct Result {
  double cpu_ms = 0, wall_ms = 0;  // a step, medians
  Overlap overlap;
  double fastest = 0;  // of 1 %, at the phase's end, m/s
  uint64_t hash = 0;   // of the places at the phase's end
};

Runner ours(const Drop& drop, int substeps, int passes, int threads = 1) {
  const auto field = std::make_shared<grains::test::Field>();
  field->parameters.substeps = substeps;
  field->parameters.passes = passes;
  field->parameters.damping = kDropDamping;
  const float half = 0.5f * drop.width;
  for (const vec3 at : drop.position)
    field->add(at - vec3(half, 0, half), kDropRadius, {kDropDensity, kDropFriction, 0, 0});
  field->addBin(half, kDropFriction);
  return {.label = fmt::format("{} x {}", substeps, passes),
          .knobs = {{"substeps", substeps}, {"passes", passes}},
          .step = [field] { field->step(); },
          .positions =
              [field] {
                std::vector<vec3> all;
                for (const Grain& grain : field->grain) all.push_back(grain.position);
                return all;
              },
          .velocities =
              [field] {
                std::vector<vec3> all;
                for (const GrainVelocity& velocity : field->velocity) all.push_back(velocity.linear);
                return all;
              },
          .threads = threads};
}

#ifdef SCREE_BENCH_BULLET
Runner bullet(const Drop& drop, std::string label, const BulletSettings& settings) {
  const auto world = std::make_shared<BulletDrop>(drop, settings);
  return {.label = std::move(label),
          .knobs = {{"substeps", settings.substeps},
                    {"iterations", settings.iterations},
                    {"small_margins", settings.small_margins}},
          .baseline = true,
          .step = [world] { world->step(); },
          .positions = [world] { return world->positions(); },
          .velocities = [world] { return world->velocities(); }};
}
#endif

struct Log {
  std::vector<double> cpu, wall;
  OverlapSample overlaps;
};

// One step; timed if there is a log.
void timedStep(const Runner& runner, Log* log) {
  const double cpu = cpuMs();
  const auto wall = std::chrono::steady_clock::now();
  runner.step();
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - wall;
  if (!log) return;
  log->cpu.push_back(cpuMs() - cpu);
  log->wall.push_back(took.count());
}

Result resultOf(const Runner& runner, Log& log) {
  const std::vector<vec3> at = runner.positions();
  log.overlaps.add(at);
  return {.cpu_ms = spread(log.cpu).median,
          .wall_ms = spread(log.wall).median,
          .overlap = log.overlaps.result(),
          .fastest = fastestPercent(runner.velocities()),
          .hash = hashBytes(at.data(), at.size() * sizeof(vec3))};
}

// Steps all in turn, a few steps of each, so that what else the machine does slows all alike.
// Returns the results by runner and phase.
std::vector<std::vector<Result>> race(const std::vector<Runner>& runners,
                                      const std::vector<Phase>& phases) {
  constexpr int kTurn = 5;
  std::vector<std::vector<Result>> results(runners.size(), std::vector<Result>(phases.size()));
  std::vector<std::vector<Log>> logs(runners.size(), std::vector<Log>(phases.size()));
  const int steps = phases.back().last;
  for (int begin = 0; begin < steps; begin += kTurn)
    for (size_t r = 0; r < runners.size(); ++r) {
      const Runner& runner = runners[r];
      setThreadCount(runner.threads);
      for (int step = begin + 1; step <= std::min(begin + kTurn, steps); ++step) {
        const auto phase = std::find_if(phases.begin(), phases.end(), [&](const Phase& p) {
          return step >= p.first && step <= p.last;
        });
        const size_t p = static_cast<size_t>(phase - phases.begin());
        timedStep(runner, p < phases.size() ? &logs[r][p] : nullptr);
        if (p == phases.size()) continue;
        if (step == phase->last) {
          results[r][p] = resultOf(runner, logs[r][p]);
        } else if (step % kTurn == 0) {
          logs[r][p].overlaps.add(runner.positions());
        }
      }
    }
  setThreadCount(0);
  return results;
}

Json measuredOf(const Result& result) {
  return {{"overlap_p99", result.overlap.p99},
          {"overlap_max", result.overlap.max},
          {"fastest_1_percent_m_s", result.fastest}};
}

void report(Bench& bench, const std::string& scene, const std::vector<Runner>& runners,
            const std::vector<Phase>& phases, const std::vector<std::vector<Result>>& results) {
  for (size_t p = 0; p < phases.size(); ++p)
    for (size_t r = 0; r < runners.size(); ++r) {
      const Result& result = results[r][p];
      bench.row({.scenario = fmt::format("{}, {}", scene, phases[p].name),
                 .label = runners[r].label,
                 .knobs = runners[r].knobs,
                 .time_ms = result.cpu_ms,
                 .error = result.overlap.mean,
                 .error_kind = "mean overlap of touching grains / radius",
                 .hash = result.hash,
                 .baseline = runners[r].baseline,
                 .measured = measuredOf(result)});
    }
}

void benchSettings(Bench& bench) {
  const size_t count = bench.quick() ? 2000 : 5000;
  const Drop drop = makeDrop(count);
  const std::vector<Phase> phases =
      bench.quick() ? std::vector<Phase>{{"busy", 21, 60}, {"settled", 101, 120, true}}
                    : std::vector<Phase>{{"busy", 31, 150}, {"settled", 241, 300, true}};
  std::vector<Runner> runners;
  for (const int substeps : {1, 2, 4, 8})
    for (const int passes : {1, 2, 3, 4, 8}) runners.push_back(ours(drop, substeps, passes));
  report(bench, fmt::format("{} grains, substeps x passes", count), runners, phases,
         race(runners, phases));
}

void benchBullet(Bench& bench, size_t count, const std::vector<Phase>& phases, bool tuned) {
#ifdef SCREE_BENCH_BULLET
  const Drop drop = makeDrop(count);
  const grains::StepParameters defaults;
  std::vector<Runner> runners{
      ours(drop, defaults.substeps, defaults.passes),
      bullet(drop, "Bullet, default", {}),
      bullet(drop, "Bullet, small margins", {.small_margins = true}),
  };
  if (tuned)
    runners.push_back(bullet(drop, "Bullet, tuned",
                             {.substeps = 4, .iterations = 10, .small_margins = true}));
  const auto results = race(runners, phases);
  report(bench, fmt::format("{} grains beside Bullet", count), runners, phases, results);
  for (size_t p = 0; p < phases.size(); ++p) {
    const Result &own = results[0][p], &theirs = results[1][p];
    const std::string where = fmt::format("{} grains, {}", count, phases[p].name);
    bench.claimAtLeast("CPU time of Bullet / ours: " + where, theirs.cpu_ms / own.cpu_ms, 20);
    // What is left when the drop has settled is the solver's error; before that, also what impacts press together.
    const std::string overlap = "mean overlap of ours / Bullet: " + where;
    const double ratio = own.overlap.mean / theirs.overlap.mean;
    if (phases[p].settled) bench.claimAtMost(overlap, ratio, 0.01);
    else bench.fact(overlap, ratio);
  }
#else
  bench.progress("grains: built without Bullet (libbullet-dev): no rows of it at {} grains", count);
#endif
}

// The exponent k of time ~ count^k, by least squares over the logarithms.
double exponentOf(const std::vector<size_t>& counts, const std::vector<double>& times) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const double n = static_cast<double>(counts.size());
  for (size_t i = 0; i < counts.size(); ++i) {
    const double a = std::log(static_cast<double>(counts[i])), b = std::log(times[i]);
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

// Odd steps with one thread, even ones with two, of one simulation: both see the same work.
void benchCount(Bench& bench) {
  constexpr int kFirst = 21, kLast = 40;
  std::vector<size_t> counts{1000, 10000, 100000};
  if (!bench.quick()) counts = {1000, 3000, 10000, 30000, 100000, 1000000};
  const grains::StepParameters defaults;
  std::vector<double> times;
  for (const size_t count : counts) {
    const Runner runner = ours(makeDrop(count), defaults.substeps, defaults.passes);
    Log logs[2];
    for (int step = 1; step <= kLast; ++step) {
      const int threads = 2 - step % 2;
      setThreadCount(threads);
      timedStep(runner, step < kFirst ? nullptr : &logs[threads - 1]);
    }
    setThreadCount(0);
    const Result one = resultOf(runner, logs[0]), two = resultOf(runner, logs[1]);
    times.push_back(one.cpu_ms);
    for (const Result* result : {&one, &two}) {
      const int threads = result == &one ? 1 : 2;
      Json measured = measuredOf(*result);
      measured["cpu_ms"] = result->cpu_ms;
      bench.row({.scenario = "time on the clock against count",
                 .label = fmt::format("{} grains, {} thread{}", count, threads, threads > 1 ? "s" : ""),
                 .knobs = {{"grains", count}, {"threads", threads}},
                 .time_ms = result->wall_ms,
                 .error = result->overlap.mean,
                 .error_kind = "mean overlap of touching grains / radius",
                 .hash = result->hash,
                 .measured = measured});
    }
    bench.fact(fmt::format("time of 1 thread / 2 threads, {} grains", count),
               one.wall_ms / two.wall_ms);
  }
  bench.claimAtMost("exponent of CPU time against count", exponentOf(counts, times), 1.25);
}

// The same drop with 1, 2 and 4 threads.
void benchThreads(Bench& bench) {
  const Drop drop = makeDrop(3000);
  const grains::StepParameters defaults;
  std::vector<Runner> runners;
  for (const int threads : {1, 2, 4})
    runners.push_back(ours(drop, defaults.substeps, defaults.passes, threads));
  const auto results = race(runners, {{"falling", 1, 60}});
  const auto differs = [&](size_t r) { return results[r][0].hash != results[0][0].hash; };
  bench.claimAtMost("places differ between 1, 2 and 4 threads", differs(1) || differs(2), 0);
}

}  // namespace

SCREE_BENCH(grains, "dropped spheres: settings, count and threads against overlap; Bullet") {
  benchSettings(bench);
  benchCount(bench);
  benchThreads(bench);
  if (bench.quick()) {
    benchBullet(bench, 5000, {{"busy", 31, 60}, {"settled", 106, 120, true}}, true);
    benchBullet(bench, 20000, {{"busy", 16, 25}}, false);
  } else {
    benchBullet(bench, 5000, {{"busy", 31, 150}, {"settled", 241, 300, true}}, true);
    benchBullet(bench, 20000, {{"busy", 31, 150}, {"settled", 241, 300, true}}, false);
    benchBullet(bench, 100000, {{"busy", 31, 60}}, false);
  }
}

}  // namespace scree::bench
