// The skip rule as a fixpoint.
#include "engine/frame/activity.h"

#include <algorithm>

namespace scree {

// Every rule only gets harder to meet when a pass goes off, so removing passes that break one,
// until none does, ends at the one largest set. Each round is linear in the uses; a round that
// removes nothing is the last, and in practice that is the second or third.
void Activity::decide(const std::vector<PassRules>& passes, const std::vector<uint8_t>& needs_met,
                      const std::vector<uint8_t>& read_outside) {
  decisions_.resize(passes.size());
  content_.resize(read_outside.size());
  read_.resize(read_outside.size());
  for (size_t i = 0; i < passes.size(); ++i)
    decisions_[i] = {needs_met[i] ? PassVerdict::On : PassVerdict::NeedsUnmet, 0};

  bool changed = true;
  while (changed) {
    changed = false;
    // Content flows forward.
    std::fill(content_.begin(), content_.end(), uint8_t{0});
    for (size_t i = 0; i < passes.size(); ++i) {
      PassDecision& decision = decisions_[i];
      if (decision.verdict != PassVerdict::On) continue;
      for (uint16_t resource : passes[i].content_needed)
        if (!content_[resource]) {
          decision = {PassVerdict::ContentMissing, resource};
          changed = true;
          break;
        }
      if (decision.verdict != PassVerdict::On) continue;
      for (uint16_t resource : passes[i].content_written) content_[resource] = 1;
    }
    // Readers reach back.
    std::copy(read_outside.begin(), read_outside.end(), read_.begin());
    for (size_t i = passes.size(); i-- > 0;) {
      PassDecision& decision = decisions_[i];
      if (decision.verdict != PassVerdict::On) continue;
      const std::vector<uint16_t>& written = passes[i].written;
      const bool wanted =
          std::any_of(written.begin(), written.end(), [&](uint16_t r) { return read_[r] != 0; });
      if (!wanted) {
        decision = {PassVerdict::NobodyReads, written.empty() ? uint16_t{0} : written.front()};
        changed = true;
        continue;
      }
      for (uint16_t resource : passes[i].read) read_[resource] = 1;
    }
  }
}

}  // namespace scree
