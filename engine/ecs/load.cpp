// World::load: checks every number of the file before it replaces anything; see save_format.h.
#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>

#include "engine/core/bytes.h"
#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/ecs/save_format.h"
#include "engine/ecs/value_codec.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

uint32_t uint32At(const char* from, size_t index) {
  uint32_t value;
  std::memcpy(&value, from + index * sizeof value, sizeof value);
  return value;
}

// What may be printed in an error's line.
bool isPlainName(std::string_view name) {
  return !name.empty() && name.size() <= 128 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
}

struct LoadedSingleton {
  const ComponentInfo* info;
  const char* packed;
};

struct LoadedPart {
  std::string_view name, bytes;
};

// What the file holds, complete and checked, before it replaces the World's content.
class Loading {
 public:
  Loading(std::string_view body, VersionClock& clock) : reader_(body), clock_(clock) {}

  // The error's line without the file, or nothing.
  std::optional<std::string> read() {
    for (auto step : {&Loading::readComponents, &Loading::readHandles, &Loading::readTables,
                      &Loading::readSingletons, &Loading::readParts}) {
      if (auto error = (this->*step)()) return error;
    }
    return {};
  }

  std::vector<EntitySlots::Slot> slots;
  std::vector<uint32_t> free_indices;
  std::vector<std::unique_ptr<Table>> tables;
  std::vector<LoadedSingleton> singletons;
  std::vector<LoadedPart> parts;

 private:
  using MaybeError = std::optional<std::string>;

  size_t offset() const { return kSaveHeaderBytes + reader_.offset(); }
  std::string cut(std::string_view what) const {
    return fmt::format("{} reach beyond the file's end at byte {}", what, offset());
  }

  MaybeError readComponents() {
    const auto count = reader_.number<uint32_t>();
    if (count > kMaxComponentTypes)
      return fmt::format("{} component types; at most {}", count, kMaxComponentTypes);
    for (uint32_t i = 0; i < count; ++i) {
      const std::string_view name = reader_.text();
      if (reader_.failed()) return cut("component types");
      if (!isPlainName(name)) return fmt::format("component type {} has no plain name", i);
      const ComponentInfo* info = findComponent(name);
      if (!info) return fmt::format("component '{}' is unknown to this program", name);
      if (info->transient) return fmt::format("component '{}' is not saved by this program", name);
      if (std::find(infos_.begin(), infos_.end(), info) != infos_.end())
        return fmt::format("component '{}' is described twice", name);
      if (auto error = checkFields(*info)) return error;
      infos_.push_back(info);
    }
    if (reader_.failed()) return cut("component types");
    return {};
  }

  MaybeError checkFields(const ComponentInfo& info) {
    const auto count = reader_.number<uint32_t>();
    if (count != info.fields.size())
      return fmt::format("component '{}' has {} fields; this program's has {}", info.name, count,
                         info.fields.size());
    for (const FieldInfo& field : info.fields) {
      const std::string_view name = reader_.text();
      const auto type = reader_.number<uint32_t>();
      const auto elements = reader_.number<uint32_t>();
      if (reader_.failed()) return cut("component types");
      if (!isPlainName(name))
        return fmt::format("component '{}' has a field without a plain name", info.name);
      if (name != field.name || type != static_cast<uint32_t>(field.type) ||
          elements != field.count)
        return fmt::format(
            "component '{}' has a field '{}' of type {}[{}] where this program's has "
            "'{}' of type {}[{}]",
            info.name, name, type, elements, field.name, static_cast<uint32_t>(field.type),
            field.count);
    }
    return {};
  }

  MaybeError readHandles() {
    const auto count = reader_.number<uint32_t>();
    const char* generations = reader_.take(count, sizeof(uint32_t));
    if (!generations) return cut("handles");
    slots.resize(count);
    for (uint32_t i = 0; i < count; ++i) {
      slots[i].generation = uint32At(generations, i);
      if (slots[i].generation == 0) return fmt::format("handle {} has generation 0", i);
    }
    const auto free_count = reader_.number<uint32_t>();
    const char* indices = reader_.take(free_count, sizeof(uint32_t));
    if (!indices) return cut("free handles");
    is_free_.resize(count);
    for (uint32_t i = 0; i < free_count; ++i) {
      const uint32_t index = uint32At(indices, i);
      if (index >= count || is_free_[index] || slots[index].generation == kPendingGeneration)
        return fmt::format("free handle {} is out of range, retired or there twice", index);
      is_free_[index] = true;
      free_indices.push_back(index);
    }
    return {};
  }

  MaybeError readTables() {
    const auto count = reader_.number<uint32_t>();
    for (uint32_t i = 0; i < count; ++i)
      if (auto error = readTable(i)) return error;
    if (reader_.failed()) return cut("tables");
    for (uint32_t i = 0; i < slots.size(); ++i)
      if (slots[i].table == EntitySlots::kNoTable && !is_free_[i] &&
          slots[i].generation != kPendingGeneration)
        return fmt::format("handle {} is neither free nor in a table", i);
    return {};
  }

  MaybeError readTable(uint32_t index) {
    ComponentMask mask;
    std::vector<const ComponentInfo*> table_infos;
    const auto component_count = reader_.number<uint32_t>();
    if (component_count > infos_.size())
      return fmt::format("table {} has {} components; the file describes {}", index,
                         component_count, infos_.size());
    for (uint32_t i = 0; i < component_count; ++i) {
      const auto component = reader_.number<uint32_t>();
      if (component >= infos_.size())
        return fmt::format("table {} has component {}; the file describes {}", index, component,
                           infos_.size());
      if (mask.contains(infos_[component]->id))
        return fmt::format("table {} has component '{}' twice", index, infos_[component]->name);
      mask.insert(infos_[component]->id);
      table_infos.push_back(infos_[component]);
    }
    for (const auto& other : tables)
      if (other->mask() == mask) return fmt::format("table {} is there twice", index);
    const auto rows = reader_.number<uint32_t>();
    const char* entity_indices = reader_.take(rows, sizeof(uint32_t));
    if (!entity_indices) return cut("tables");

    tables.push_back(std::make_unique<Table>(mask, index, clock_));
    std::vector<Entity> entities(rows);
    for (uint32_t row = 0; row < rows; ++row) {
      const uint32_t entity = uint32At(entity_indices, row);
      if (entity >= slots.size() || is_free_[entity] ||
          slots[entity].table != EntitySlots::kNoTable ||
          slots[entity].generation == kPendingGeneration)
        return fmt::format("table {}, row {}: handle {} is out of range, free, or there twice",
                           index, row, entity);
      slots[entity].table = index;
      slots[entity].row = row;
      entities[row] = {entity, slots[entity].generation};
    }
    std::vector<const char*> packed;
    for (const ComponentInfo* info : table_infos) {
      packed.push_back(reader_.take(rows, packedSize(*info)));
      if (!packed.back()) return cut(fmt::format("values of '{}'", info->name));
    }
    return WorldState::fillRows(*tables.back(), entities, table_infos, packed);
  }

  MaybeError readSingletons() {
    const auto count = reader_.number<uint32_t>();
    for (uint32_t i = 0; i < count; ++i) {
      const auto component = reader_.number<uint32_t>();
      if (reader_.failed()) return cut("singletons");
      if (component >= infos_.size())
        return fmt::format("singleton {} has component {}; the file describes {}", i, component,
                           infos_.size());
      const ComponentInfo& info = *infos_[component];
      for (const LoadedSingleton& other : singletons)
        if (other.info == &info) return fmt::format("singleton '{}' is there twice", info.name);
      const char* packed = reader_.take(packedSize(info));
      if (!packed) return cut("singletons");
      std::vector<std::byte> unpacked(info.size);
      if (const auto field = unpackValue(info, packed, unpacked.data()); !field.empty())
        return fmt::format("singleton '{}', field '{}': not a bool", info.name, field);
      singletons.push_back({&info, packed});
    }
    if (reader_.failed()) return cut("singletons");
    return {};
  }

  MaybeError readParts() {
    if (reader_.atEnd()) return {};
    const auto count = reader_.number<uint32_t>();
    for (uint32_t i = 0; i < count; ++i) {
      const std::string_view name = reader_.text();
      const auto size = reader_.number<uint64_t>();
      const char* bytes = reader_.take(size);
      if (!bytes) return cut("parts");
      if (!isPlainName(name)) return fmt::format("part {} has no plain name", i);
      if (size == 0) return fmt::format("part '{}' is empty", name);
      for (const LoadedPart& other : parts)
        if (other.name == name) return fmt::format("part '{}' is there twice", name);
      parts.push_back({name, {bytes, size}});
    }
    if (reader_.failed()) return cut("parts");
    if (count == 0 || !reader_.atEnd()) return fmt::format("unknown content at byte {}", offset());
    return {};
  }

  ByteReader reader_;
  VersionClock& clock_;
  std::vector<const ComponentInfo*> infos_;
  std::vector<bool> is_free_;
};

// The part between header and trailer, or why the file is none of ours or damaged.
Result<std::string_view> checkedBody(std::string_view content) {
  if (content.size() < kSaveHeaderBytes + kSaveTrailerBytes)
    return Error{fmt::format("{} bytes: too short for a saved world", content.size())};
  if (!content.starts_with(kSaveMagic)) return Error{"not a saved world"};
  ByteReader header(content.substr(kSaveMagic.size()));
  const auto version = header.number<uint32_t>();
  if (version != kSaveVersion)
    return Error{fmt::format("version {}; this program reads {}", version, kSaveVersion)};
  const auto bytes = header.number<uint64_t>();
  if (bytes != content.size())
    return Error{fmt::format("{} bytes of {}: truncated or damaged", content.size(), bytes)};
  const std::string_view hashed = content.substr(0, content.size() - kSaveTrailerBytes);
  uint64_t expected;
  std::memcpy(&expected, content.data() + hashed.size(), sizeof expected);
  const uint64_t actual = hashBytes(hashed.data(), hashed.size());
  if (actual != expected)
    return Error{fmt::format("checksum {:016x} instead of {:016x}: damaged", actual, expected)};
  return hashed.substr(kSaveHeaderBytes);
}

}  // namespace

std::optional<std::string> WorldState::fillRows(Table& table, std::span<const Entity> entities,
                                                std::span<const ComponentInfo* const> infos,
                                                std::span<const char* const> packed) {
  table.append(entities.size());
  if (!entities.empty()) std::memcpy(table.entities_, entities.data(), entities.size_bytes());
  for (size_t i = 0; i < infos.size(); ++i) {
    const ComponentInfo& info = *infos[i];
    if (info.size == 0) continue;
    const size_t packed_bytes = packedSize(info);
    std::byte* data = table.findColumn(info.id)->data;
    for (size_t row = 0; row < entities.size(); ++row) {
      const auto field = unpackValue(info, packed[i] + row * packed_bytes, data + row * info.size);
      if (!field.empty())
        return fmt::format("component '{}', row {}, field '{}': not a bool", info.name, row, field);
    }
  }
  return {};
}

Status World::load(const std::filesystem::path& path) {
  state_->requireAlone("load");
  const Result<std::string> content = readText(path);
  if (!content.ok()) return Error{content.error()};
  return loadBytes(content.value(), path.string());
}

Status World::loadBytes(std::string_view content, std::string_view where) {
  state_->requireAlone("load");
  const Result<std::string_view> body = checkedBody(content);
  if (!body.ok()) return Error{fmt::format("{}: {}", where, body.error())};
  Loading loading(body.value(), state_->clock);
  if (const auto error = loading.read()) return Error{fmt::format("{}: {}", where, *error)};

  WorldState& state = *state_;
  // What the owners of parts say of theirs, before anything is replaced.
  std::vector<std::function<void()>> put_in_place;
  for (const WorldState::Part& part : state.parts) {
    if (!part.claimed.load) continue;
    std::string_view bytes;
    for (const LoadedPart& loaded : loading.parts)
      if (loaded.name == part.name) bytes = loaded.bytes;
    auto put = part.claimed.load(bytes, static_cast<uint32_t>(loading.slots.size()));
    if (!put.ok()) return Error{fmt::format("{}: part '{}': {}", where, part.name, put.error())};
    put_in_place.push_back(std::move(put).value());
  }

  state.slots.restore(std::move(loading.slots), std::move(loading.free_indices));
  state.tables = std::move(loading.tables);
  state.table_of_mask.clear();
  for (const auto& table : state.tables) state.table_of_mask.emplace(table->mask(), table.get());
  state.rematchQueries();
  for (const ComponentInfo* info : components())
    if (void* value = state.singletons.find(info->id); value && info->size && !info->transient)
      std::memcpy(value, info->default_value, info->size);
  for (const LoadedSingleton& singleton : loading.singletons) {
    void* value = state.singletons.get(singleton.info->id, nullptr, true);
    unpackValue(*singleton.info, singleton.packed, static_cast<std::byte*>(value));
  }
  std::erase_if(state.parts, [](const WorldState::Part& part) { return !part.claimed.load; });
  for (const LoadedPart& loaded : loading.parts)
    if (WorldState::Part& part = state.partOf(loaded.name); !part.claimed.load)
      part.unclaimed = loaded.bytes;
  for (const auto& put : put_in_place) put();
  return Done{};
}

WorldState::Part& WorldState::partOf(std::string_view name) {
  const auto at = std::lower_bound(parts.begin(), parts.end(), name,
                                   [](const Part& a, std::string_view b) { return a.name < b; });
  if (at != parts.end() && at->name == name) return *at;
  return *parts.insert(at, Part{std::string(name), {}, {}});
}

Status World::setPart(std::string_view name, SavedPart owner) {
  state_->requireAlone("setPart");
  if (!isPlainName(name)) fail(fmt::format("World::setPart: '{}' is no plain name", name));
  WorldState::Part& part = state_->partOf(name);
  part.claimed = std::move(owner);
  const std::string bytes = std::exchange(part.unclaimed, {});
  if (bytes.empty()) return Done{};
  auto put = part.claimed.load(bytes, static_cast<uint32_t>(state_->slots.slots().size()));
  if (!put.ok()) return Error{fmt::format("part '{}': {}", name, put.error())};
  put.value()();
  return Done{};
}

}  // namespace scree
