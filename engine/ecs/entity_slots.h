// EntitySlots: which handles are alive, and where their rows are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ecs/entity.h"

namespace scree {

class EntitySlots {
 public:
  static constexpr uint32_t kNoTable = 0xffffffffu;

  struct Slot {
    uint32_t generation = 1;    // of the entity that lives here, or that will live here next
    uint32_t table = kNoTable;  // index in the World's list; kNoTable: nobody lives here
    uint32_t row = 0;
  };

  // Tests pass a small last generation to see indices retire.
  explicit EntitySlots(uint32_t last_generation = kLastGeneration)
      : last_generation_(last_generation) {}

  // The handle for a row; indices that were freed last are used first.
  Entity allocate(uint32_t table, uint32_t row);
  // As many handles as `handles` is long, for consecutive rows.
  void allocateMany(uint32_t table, uint32_t first_row, std::span<Entity> handles);
  // The entity must be alive.
  void release(Entity entity);

  // nullptr if the entity is dead. The pointer is valid until the next allocation.
  Slot* find(Entity entity) {
    if (entity.index >= slots_.size()) return nullptr;
    Slot& slot = slots_[entity.index];
    return slot.generation == entity.generation && slot.table != kNoTable ? &slot : nullptr;
  }
  const Slot* find(Entity entity) const { return const_cast<EntitySlots*>(this)->find(entity); }

  size_t aliveCount() const { return alive_; }
  std::span<const Slot> slots() const { return slots_; }
  // Indices to reuse, the next one last.
  std::span<const uint32_t> freeIndices() const { return free_; }
  // Takes over a saved state; the caller has checked it.
  void restore(std::vector<Slot> slots, std::vector<uint32_t> free_indices);

 private:
  uint32_t last_generation_;
  std::vector<Slot> slots_;
  std::vector<uint32_t> free_;
  size_t alive_ = 0;
};

}  // namespace scree
