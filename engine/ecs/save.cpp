// World::save: see save_format.h.
#include "engine/ecs/save_format.h"

#include <algorithm>
#include <cstring>

#include "engine/core/bytes.h"
#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/ecs/value_codec.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

// The tables that become one in the file, in the order of the first.
struct SavedTable {
  ComponentMask mask;
  std::vector<const Table*> parts;
  uint32_t rows = 0;
};

ComponentMask withoutTransient(const Table& table) {
  ComponentMask mask;
  for (ComponentId id : table.componentIds())
    if (!componentInfo(id).transient) mask.insert(id);
  return mask;
}

std::vector<SavedTable> savedTables(const WorldState& world) {
  std::vector<SavedTable> saved;
  for (const auto& table : world.tables) {
    const ComponentMask mask = withoutTransient(*table);
    auto found = std::find_if(saved.begin(), saved.end(),
                              [&](const SavedTable& other) { return other.mask == mask; });
    if (found == saved.end()) found = saved.insert(saved.end(), SavedTable{mask, {}, 0});
    found->parts.push_back(table.get());
    found->rows += static_cast<uint32_t>(table->size());
  }
  return saved;
}

void writeComponents(ByteWriter& writer, const std::vector<const ComponentInfo*>& infos) {
  writer.number(static_cast<uint32_t>(infos.size()));
  for (const ComponentInfo* info : infos) {
    writer.text(info->name);
    writer.number(static_cast<uint32_t>(info->fields.size()));
    for (const FieldInfo& field : info->fields) {
      writer.text(field.name);
      writer.number(static_cast<uint32_t>(field.type));
      writer.number(field.count);
    }
  }
}

void writeHandles(ByteWriter& writer, const EntitySlots& slots) {
  writer.number(static_cast<uint32_t>(slots.slots().size()));
  for (const EntitySlots::Slot& slot : slots.slots()) writer.number(slot.generation);
  writer.number(static_cast<uint32_t>(slots.freeIndices().size()));
  for (uint32_t index : slots.freeIndices()) writer.number(index);
}

void writeParts(ByteWriter& writer, const std::vector<WorldState::Part>& parts) {
  std::vector<std::pair<std::string_view, std::string>> filled;
  for (const WorldState::Part& part : parts)
    if (std::string bytes = part.claimed.save ? part.claimed.save() : part.unclaimed; !bytes.empty())
      filled.emplace_back(part.name, std::move(bytes));
  if (filled.empty()) return;
  writer.number(static_cast<uint32_t>(filled.size()));
  for (const auto& [name, bytes] : filled) {
    writer.text(name);
    writer.number(static_cast<uint64_t>(bytes.size()));
    writer.content.append(bytes);
  }
}

}  // namespace

std::string WorldState::saved() const {
  const std::vector<SavedTable> saved_tables = savedTables(*this);
  std::array<uint32_t, kMaxComponentTypes> index_of{};
  std::vector<const ComponentInfo*> infos;
  for (const ComponentInfo* info : components()) {
    const bool in_table =
        std::any_of(saved_tables.begin(), saved_tables.end(),
                    [&](const auto& table) { return table.mask.contains(info->id); });
    if (info->transient || !(in_table || singletons.has(info->id))) continue;
    index_of[info->id] = static_cast<uint32_t>(infos.size());
    infos.push_back(info);
  }

  ByteWriter writer;
  writer.content = kSaveMagic;
  writer.number(kSaveVersion);
  writer.number(uint64_t{0});  // the size, filled in below
  writeComponents(writer, infos);
  writeHandles(writer, slots);

  writer.number(static_cast<uint32_t>(saved_tables.size()));
  for (const SavedTable& table : saved_tables) {
    uint32_t count = 0;
    table.mask.each([&](ComponentId) { ++count; });
    writer.number(count);
    table.mask.each([&](ComponentId id) { writer.number(index_of[id]); });
    writer.number(table.rows);
    for (const Table* part : table.parts)
      for (Entity entity : part->entities()) writer.number(entity.index);
    table.mask.each([&](ComponentId id) {
      const ComponentInfo& info = componentInfo(id);
      if (info.size == 0) return;
      for (const Table* part : table.parts)
        for (size_t row = 0; row < part->size(); ++row)
          packValue(info, part->column(id).data + row * info.size, writer.content);
    });
  }

  uint32_t count = 0;
  for (const ComponentInfo* info : infos) count += singletons.has(info->id);
  writer.number(count);
  for (const ComponentInfo* info : infos) {
    if (!singletons.has(info->id)) continue;
    writer.number(index_of[info->id]);
    packValue(*info, static_cast<const std::byte*>(singletons.find(info->id)), writer.content);
  }
  writeParts(writer, parts);

  const uint64_t bytes = writer.content.size() + kSaveTrailerBytes;
  std::memcpy(writer.content.data() + kSaveMagic.size() + sizeof kSaveVersion, &bytes,
              sizeof bytes);
  writer.number(hashBytes(writer.content.data(), writer.content.size()));
  return std::move(writer.content);
}

std::string World::saveBytes() const {
  state_->requireAlone("save");
  return state_->saved();
}

Status World::save(const std::filesystem::path& path) const {
  const std::string content = saveBytes();
  if (content.size() > kMaxFileBytes)
    return Error{fmt::format("{}: the world takes {} bytes; at most {} are saved", path.string(),
                             content.size(), kMaxFileBytes)};
  return writeFile(path, content);
}

}  // namespace scree
