// Collects timed events and writes them as Chrome trace JSON, one complete ("X") event each.
#include "engine/app/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>

#include "engine/core/file.h"

namespace scree {

void Trace::add(const std::string& name, Row row, int64_t start_ns, double duration_ms) {
  if (start_ns < 0 || duration_ms < 0) return;
  if (events_.size() == kMaxEvents) {
    ++dropped_;
    return;
  }
  events_.push_back({name, row, start_ns, duration_ms});
}

void Trace::addSystems(const Schedule& schedule, std::initializer_list<Phase> phases) {
  for (const SystemReport& system : schedule.report())
    if (system.on && std::find(phases.begin(), phases.end(), system.phase) != phases.end())
      add(system.name, Row::Systems, static_cast<int64_t>(system.begin_s * 1e9), system.cpu_ms);
}

void Trace::addPasses(const Frame& frame) {
  for (const PassReport& pass : frame.report()) {
    if (!pass.on) continue;
    add(pass.name, Row::Passes, pass.start_ns, pass.cpu_ms);
    add(pass.name, Row::Gpu, pass.gpu_start_ns, pass.gpu_ms);
  }
}

Status Trace::write(const std::filesystem::path& path) const {
  // Each row begins at 0 of its own clock: the GPU's differs from the CPU's.
  int64_t cpu_zero = std::numeric_limits<int64_t>::max(), gpu_zero = cpu_zero;
  for (const Event& event : events_) {
    int64_t& zero = event.row == Row::Gpu ? gpu_zero : cpu_zero;
    zero = std::min(zero, event.start_ns);
  }
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "{{\"displayTimeUnit\": \"ms\", \"otherData\": {{\"dropped_events\": {}}},\n"
                     "\"traceEvents\": [\n", dropped_);
  for (const auto& [row, name] : {std::pair{Row::Systems, "systems (CPU)"},
                                  std::pair{Row::Passes, "passes (CPU)"},
                                  std::pair{Row::Gpu, "passes (GPU, own clock)"}})
    fmt::format_to(to,
                   "{{\"ph\": \"M\", \"pid\": 1, \"tid\": {}, \"name\": \"thread_name\", "
                   "\"args\": {{\"name\": \"{}\"}}}},\n",
                   static_cast<int>(row), name);
  for (const Event& event : events_) {
    const int64_t zero = event.row == Row::Gpu ? gpu_zero : cpu_zero;
    fmt::format_to(to,
                   "{{\"ph\": \"X\", \"pid\": 1, \"tid\": {}, \"name\": \"{}\", \"ts\": {:.3f}, "
                   "\"dur\": {:.3f}}},\n",
                   static_cast<int>(event.row), event.name,
                   static_cast<double>(event.start_ns - zero) * 1e-3, event.duration_ms * 1e3);
  }
  fmt::format_to(to, "{{\"ph\": \"M\", \"pid\": 1, \"name\": \"process_name\", "
                     "\"args\": {{\"name\": \"scree\"}}}}\n]}}\n");
  return writeFile(path, std::string_view(out.data(), out.size()));
}

}  // namespace scree
