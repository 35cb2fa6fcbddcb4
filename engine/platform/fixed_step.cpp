// Fixed-step time keeping.
#include "engine/platform/fixed_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/log.h"

namespace scree {

FixedStep::FixedStep(double step_s, int max_ticks) : step_s_(step_s), max_ticks_(max_ticks) {
  if (!(step_s > 0) || !std::isfinite(step_s) || max_ticks < 1)
    fail(fmt::format("FixedStep: step {} s, {} ticks at most; both must be above 0", step_s,
                     max_ticks));
}

int FixedStep::advance(double elapsed_s) {
  if (!(elapsed_s > 0) || !std::isfinite(elapsed_s)) return 0;
  owed_s_ += elapsed_s;
  // fmod is exact: what is owed stays below one step however large the time is.
  const double rest_s = std::fmod(owed_s_, step_s_);
  const double ticks = std::round((owed_s_ - rest_s) / step_s_);
  owed_s_ = rest_s;
  if (ticks <= max_ticks_) return static_cast<int>(ticks);
  dropped_s_ += (ticks - max_ticks_) * step_s_;
  return max_ticks_;
}

float FixedStep::alpha() const {
  constexpr float kBelowOne = 1.0f - std::numeric_limits<float>::epsilon() / 2;
  return std::min(static_cast<float>(owed_s_ / step_s_), kBelowOne);
}

}  // namespace scree
