// What a run cost: medians and percentiles of times by system and pass, and work by frame, as JSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "engine/ecs/schedule.h"
#include "engine/frame/frame.h"
#include "engine/gpu/counters.h"

namespace scree {

// A number that a module reports about the world, by name: "grains".
struct Gauge {
  std::string name;
  std::function<double()> read;
};

class Statistics {
 public:
  // After each tick: the CPU times of the systems that ran, and the tick's own, milliseconds.
  void addTick(const Schedule& schedule, double tick_ms);
  // After each rendered frame: the same of its systems, the passes' times, the frame's own (with the
  // wait for ticks beside it), and what the GPU was asked for.
  void addFrame(const Schedule& schedule, const Frame& frame, double frame_ms,
                const gpu::Counters& work);

  // Writes the JSON. Times are in milliseconds: {median, p99, count}.
  Status write(const std::filesystem::path& path, const std::vector<Gauge>& gauges,
               const std::string& context, ivec2 size, int threads, double wall_s) const;

 private:
  struct Series {
    std::vector<float> values;
    void add(double value) { values.push_back(static_cast<float>(value)); }
  };
  struct SystemSeries {
    Series cpu;
    uint64_t runs = 0;  // as of the last look
  };
  struct PassSeries {
    Series cpu, gpu;
    int64_t gpu_start_ns = -1;  // of the last measurement
  };
  void addSystems(const Schedule& schedule);

  std::map<std::string, SystemSeries> systems_;
  std::map<std::string, PassSeries> passes_;
  Series ticks_, frames_, draws_, dispatches_, bytes_uploaded_;
};

}  // namespace scree
