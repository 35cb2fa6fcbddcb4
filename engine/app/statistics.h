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
  // After each tick: the systems' CPU times and the tick's own, milliseconds.
  void addTick(const Schedule& schedule, double tick_ms);
  // After each rendered frame: the passes' times, the frame's own, and what the GPU was asked for.
  void addFrame(const Frame& frame, double frame_ms, const gpu::Counters& work);

  // Writes the JSON. Times are in milliseconds: {median, p99, count}.
  Status write(const std::filesystem::path& path, const std::vector<Gauge>& gauges,
               const std::string& context, ivec2 size, int threads, double wall_s) const;

 private:
  struct Series {
    std::vector<float> values;
    void add(double value) { values.push_back(static_cast<float>(value)); }
  };
  struct PassSeries {
    Series cpu, gpu;
  };
  std::map<std::string, Series> systems_;
  std::map<std::string, PassSeries> passes_;
  Series ticks_, frames_, draws_, dispatches_, bytes_uploaded_;
};

}  // namespace scree
