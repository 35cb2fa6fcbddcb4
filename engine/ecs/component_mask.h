// ComponentMask: a set of component types.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "engine/core/hash.h"
#include "engine/ecs/component.h"

namespace scree {

struct ComponentMask {
  std::array<uint64_t, kMaxComponentTypes / 64> words{};

  void insert(ComponentId id) { words[id / 64] |= uint64_t{1} << id % 64; }
  void erase(ComponentId id) { words[id / 64] &= ~(uint64_t{1} << id % 64); }
  bool contains(ComponentId id) const { return words[id / 64] >> id % 64 & 1; }
  bool containsAll(const ComponentMask& other) const {
    for (size_t i = 0; i < words.size(); ++i)
      if (other.words[i] & ~words[i]) return false;
    return true;
  }
  bool intersects(const ComponentMask& other) const {
    for (size_t i = 0; i < words.size(); ++i)
      if (other.words[i] & words[i]) return true;
    return false;
  }
  // Calls visit(id) in ascending order.
  template <class Visit>
  void each(Visit&& visit) const {
    for (size_t i = 0; i < words.size(); ++i)
      for (uint64_t rest = words[i]; rest; rest &= rest - 1)
        visit(static_cast<ComponentId>(i * 64 + std::countr_zero(rest)));
  }
  friend bool operator==(const ComponentMask&, const ComponentMask&) = default;
};

struct ComponentMaskHash {
  size_t operator()(const ComponentMask& mask) const {
    uint64_t hash = 0;
    for (uint64_t word : mask.words) hash = hashCombine(hash, word);
    return hash;
  }
};

}  // namespace scree
