// WorldState: what a World consists of, and its structural changes. Private to engine/ecs.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/ecs/command_scope.h"
#include "engine/ecs/entity_slots.h"
#include "engine/ecs/world.h"

namespace scree {

struct WorldState {
  WorldState() : root_scope(*this) {}

  VersionClock clock;
  EntitySlots slots;
  std::vector<std::unique_ptr<Table>> tables;  // in the order of creation, which is that of queries
  std::unordered_map<ComponentMask, Table*, ComponentMaskHash> table_of_mask;
  Singletons singletons;

  std::shared_mutex queries_mutex;  // systems that run in parallel may make queries
  std::vector<std::unique_ptr<QueryCache>> queries;

  std::atomic<int> iterations{0};      // queries that iterate now
  std::atomic<int> shared_systems{0};  // systems that run now and are not exclusive
  std::atomic<int> stack_scopes{0};    // systems and chunks that run now

  struct PendingCommands {
    CommandKey key;
    std::unique_ptr<Commands> commands;
  };
  CommandScope root_scope;
  std::mutex commands_mutex;
  std::vector<PendingCommands> pending;
  std::vector<std::unique_ptr<Commands>> idle_commands;

  // Kept for their memory.
  std::vector<uint64_t> doomed_rows;
  std::vector<uint32_t> doomed_of_table;
  std::vector<Entity> spawned;
  std::vector<std::byte> permuted;
  std::vector<uint64_t> permutation_seen;

  // By name.
  struct Part {
    std::string name;
    SavedPart claimed;
    std::string unclaimed;  // bytes of a file; its owner has not come yet
  };
  std::vector<Part> parts;
  Part& partOf(std::string_view name);  // made if there is none

  // Ends the program with one line unless the caller is alone with the World.
  void requireAlone(std::string_view operation) const;

  Table& tableOf(const ComponentMask& mask);
  Table& tableOf(std::span<const ComponentValue> values);
  Table& tableWith(Table& table, ComponentId id);
  Table& tableWithout(Table& table, ComponentId id);
  QueryCache* queryCache(const QuerySignature& signature);
  // After load() has replaced the tables.
  void rematchQueries();

  Entity spawn(std::span<const ComponentValue> values);
  TableRows spawnMany(size_t count, std::span<const ComponentValue> values);
  TableRows spawnRaw(size_t count, std::span<const ComponentId> ids);
  TableRows appendRows(Table& table, size_t count);
  bool destroy(Entity entity);
  size_t destroyMany(std::span<const Entity> entities);
  void clear();
  void* find(Entity entity, ComponentId id, bool marks_changed);
  void* add(Entity entity, ComponentValue value);
  bool remove(Entity entity, ComponentId id);
  void permute(Table& table, std::span<const uint32_t> order);

  Commands& openCommands(const CommandKey& key);
  FlushResult flush();
  void apply(const Commands& commands, FlushResult& result);
  void resolvePending(Entity entity, ComponentId id);

  uint64_t hash(bool use_cache);
  std::string saved() const;
  // Gives an empty table rows of packed values (see value_codec.h), one column for each of `infos`.
  // Returns what is wrong with the first value that is none of its type.
  static std::optional<std::string> fillRows(Table& table, std::span<const Entity> entities,
                                             std::span<const ComponentInfo* const> infos,
                                             std::span<const char* const> packed);

  // Where an empty type's values are: nowhere, but not null.
  static void* emptyValue(const ComponentInfo& info) {
    return const_cast<void*>(info.default_value);
  }
  static void* valueAt(Table& table, ComponentId id, uint32_t row);
  // Moves the row to another table, where values of components that are new are undefined.
  EntitySlots::Slot& moveRow(Entity entity, Table& to);
  void closeGap(Table& table, uint32_t row);
};

}  // namespace scree
