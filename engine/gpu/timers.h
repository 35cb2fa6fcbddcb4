// GPU time by name, read some frames late so that nothing ever waits for the GPU.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scree::gpu {

class Timers {
 public:
  Timers() = default;
  ~Timers();
  Timers(const Timers&) = delete;
  Timers& operator=(const Timers&) = delete;

  // Index of the timer of that name; made if there is none (its queries on first begin()).
  int find(std::string_view name);
  size_t count() const { return timers_.size(); }
  const std::string& name(int timer) const;

  // Each timer at most once a frame; different timers may nest. A measurement is skipped if all
  // its queries are still in flight.
  void begin(int timer);
  void end(int timer);
  // Takes in what has become available. Call once a frame.
  void poll();
  // Waits until every measurement has arrived; for the end of a run and for tests.
  void finish();

  double lastMs(int timer) const;          // negative: none yet
  int64_t lastStartNs(int timer) const;    // in the GPU's own clock; negative: none yet
  uint64_t measurements(int timer) const;  // taken in so far

  // Deletes all queries (the context goes away) but keeps names and results.
  void release();

 private:
  static constexpr int kDepth = 5;  // measurements in flight
  struct Timer {
    std::string name;
    unsigned queries[2 * kDepth] = {};  // pairs: begin, end
    int next = 0;                       // slot of the next begin()
    int pending = 0;                    // slots in flight, the oldest at next - pending
    bool open = false;
    double last_ms = -1;
    int64_t last_start_ns = -1;
    uint64_t measurements = 0;
  };
  bool take(Timer& timer, bool wait);
  std::vector<Timer> timers_;
};

}  // namespace scree::gpu
