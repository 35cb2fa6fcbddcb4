// Structural changes: rows come, go and move between tables.
#include "engine/ecs/world_state.h"

#include <algorithm>
#include <cstring>

#include "engine/core/log.h"

namespace scree {

void WorldState::requireAlone(std::string_view operation) const {
  if (shared_systems.load(std::memory_order_relaxed) > 0) {
    const CommandScope* scope = CommandScope::current();
    const std::string who = scope && scope->access() ? scope->access()->name : "?";
    fail(fmt::format("World::{} in system '{}', which is not exclusive: use World::commands()",
                     operation, who));
  }
  if (iterations.load(std::memory_order_relaxed) > 0)
    fail(fmt::format("World::{} while a query iterates: use World::commands()", operation));
}

Table& WorldState::tableOf(const ComponentMask& mask) {
  if (const auto found = table_of_mask.find(mask); found != table_of_mask.end())
    return *found->second;
  tables.push_back(std::make_unique<Table>(mask, static_cast<uint32_t>(tables.size()), clock));
  Table& table = *tables.back();
  table_of_mask.emplace(mask, &table);
  for (const auto& query : queries)
    if (query->signature().matches(mask)) query->addTable(table);
  return table;
}

Table& WorldState::tableOf(std::span<const ComponentValue> values) {
  ComponentMask mask;
  for (const ComponentValue& value : values) {
    if (mask.contains(value.id))
      fail(fmt::format("an entity is spawned with '{}' twice", componentInfo(value.id).name));
    mask.insert(value.id);
  }
  return tableOf(mask);
}

Table& WorldState::tableWith(Table& table, ComponentId id) {
  Table::Edge& edge = table.edge(id);
  if (!edge.with) {
    ComponentMask mask = table.mask();
    mask.insert(id);
    edge.with = &tableOf(mask);
  }
  return *edge.with;
}

Table& WorldState::tableWithout(Table& table, ComponentId id) {
  Table::Edge& edge = table.edge(id);
  if (!edge.without) {
    ComponentMask mask = table.mask();
    mask.erase(id);
    edge.without = &tableOf(mask);
  }
  return *edge.without;
}

Entity WorldState::spawn(std::span<const ComponentValue> values) {
  Table& table = tableOf(values);
  const uint32_t row = table.append(1);
  const Entity entity = table.entities_[row] = slots.allocate(table.index_, row);
  for (const ComponentValue& value : values) {
    Column& column = *table.findColumn(value.id);
    const size_t size = column.info->size;
    if (size)
      std::memcpy(column.data + row * size, value.value ? value.value : column.info->default_value,
                  size);
  }
  return entity;
}

TableRows WorldState::appendRows(Table& table, size_t count) {
  const uint32_t first = table.append(count);
  slots.allocateMany(table.index_, first, {table.entities_ + first, count});
  return {&table, first, count};
}

TableRows WorldState::spawnMany(size_t count, std::span<const ComponentValue> values) {
  const TableRows rows = appendRows(tableOf(values), count);
  for (const ComponentValue& value : values) {
    Column& column = *rows.table->findColumn(value.id);
    rows.table->fill(column, rows.begin, count,
                     value.value ? value.value : column.info->default_value);
  }
  return rows;
}

TableRows WorldState::spawnRaw(size_t count, std::span<const ComponentId> ids) {
  std::array<ComponentValue, kMaxComponentTypes> values;
  for (size_t i = 0; i < ids.size(); ++i) values[i] = {ids[i], nullptr};
  return appendRows(tableOf(std::span(values).first(ids.size())), count);
}

void WorldState::closeGap(Table& table, uint32_t row) {
  const Entity moved = table.removeRow(row);
  if (moved != Entity::kNone) slots.find(moved)->row = row;
}

bool WorldState::destroy(Entity entity) {
  const EntitySlots::Slot* slot = slots.find(entity);
  if (!slot) return false;
  closeGap(*tables[slot->table], slot->row);
  slots.release(entity);
  return true;
}

size_t WorldState::destroyMany(std::span<const Entity> entities) {
  doomed_rows.clear();
  doomed_of_table.assign(tables.size(), 0);
  for (Entity entity : entities) {
    const EntitySlots::Slot* slot = slots.find(entity);
    if (!slot) continue;
    // In a table the last row goes first, so that no row moves into a doomed one's place.
    doomed_rows.push_back(uint64_t{slot->table} << 32 | (0xffffffffu - slot->row));
    ++doomed_of_table[slot->table];
    slots.release(entity);
  }
  const size_t destroyed = doomed_rows.size();
  std::erase_if(doomed_rows, [&](uint64_t doomed) {
    const size_t table = doomed >> 32;
    return doomed_of_table[table] == tables[table]->size();
  });
  for (size_t table = 0; table < tables.size(); ++table)
    if (doomed_of_table[table] && doomed_of_table[table] == tables[table]->size())
      tables[table]->removeAll();
  std::sort(doomed_rows.begin(), doomed_rows.end());
  for (uint64_t doomed : doomed_rows)
    closeGap(*tables[doomed >> 32], 0xffffffffu - static_cast<uint32_t>(doomed));
  return destroyed;
}

void WorldState::clear() {
  for (const auto& table : tables) {
    for (Entity entity : table->entities()) slots.release(entity);
    table->removeAll();
  }
}

EntitySlots::Slot& WorldState::moveRow(Entity entity, Table& to) {
  EntitySlots::Slot& slot = *slots.find(entity);
  Table& from = *tables[slot.table];
  const uint32_t from_row = slot.row;
  const uint32_t row = to.append(1);
  to.entities_[row] = entity;
  to.copyRow(row, from, from_row);
  closeGap(from, from_row);
  slot.table = to.index_;
  slot.row = row;
  return slot;
}

void* WorldState::valueAt(Table& table, ComponentId id, uint32_t row) {
  const Column& column = table.column(id);
  return column.info->size ? column.data + size_t{row} * column.info->size
                           : emptyValue(*column.info);
}

void* WorldState::find(Entity entity, ComponentId id, bool marks_changed) {
  const EntitySlots::Slot* slot = slots.find(entity);
  if (!slot) return nullptr;
  Table& table = *tables[slot->table];
  if (!table.has(id)) return nullptr;
  if (marks_changed) table.touch(id);
  return valueAt(table, id, slot->row);
}

void* WorldState::add(Entity entity, ComponentValue value) {
  EntitySlots::Slot* slot = slots.find(entity);
  if (!slot) return nullptr;
  if (!tables[slot->table]->has(value.id))
    slot = &moveRow(entity, tableWith(*tables[slot->table], value.id));
  Table& table = *tables[slot->table];
  table.touch(value.id);
  void* target = valueAt(table, value.id, slot->row);
  const ComponentInfo& info = componentInfo(value.id);
  if (info.size) std::memcpy(target, value.value ? value.value : info.default_value, info.size);
  return target;
}

bool WorldState::remove(Entity entity, ComponentId id) {
  const EntitySlots::Slot* slot = slots.find(entity);
  if (!slot || !tables[slot->table]->has(id)) return false;
  moveRow(entity, tableWithout(*tables[slot->table], id));
  return true;
}

}  // namespace scree
