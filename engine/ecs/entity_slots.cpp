// Allocation and release of entity handles.
#include "engine/ecs/entity_slots.h"

#include <algorithm>

#include "engine/core/log.h"

namespace scree {

Entity EntitySlots::allocate(uint32_t table, uint32_t row) {
  Entity handle;
  allocateMany(table, row, {&handle, 1});
  return handle;
}

void EntitySlots::allocateMany(uint32_t table, uint32_t first_row, std::span<Entity> handles) {
  const size_t reused = std::min(handles.size(), free_.size());
  const size_t fresh = handles.size() - reused;
  // The index of Entity::kNone is never given out.
  if (slots_.size() + fresh > Entity::kNone.index)
    fail(fmt::format("{} entities; at most {}", slots_.size() + fresh, Entity::kNone.index));
  for (size_t i = 0; i < reused; ++i) {
    const uint32_t index = free_.back();
    free_.pop_back();
    Slot& slot = slots_[index];
    slot.table = table;
    slot.row = first_row + static_cast<uint32_t>(i);
    handles[i] = {index, slot.generation};
  }
  if (fresh) {
    const size_t begin = slots_.size();
    if (slots_.capacity() < begin + fresh) slots_.reserve(std::max(begin + fresh, begin * 2));
    for (size_t i = 0; i < fresh; ++i) {
      slots_.push_back({1, table, first_row + static_cast<uint32_t>(reused + i)});
      handles[reused + i] = {static_cast<uint32_t>(begin + i), 1};
    }
  }
  alive_ += handles.size();
}

void EntitySlots::release(Entity entity) {
  Slot& slot = slots_[entity.index];
  slot.table = kNoTable;
  --alive_;
  if (slot.generation == last_generation_) {
    slot.generation = kPendingGeneration;  // retired: no handle has this generation
    return;
  }
  ++slot.generation;
  free_.push_back(entity.index);
}

void EntitySlots::restore(std::vector<Slot> slots, std::vector<uint32_t> free_indices) {
  slots_ = std::move(slots);
  free_ = std::move(free_indices);
  alive_ = static_cast<size_t>(std::count_if(
      slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.table != kNoTable; }));
}

}  // namespace scree
