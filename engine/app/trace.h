// A timeline of systems and passes in the Chrome trace format (chrome://tracing, Perfetto).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/ecs/schedule.h"
#include "engine/frame/frame.h"

namespace scree {

class Trace {
 public:
  void addSystems(const Schedule& schedule, std::initializer_list<Phase> phases);
  void addPasses(const Frame& frame);
  // Writes {"traceEvents": [...]}: one row for systems, one for passes on the CPU, one on the GPU.
  Status write(const std::filesystem::path& path) const;

 private:
  // Beyond this many events the rest of the run is left out, and the file says so.
  static constexpr size_t kMaxEvents = 2'000'000;
  enum class Row : uint8_t { Systems = 1, Passes = 2, Gpu = 3 };
  struct Event {
    std::string name;
    Row row;
    int64_t start_ns;
    double duration_ms;
  };
  void add(const std::string& name, Row row, int64_t start_ns, double duration_ms);
  std::vector<Event> events_;
  size_t dropped_ = 0;
};

}  // namespace scree
