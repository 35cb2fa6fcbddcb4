// Registry, report and command line of scree_bench.
#include "tests/bench/bench.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <thread>

#include "engine/core/file.h"
#include "engine/core/parallel.h"
#include "tests/bench/plot.h"

namespace scree::bench {
namespace {

using Json = nlohmann::ordered_json;

std::vector<Registered>& registry() {
  static std::vector<Registered> benches;
  return benches;
}

struct Views {
  std::vector<std::string> names;
  DrawView draw = nullptr;
};
std::map<std::string, Views>& views() {
  static std::map<std::string, Views> all;
  return all;
}

int wrote(const char* flag, const Result<std::vector<std::filesystem::path>>& paths) {
  if (!paths.ok()) {
    fmt::print(stderr, "scree_bench: {}: {}\n", flag, paths.error());
    return 2;
  }
  for (const auto& path : paths.value()) fmt::print(stderr, "wrote {}\n", path.string());
  return 0;
}

int drawView(const char* bench, const std::string& view, bool quick, const std::string& directory) {
  const Views& offered = views()[bench];
  if (std::find(offered.names.begin(), offered.names.end(), view) == offered.names.end()) {
    fmt::print(stderr, "scree_bench: --view {}: {} has no such view; there are: {}\n", view, bench,
               offered.names.empty() ? "none" : fmt::to_string(fmt::join(offered.names, ", ")));
    return 2;
  }
  if (directory.empty()) {
    fmt::print(stderr, "scree_bench: --view {}: needs --plot DIR\n", view);
    return 2;
  }
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  return wrote("--view", offered.draw(view, quick, directory));
}

std::string cpuName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos) {
      return line.substr(line.find(": ") + 2);
    }
  }
  return "unknown";
}

Json describeMachine() {
  Json machine;
  machine["cpu"] = cpuName();
  machine["cores"] = std::thread::hardware_concurrency();
  machine["threads"] = threadCount();
  machine["compiler"] = __VERSION__;
#ifdef NDEBUG
  machine["asserts"] = false;
#else
  machine["asserts"] = true;
#endif
  return machine;
}

std::string hex(uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

std::string knobText(const Json& knobs) {
  std::string text;
  for (const auto& [name, value] : knobs.items()) {
    text += fmt::format("{}{}={}", text.empty() ? "" : " ", name,
                        value.is_string() ? value.get<std::string>() : value.dump());
  }
  return text;
}

}  // namespace

bool Claim::holds() const {
  return at_most ? value <= bound : value >= bound;
}

Bench::Bench(std::string name, bool quick)
    : name_(std::move(name)), quick_(quick), machine_(describeMachine()) {}

Paired Bench::paired(const std::vector<Variant>& variants) {
  PairedOptions options;
  options.rounds = quick_ ? 7 : 15;
  options.max_seconds = quick_ ? 10 : 60;
  return pairedRuns(variants, options);
}

void Bench::row(Row row) {
  progress("{}: {} {} {:.3f} ms, error {:.3g}", name_, row.scenario, row.label, row.time_ms,
           row.error);
  rows_.push_back(std::move(row));
}

void Bench::claimAtMost(std::string name, double value, double bound) {
  claims_.push_back({std::move(name), value, bound, true});
}

void Bench::claimAtLeast(std::string name, double value, double bound) {
  claims_.push_back({std::move(name), value, bound, false});
}

std::vector<std::string> Bench::faults() const {
  std::vector<std::string> faults;
  if (rows_.empty()) faults.push_back("no rows");
  if (claims_.empty()) faults.push_back("no claims");
  std::map<std::pair<std::string, std::string>, int> seen;
  for (const Row& row : rows_) {
    const std::string where = fmt::format("row '{}' of scenario '{}'", row.label, row.scenario);
    if (!(row.time_ms > 0) || !std::isfinite(row.time_ms)) {
      faults.push_back(
          fmt::format("{}: time_ms is {}, must be finite and above 0", where, row.time_ms));
    }
    if (!(row.error >= 0) || !std::isfinite(row.error)) {
      faults.push_back(
          fmt::format("{}: error is {}, must be finite and at least 0", where, row.error));
    }
    if (row.error_kind.empty()) faults.push_back(where + ": error_kind is empty");
    if (++seen[{row.scenario, row.label}] == 2) faults.push_back(where + ": label used twice");
  }
  return faults;
}

bool Bench::holds() const {
  return faults().empty() &&
         std::all_of(claims_.begin(), claims_.end(), [](const Claim& c) { return c.holds(); });
}

Json Bench::json() const {
  Json rows = Json::array(), claims = Json::array();
  for (const Row& row : rows_) {
    rows.push_back({{"scenario", row.scenario},
                    {"label", row.label},
                    {"knobs", row.knobs},
                    {"time_ms", row.time_ms},
                    {"error", row.error},
                    {"error_kind", row.error_kind},
                    {"hash", hex(row.hash)},
                    {"baseline", row.baseline},
                    {"measured", row.measured}});
  }
  for (const Claim& claim : claims_) {
    claims.push_back({{"name", claim.name},
                      {"value", claim.value},
                      {"bound", claim.bound},
                      {"sense", claim.at_most ? "at most" : "at least"},
                      {"holds", claim.holds()}});
  }
  return {{"bench", name_}, {"quick", quick_},  {"machine", machine_},
          {"rows", rows},   {"claims", claims}, {"faults", faults()}};
}

std::string Bench::table() const {
  std::string text;
  std::vector<std::string> done;
  for (const Row& first : rows_) {
    if (std::find(done.begin(), done.end(), first.scenario) != done.end()) continue;
    done.push_back(first.scenario);
    std::vector<Row> rows;
    std::copy_if(rows_.begin(), rows_.end(), std::back_inserter(rows),
                 [&](const Row& row) { return row.scenario == first.scenario; });
    const std::vector<size_t> front = paretoFront(rows);
    text += fmt::format("\n{} / {} (error: {}; * on the Pareto front, b baseline)\n", name_,
                        first.scenario, first.error_kind);
    text +=
        fmt::format("   {:<28} {:>12} {:>12} {:<17} {}\n", "", "time ms", "error", "hash", "knobs");
    for (size_t i = 0; i < rows.size(); ++i) {
      const bool best = std::find(front.begin(), front.end(), i) != front.end();
      text += fmt::format("{}{} {:<28} {:>12.4f} {:>12.4g} {:<17} {}\n", best ? '*' : ' ',
                          rows[i].baseline ? 'b' : ' ', rows[i].label, rows[i].time_ms,
                          rows[i].error, hex(rows[i].hash), knobText(rows[i].knobs));
      if (!rows[i].measured.empty()) text += fmt::format("      {}\n", knobText(rows[i].measured));
    }
  }
  text += "\n";
  for (const Claim& claim : claims_) {
    text +=
        fmt::format("{:<5} {}: {:.4g} ({} {:.4g})\n", claim.holds() ? "holds" : "FAILS", claim.name,
                    claim.value, claim.at_most ? "at most" : "at least", claim.bound);
  }
  for (const std::string& fault : faults()) text += "FAULT " + fault + "\n";
  return text;
}

void Bench::progressLine(std::string_view line) const {
  fmt::print(stderr, "{}\n", line);
}

std::vector<Registered> registered() {
  std::vector<Registered> sorted = registry();
  std::sort(sorted.begin(), sorted.end(), [](const Registered& a, const Registered& b) {
    return std::string_view(a.name) < std::string_view(b.name);
  });
  return sorted;
}

bool registerBench(const char* name, const char* summary, Run run) {
  registry().push_back({name, summary, run});
  return true;
}

bool registerViews(const char* bench, std::vector<std::string> names, DrawView draw) {
  views()[bench] = {std::move(names), draw};
  return true;
}

namespace {
int refuse(const Status& status) {
  fmt::print(stderr, "scree_bench: {}\n", status.error());
  return 2;
}
}  // namespace

int runBenches(int argc, const char* const* argv) {
  CLI::App cli(
      "Measures run time against error; exit status 0: all claims hold, 1: not, 2: bad usage",
      "scree_bench");
  std::string name, json_path, plot_directory, view;
  bool quick = false, list = false;
  cli.add_option("NAME", name, "bench to run; --list names them");
  cli.add_flag("--quick", quick, "fewer scenarios and runs: at most 3 minutes");
  cli.add_option("--json", json_path, "write machine, rows and claims to FILE")->type_name("FILE");
  cli.add_option("--plot", plot_directory, "write a picture of each scenario to DIR")
      ->type_name("DIR");
  cli.add_option("--view", view, "measure nothing, but write pictures of how it draws to the --plot DIR (lod: "
                 "representation, overdraw, frozen)")
      ->type_name("VIEW");
  cli.add_flag("--list", list, "name the benches");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }
  const std::vector<Registered> benches = registered();
  if (list) {
    for (const Registered& each : benches) fmt::print("{:<12} {}\n", each.name, each.summary);
    return 0;
  }
  std::string names;
  const Registered* chosen = nullptr;
  for (const Registered& each : benches) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", each.name);
    if (name == each.name) chosen = &each;
  }
  if (!chosen) {
    fmt::print(stderr, "scree_bench: {}; there are: {}\n",
               name.empty() ? "name a bench" : "no bench '" + name + "'", names);
    return 2;
  }
  // Before minutes of measuring.
  if (!json_path.empty())
    if (const Status fine = checkOutputPath(json_path, "--json"); !fine.ok()) return refuse(fine);
  if (!plot_directory.empty()) {
    std::error_code ignored;
    std::filesystem::create_directories(plot_directory, ignored);
    if (const Status fine = checkOutputPath(std::filesystem::path(plot_directory) / "plot.svg", "--plot"); !fine.ok()) return refuse(fine);
  }
  if (!view.empty()) return drawView(chosen->name, view, quick, plot_directory);
  Bench bench(chosen->name, quick);
  chosen->run(bench);
  fmt::print("{}", bench.table());
  std::fflush(stdout);
  if (!json_path.empty()) {
    if (Status written = writeFile(json_path, bench.json().dump(2) + "\n"); !written.ok()) {
      fmt::print(stderr, "scree_bench: --json: {}\n", written.error());
      return 2;
    }
  }
  if (!plot_directory.empty()) {
    if (const int failed = wrote("--plot", writePlots(bench, plot_directory)); failed != 0) return failed;
  }
  return bench.holds() ? 0 : 1;
}

}  // namespace scree::bench
