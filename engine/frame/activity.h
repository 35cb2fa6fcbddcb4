// Which passes are on: the largest set that obeys the three rules of frame.h. No GL, no strings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scree {

// One pass as the rules see it; resources are numbers below the size of `read_outside`.
struct PassRules {
  std::vector<uint16_t> content_needed;   // rule 2
  std::vector<uint16_t> content_written;  // every write but a clear
  std::vector<uint16_t> written;          // clears included
  std::vector<uint16_t> read;
};

// The first rule that a pass breaks.
enum class PassVerdict : uint8_t { On, NeedsUnmet, ContentMissing, NobodyReads };

struct PassDecision {
  PassVerdict verdict = PassVerdict::NeedsUnmet;
  // The first that has no content (ContentMissing), or is unread (NobodyReads).
  uint16_t resource = 0;
};

// Scratch space that is kept from frame to frame, so that deciding allocates nothing.
class Activity {
 public:
  // `needs_met`: one flag a pass; `read_outside`: one flag a resource, for the frame's output and
  // what is kept. Sets one decision a pass.
  void decide(const std::vector<PassRules>& passes, const std::vector<uint8_t>& needs_met,
              const std::vector<uint8_t>& read_outside);
  const std::vector<PassDecision>& decisions() const { return decisions_; }
  // True if a pass that is on writes the resource, by more than a clear.
  bool hasContent(size_t resource) const {
    return resource < content_.size() && content_[resource] != 0;
  }
  // True if a pass that is on reads the resource, or it is read outside.
  bool isRead(size_t resource) const { return resource < read_.size() && read_[resource] != 0; }

 private:
  std::vector<PassDecision> decisions_;
  std::vector<uint8_t> content_, read_;
};

}  // namespace scree
