// Interleaved timing: one round runs every variant once, so that noise meets all of them alike.
#include "tests/bench/paired.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/core/log.h"

namespace scree::bench {
namespace {

// Batches beyond this are not timed more precisely, only longer.
constexpr int kMaxBatch = 1 << 20;

double steadyMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double timeRuns(const Variant& variant, int batch, const std::function<double()>& now_ms) {
  if (variant.prepare) variant.prepare();
  const double start = now_ms();
  for (int i = 0; i < batch; ++i) variant.run();
  return (now_ms() - start) / batch;
}

// Runs per sample: doubled until a sample lasts long enough for the clock.
int findBatch(const Variant& variant, const PairedOptions& options,
              const std::function<double()>& now_ms) {
  if (variant.prepare) return 1;
  int batch = 1;
  while (batch < kMaxBatch && timeRuns(variant, batch, now_ms) * batch < options.min_sample_ms) {
    batch *= 2;
  }
  return batch;
}

}  // namespace

Spread spread(std::vector<double> sample) {
  if (sample.empty()) return {};
  std::sort(sample.begin(), sample.end());
  const auto quantile = [&](double p) {
    const double at = p * static_cast<double>(sample.size() - 1);
    const size_t below = static_cast<size_t>(at);
    const size_t above = std::min(below + 1, sample.size() - 1);
    return sample[below] + (at - static_cast<double>(below)) * (sample[above] - sample[below]);
  };
  return {quantile(0.25), quantile(0.5), quantile(0.75)};
}

Spread Paired::ratio(size_t a, size_t b) const {
  const std::vector<double>& top = variants.at(a).samples_ms;
  const std::vector<double>& bottom = variants.at(b).samples_ms;
  std::vector<double> quotients;
  quotients.reserve(top.size());
  for (size_t i = 0; i < top.size(); ++i) quotients.push_back(top[i] / bottom[i]);
  return spread(std::move(quotients));
}

Paired pairedRuns(const std::vector<Variant>& variants, const PairedOptions& options) {
  if (options.rounds < 1) fail("pairedRuns: rounds must be at least 1");
  const std::function<double()> now_ms = options.now_ms ? options.now_ms : steadyMs;
  const double start = now_ms();
  for (int i = 0; i < options.warmup; ++i) {
    for (const Variant& variant : variants) timeRuns(variant, 1, now_ms);
  }
  Paired result;
  std::vector<int> batches;
  for (const Variant& variant : variants) {
    batches.push_back(findBatch(variant, options, now_ms));
    result.variants.push_back({.name = variant.name});
  }
  for (int round = 0; round < options.rounds; ++round) {
    if (round >= 3 && now_ms() - start > options.max_seconds * 1e3) break;
    for (size_t i = 0; i < variants.size(); ++i) {
      result.variants[i].samples_ms.push_back(timeRuns(variants[i], batches[i], now_ms));
    }
  }
  for (Timing& timing : result.variants) {
    const Spread quartiles = spread(timing.samples_ms);
    timing.q1_ms = quartiles.q1;
    timing.median_ms = quartiles.median;
    timing.q3_ms = quartiles.q3;
    timing.min_ms = *std::min_element(timing.samples_ms.begin(), timing.samples_ms.end());
  }
  return result;
}

}  // namespace scree::bench
