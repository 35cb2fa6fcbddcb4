// Recording of commands, and their application in the order of their keys.
#include "engine/ecs/commands.h"

#include <algorithm>
#include <cstring>

#include "engine/core/log.h"
#include "engine/ecs/world_state.h"

namespace scree {

void Commands::push(const void* data, size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

void Commands::pushHeader(const Header& header) {
  if (!open_) fail("a Commands buffer is used after its flush: call World::commands() again");
  push(&header, sizeof header);
}

void Commands::pushValue(ComponentValue value) {
  const ComponentInfo& info = componentInfo(value.id);
  push(value.value ? value.value : info.default_value, info.size);
}

Entity Commands::spawn(std::span<const ComponentValue> values) {
  pushHeader({Op::Spawn, static_cast<uint32_t>(values.size()), Entity::kNone});
  for (const ComponentValue& value : values) {
    push(&value.id, sizeof value.id);
    pushValue(value);
  }
  return {spawned_++, kPendingGeneration};
}

void Commands::destroy(Entity entity) {
  pushHeader({Op::Destroy, 0, entity});
}

void Commands::add(Entity entity, ComponentValue value) {
  pushHeader({Op::Add, value.id, entity});
  pushValue(value);
}

void Commands::remove(Entity entity, ComponentId id) {
  pushHeader({Op::Remove, id, entity});
}

Commands& WorldState::openCommands(const CommandKey& key) {
  const std::lock_guard lock(commands_mutex);
  if (idle_commands.empty()) idle_commands.push_back(std::make_unique<Commands>());
  pending.push_back({key, std::move(idle_commands.back())});
  idle_commands.pop_back();
  Commands& commands = *pending.back().commands;
  commands.open_ = true;
  return commands;
}

FlushResult WorldState::flush() {
  FlushResult result;
  std::sort(pending.begin(), pending.end(),
            [](const PendingCommands& a, const PendingCommands& b) { return a.key < b.key; });
  for (PendingCommands& entry : pending) {
    apply(*entry.commands, result);
    entry.commands->bytes_.clear();
    entry.commands->spawned_ = 0;
    entry.commands->open_ = false;
    idle_commands.push_back(std::move(entry.commands));
  }
  pending.clear();
  root_scope.restart();
  return result;
}

void WorldState::apply(const Commands& commands, FlushResult& result) {
  spawned.clear();
  const std::byte* at = commands.bytes_.data();
  const std::byte* const end = at + commands.bytes_.size();
  std::array<ComponentValue, kMaxComponentTypes> values;
  while (at != end) {
    Commands::Header header;
    std::memcpy(&header, at, sizeof header);
    at += sizeof header;
    if (header.entity.generation == kPendingGeneration && header.entity.index < spawned.size())
      header.entity = spawned[header.entity.index];
    bool done = true;
    switch (header.op) {
      case Commands::Op::Spawn: {
        for (uint32_t i = 0; i < header.count; ++i) {
          std::memcpy(&values[i].id, at, sizeof(ComponentId));
          at += sizeof(ComponentId);
          values[i].value = at;
          at += componentInfo(values[i].id).size;
        }
        const Entity entity = spawn({values.data(), header.count});
        spawned.push_back(entity);
        for (uint32_t i = 0; i < header.count; ++i) resolvePending(entity, values[i].id);
        break;
      }
      case Commands::Op::Destroy:
        done = destroy(header.entity);
        break;
      case Commands::Op::Add:
        done = add(header.entity, {header.count, at}) != nullptr;
        at += componentInfo(header.count).size;
        if (done) resolvePending(header.entity, header.count);
        break;
      case Commands::Op::Remove:
        done = remove(header.entity, header.count);
        break;
    }
    ++(done ? result.applied : result.refused);
  }
}

void WorldState::resolvePending(Entity entity, ComponentId id) {
  const ComponentInfo& info = componentInfo(id);
  if (!info.has_entities) return;
  const EntitySlots::Slot& slot = *slots.find(entity);
  auto* value = static_cast<std::byte*>(valueAt(*tables[slot.table], id, slot.row));
  for (const FieldInfo& field : info.fields) {
    if (field.type != FieldType::Entity) continue;
    for (uint32_t i = 0; i < field.count; ++i) {
      Entity handle;
      std::byte* where = value + field.offset + i * sizeof handle;
      std::memcpy(&handle, where, sizeof handle);
      if (handle.generation != kPendingGeneration) continue;
      handle = handle.index < spawned.size() ? spawned[handle.index] : Entity::kNone;
      std::memcpy(where, &handle, sizeof handle);
    }
  }
}

}  // namespace scree
