// Timing of variants against each other: interleaved runs, medians, ratios with quartiles.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace scree::bench {

struct Variant {
  std::string name;
  std::function<void()> run;           // timed; must finish its work (glFinish on the GPU)
  std::function<void()> prepare = {};  // before every timed run, not timed; resets the state
};

struct PairedOptions {
  int rounds = 15;  // timed runs of each variant, >= 1
  int warmup = 2;   // untimed runs of each variant before
  double min_sample_ms =
      1;                    // shorter runs are repeated to fill this, and divided; not with prepare
  double max_seconds = 60;  // stops after the round that passes it, but not before 3 rounds
  std::function<double()> now_ms = {};  // clock; default: steady_clock
};

// Quartiles of a sample; by linear interpolation between order statistics (Hyndman & Fan type 7).
struct Spread {
  double q1 = 0, median = 0, q3 = 0;
};
Spread spread(std::vector<double> sample);

struct Timing {
  std::string name;
  double median_ms = 0, q1_ms = 0, q3_ms = 0, min_ms = 0;
  std::vector<double> samples_ms;  // one a round, in order
};

struct Paired {
  std::vector<Timing> variants;  // in the order given
  // Of the per-round quotients time(a) / time(b): both ran side by side, so slow drift of the
  // machine cancels.
  Spread ratio(size_t a, size_t b) const;
};

// Runs A, B, ..., A, B, ... and times each run.
Paired pairedRuns(const std::vector<Variant>& variants, const PairedOptions& options = {});

}  // namespace scree::bench
