// The bench harness: what a bench_NAME.cpp registers, reports and claims.
//
//   SCREE_BENCH(grains, "contact solver: iterations against penetration") {
//     auto timed = bench.paired({{"ours", [&] { ours(); }}, {"baseline", [&] { other(); }}});
//     bench.row({.scenario = "pile", .label = "ours", .knobs = {{"iterations", 8}},
//                .time_ms = timed.variants[0].median_ms, .error = e, .error_kind = "overlap / r",
//                .hash = world.stateHash()});
//     bench.claimAtMost("time / baseline", timed.ratio(0, 1).median, 0.5);
//   }
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"
#include "tests/bench/paired.h"

namespace scree::bench {

// One measured point of a scenario's run-time-versus-error curve.
struct Row {
  std::string scenario;  // rows of one scenario share a table and a plot
  std::string label;     // short name of the point, unique in its scenario
  nlohmann::ordered_json knobs = nlohmann::ordered_json::object();  // name -> value
  double time_ms = 0;      // median of interleaved runs; > 0
  double error = 0;        // >= 0; 0 = exact
  std::string error_kind;  // what `error` measures, with its unit
  uint64_t hash = 0;       // of the result, so that faster is not just different
  bool baseline = false;   // what a user would pick instead
  // Other results of the same run: name with unit -> value.
  nlohmann::ordered_json measured = nlohmann::ordered_json::object();
};

// A plot of what was measured over a knob, a line a label.
struct Curve {
  std::string knob;
  std::string measured;   // a name in Row::measured, or "error"
  std::string scenarios;  // of those whose names begin so
  bool linear = false;    // the knob's axis; else logarithmic
};

// A promise, measured in this run; a ratio, so that it means the same on another machine.
struct Claim {
  std::string name;
  double value = 0;
  double bound = 0;
  bool at_most = true;  // else at least
  bool holds() const;   // false when value or bound is not a number
};

// What one bench reports. Rows and claims keep the order in which they were made.
class Bench {
 public:
  Bench(std::string name, bool quick);

  // True: end within 3 minutes in all.
  bool quick() const { return quick_; }
  // A line about this machine in the report, beside CPU, cores and compiler (gl_renderer, say).
  void fact(const std::string& name, nlohmann::ordered_json value) {
    machine_[name] = std::move(value);
  }
  // Interleaved runs with the harness's number of rounds (fewer with --quick).
  Paired paired(const std::vector<Variant>& variants);
  void row(Row row);
  void claimAtMost(std::string name, double value, double bound);
  void claimAtLeast(std::string name, double value, double bound);
  // A knob that goes from scenario to scenario: time over it is plotted too.
  void sweeps(std::string knob) { swept_knob_ = std::move(knob); }
  const std::string& sweptKnob() const { return swept_knob_; }
  void curve(Curve curve) { curves_.push_back(std::move(curve)); }
  const std::vector<Curve>& curves() const { return curves_; }
  // A line on standard error.
  template <class... T>
  void progress(fmt::format_string<T...> format, T&&... args) const {
    progressLine(fmt::format(format, std::forward<T>(args)...));
  }

  const std::string& name() const { return name_; }
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<Claim>& claims() const { return claims_; }
  // What is wrong with the report itself (rows that are not numbers, no claim at all); empty: fine.
  std::vector<std::string> faults() const;
  // Every claim holds and the report has no fault.
  bool holds() const;
  nlohmann::ordered_json json() const;
  // Rows by scenario, then claims, for people.
  std::string table() const;

 private:
  void progressLine(std::string_view line) const;
  std::string name_, swept_knob_;
  bool quick_;
  nlohmann::ordered_json machine_;
  std::vector<Row> rows_;
  std::vector<Claim> claims_;
  std::vector<Curve> curves_;
};

using Run = void (*)(Bench&);
struct Registered {
  const char* name;
  const char* summary;
  Run run;
};
// All benches of this executable, by name.
std::vector<Registered> registered();
bool registerBench(const char* name, const char* summary, Run run);

// Draws one of a bench's views, PNGs below `directory`, which exists; returns their paths.
using DrawView = Result<std::vector<std::filesystem::path>> (*)(const std::string& view, bool quick,
                                                                const std::filesystem::path& directory);
// What --view may ask of a bench, in place of measuring.
bool registerViews(const char* bench, std::vector<std::string> views, DrawView draw);

// The command line of scree_bench. 0: all claims hold; 1: one fails; 2: bad usage.
int runBenches(int argc, const char* const* argv);

#define SCREE_BENCH(bench_name, summary)                                             \
  static void screeBench_##bench_name(::scree::bench::Bench&);                       \
  [[maybe_unused]] static const bool scree_bench_##bench_name##_registered =         \
      ::scree::bench::registerBench(#bench_name, summary, &screeBench_##bench_name); \
  static void screeBench_##bench_name([[maybe_unused]] ::scree::bench::Bench& bench)

}  // namespace scree::bench
