// Collects series of numbers and writes their medians and 99th percentiles.
#include "engine/app/statistics.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine/app/app.h"
#include "engine/core/file.h"

namespace scree {
namespace {

// Value at a fraction of the sorted values (nearest rank); 0 for none.
double percentile(std::vector<float> values, double fraction) {
  if (values.empty()) return 0;
  const auto rank = static_cast<size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

nlohmann::ordered_json summary(const std::vector<float>& values) {
  return {{"median", percentile(values, 0.5)},
          {"p99", percentile(values, 0.99)},
          {"count", values.size()}};
}

}  // namespace

void Statistics::addTick(const Schedule& schedule, double tick_ms) {
  ticks_.add(tick_ms);
  addSystems(schedule);
}

void Statistics::addSystems(const Schedule& schedule) {
  for (const SystemReport& system : schedule.report()) {
    if (system.runs == 0) continue;
    SystemSeries& series = systems_[system.name];
    if (system.runs != series.runs) series.cpu.add(system.cpu_ms);
    series.runs = system.runs;
  }
}

void Statistics::addFrame(const Schedule& schedule, const Frame& frame, double frame_ms,
                          const gpu::Counters& work) {
  frames_.add(frame_ms);
  addSystems(schedule);
  draws_.add(static_cast<double>(work.draws));
  dispatches_.add(static_cast<double>(work.dispatches));
  bytes_uploaded_.add(static_cast<double>(work.bytes_uploaded));
  for (const PassReport& pass : frame.report()) {
    if (!pass.on) continue;
    PassSeries& series = passes_[pass.name];
    series.cpu.add(pass.cpu_ms);
    // GPU times arrive some frames late; the last known one stays until the next.
    if (pass.gpu_ms >= 0 && pass.gpu_start_ns != series.gpu_start_ns) series.gpu.add(pass.gpu_ms);
    series.gpu_start_ns = pass.gpu_start_ns;
  }
}

Status Statistics::write(const std::filesystem::path& path, const std::vector<Gauge>& gauges,
                         const std::string& context, ivec2 size, int threads,
                         double wall_s) const {
  nlohmann::ordered_json json;
  json["context"] = context;
  json["size"] = {size.x, size.y};
  json["threads"] = threads;
  json["wall_s"] = wall_s;
  json["simulated_s"] = static_cast<double>(ticks_.values.size()) * kTickSeconds;
  json["simulated_s_per_wall_s"] =
      wall_s > 0 ? static_cast<double>(ticks_.values.size()) * kTickSeconds / wall_s : 0.0;
  json["frames_per_wall_s"] =
      wall_s > 0 ? static_cast<double>(frames_.values.size()) / wall_s : 0.0;
  for (const Gauge& gauge : gauges) json[gauge.name] = gauge.read();
  json["tick_ms"] = summary(ticks_.values);
  json["frame_ms"] = summary(frames_.values);
  json["draws"] = summary(draws_.values);
  json["dispatches"] = summary(dispatches_.values);
  json["bytes_uploaded"] = summary(bytes_uploaded_.values);
  for (const auto& [name, series] : systems_) json["systems"][name]["cpu_ms"] = summary(series.cpu.values);
  for (const auto& [name, series] : passes_) {
    json["passes"][name]["cpu_ms"] = summary(series.cpu.values);
    json["passes"][name]["gpu_ms"] = summary(series.gpu.values);
  }
  return writeFile(path, json.dump(2) + "\n");
}

}  // namespace scree
