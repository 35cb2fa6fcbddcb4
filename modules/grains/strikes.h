// Contacts of a tick that passed a limit of impulse or approach: what is told as GrainStrikes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/contacts.h"

namespace scree::grains {

// 0, negative, NaN: not asked for.
struct StrikeLimits {
  float impulse = 0;  // N s, in the tick
  float speed = 0;    // m/s
  bool asked() const { return impulse > 0 || speed > 0; }
};

struct Strike {
  Entity a;                // of a pair the lower one
  Entity b;                // Entity::kNone: a collider
  uint32_t collider = 0;   // its key
  vec3 position{0};        // of the contact, relative to the field's origin
  vec3 normal{0};          // from b to a
  float impulse = 0;       // N s
  float speed = 0;         // m/s
};

class Strikes {
 public:
  void begin(const StrikeLimits& limits, int substeps);
  // After the passes of a substep, before anything has moved.
  void note(const PairLists& pairs, const ColliderLists& walls, const Bodies& bodies);
  // Keeps those that passed a limit.
  void close();
  // By entities, then collider.
  std::span<const Strike> found() const { return found_; }
  size_t memoryBytes() const;

 private:
  void add(std::vector<Strike>& out, const Strike& strike) const;

  StrikeLimits limits_;
  float share_ = 0;  // of the impulse limit, a substep
  std::vector<Strike> found_, merged_;
  std::vector<std::vector<Strike>> noted_;  // by slab
};

}  // namespace scree::grains
