// Entity: a generational handle to a row of the World.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "engine/core/hash.h"

namespace scree {

// A destroyed entity's index is reused with another generation, so a stale handle never names its
// successor. Generations begin at 1: a zeroed handle is never alive.
struct Entity {
  uint32_t index = 0xffffffffu;
  uint32_t generation = 0;

  static const Entity kNone;

  constexpr uint64_t bits() const { return uint64_t{generation} << 32 | index; }
  friend constexpr bool operator==(Entity, Entity) = default;
  friend constexpr auto operator<=>(Entity, Entity) = default;
};
inline constexpr Entity Entity::kNone{};

// Generation of a handle that Commands::spawn returned: it becomes an entity at World::flush().
inline constexpr uint32_t kPendingGeneration = 0xffffffffu;
// The last generation of an index. When it dies, the index is retired instead of wrapping around:
// 12 bytes lost after 2^32 - 2 reuses of one index, and no stale handle can ever become valid.
inline constexpr uint32_t kLastGeneration = 0xfffffffeu;

}  // namespace scree

template <>
struct std::hash<scree::Entity> {
  size_t operator()(scree::Entity entity) const { return scree::mix64(entity.bits()); }
};
