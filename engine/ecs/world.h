// World: entities, their components in tables, and singletons.
//
//   World world;
//   Entity e = world.spawn(Position{...}, Velocity{...});
//   world.query<Position, const Velocity>().each([](Position& p, const Velocity& v) { ... });
//
// Structural changes (spawn, destroy, add, remove, permute, clear, load, flush) end the program
// with one line while a query iterates, and in systems that are not exclusive: record them with
// commands(). Pointers and spans into columns are valid until the next structural change.
// Handles of dead entities are refused: nullptr or false, and nothing happens.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "engine/core/result.h"
#include "engine/ecs/commands.h"
#include "engine/ecs/query.h"
#include "engine/ecs/singletons.h"
#include "engine/ecs/table.h"

namespace scree {

// Consecutive rows of one table; valid until the next structural change.
struct TableRows {
  Table* table = nullptr;
  size_t begin = 0;
  size_t count = 0;

  size_t size() const { return count; }
  std::span<const Entity> entities() const { return table->entities().subspan(begin, count); }
  // Marks the column as changed.
  template <class T>
  std::span<T> column() const {
    return table->write<T>().subspan(begin, count);
  }
};

struct FlushResult {
  size_t applied = 0;
  size_t refused = 0;  // named an entity that was dead by then
};

// State of a module that is not in tables or singletons, saved and loaded with a World. It is not
// hashed: what it holds must show in the components sooner or later.
struct SavedPart {
  // Its bytes; empty: there is nothing to save.
  std::function<std::string()> save;
  // Checks bytes that save() may have made and returns what puts them in place, which must not
  // fail. Empty bytes: the file has none. Until that is called nothing may change. The handles of
  // the file's entities have indices below `handles`.
  std::function<Result<std::function<void()>>(std::string_view bytes, uint32_t handles)> load;
};

class World {
 public:
  World();
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // ---- entities
  template <Component... T>
  Entity spawn(const T&... values) {
    const std::array<ComponentValue, sizeof...(T)> list{
        ComponentValue{componentId<T>(), &values}...};
    return spawn(std::span<const ComponentValue>(list));
  }
  // `count` entities with default values, in consecutive rows.
  template <Component... T>
  TableRows spawnMany(size_t count) {
    const std::array<ComponentValue, sizeof...(T)> list{
        ComponentValue{componentId<T>(), nullptr}...};
    return spawnMany(count, std::span<const ComponentValue>(list));
  }
  // `count` entities with copies of the values given.
  template <Component... T>
  requires(sizeof...(T) > 0) TableRows spawnMany(size_t count, const T&... values) {
    const std::array<ComponentValue, sizeof...(T)> list{
        ComponentValue{componentId<T>(), &values}...};
    return spawnMany(count, std::span<const ComponentValue>(list));
  }
  // `count` entities whose values init(index, values...) sets, starting from the defaults; index
  // counts from 0 to count - 1. One pass over the memory: the fastest way to fill a world.
  template <Component... T, class Init>
  requires(sizeof...(T) > 0 && std::is_invocable_v<Init&, size_t, T&...>) TableRows
      spawnMany(size_t count, Init&& init) {
    static_assert(!(std::is_empty_v<T> || ...), "a tag has no values to set");
    const std::array<ComponentId, sizeof...(T)> ids{componentId<T>()...};
    const TableRows rows = spawnRaw(count, ids);
    const std::tuple<std::span<T>...> columns{rows.column<T>()...};
    for (size_t i = 0; i < count; ++i)
      std::apply(
          [&](auto&... column) {
            ((column[i] = T{}), ...);
            init(i, column[i]...);
          },
          columns);
    return rows;
  }
  // False if it was dead.
  bool destroy(Entity entity);
  // As if destroyed one by one, faster; returns how many were alive.
  size_t destroyMany(std::span<const Entity> entities);
  // Destroys all entities; singletons stay.
  void clear();
  bool alive(Entity entity) const;
  size_t entityCount() const;

  // ---- components of one entity
  // nullptr if the entity is dead or lacks the component. `find` marks the column as changed.
  // Non-null but without memory of its own for an empty type.
  template <Component T>
  T* find(Entity entity) {
    return static_cast<T*>(find(entity, componentId<T>()));
  }
  template <Component T>
  const T* peek(Entity entity) const {
    return static_cast<const T*>(peek(entity, componentId<T>()));
  }
  template <Component T>
  bool has(Entity entity) const {
    return has(entity, componentId<T>());
  }
  // Adds the component, or overwrites its value; nullptr if the entity is dead.
  template <Component T>
  T* add(Entity entity, const T& value = T{}) {
    return static_cast<T*>(add(entity, ComponentValue{componentId<T>(), &value}));
  }
  // False if the entity is dead or lacks the component.
  template <Component T>
  bool remove(Entity entity) {
    return remove(entity, componentId<T>());
  }

  // ---- the same by run-time type; a null value means the default
  Entity spawn(std::span<const ComponentValue> values);
  TableRows spawnMany(size_t count, std::span<const ComponentValue> values);
  void* find(Entity entity, ComponentId id);
  const void* peek(Entity entity, ComponentId id) const;
  bool has(Entity entity, ComponentId id) const;
  void* add(Entity entity, ComponentValue value);
  bool remove(Entity entity, ComponentId id);
  // Ascending; empty if the entity is dead.
  std::span<const ComponentId> componentIds(Entity entity) const;

  // ---- queries: `A` writes, `const A` reads, With<A>, Without<A>
  template <class... Terms>
  Query<Terms...> query() {
    return Query<Terms...>(queryCache(detail::querySignature<Terms...>()));
  }
  std::span<const std::unique_ptr<Table>> tables() const;
  // Reorders a table: row i becomes what was row order[i]. Entities keep their handles. Ends the
  // program if `order` is no permutation of the table's rows.
  void permute(Table& table, std::span<const uint32_t> order);

  // ---- deferred changes
  // The buffer of the system, or of the chunk of eachParallel, that runs on this thread.
  Commands& commands();
  // Applies all recorded commands: in the order of systems, of calls, and of chunks. Schedule does
  // it at the end of each phase.
  FlushResult flush();

  // ---- singletons: one value a type, made by its default constructor when first asked for;
  // any type. One with a SCREE_COMPONENT line is hashed and saved. `singleton<const T>()` reads.
  template <class T>
  T& singleton() {
    using Type = std::remove_const_t<T>;
    constexpr MakeSingleton make = Component<Type> ? nullptr : singletonMaker<Type>();
    return *static_cast<T*>(singletons().get(singletonTypeId<Type>(), make, !std::is_const_v<T>));
  }
  // Replaces the value; the way for types without a default constructor.
  template <class T>
  T& setSingleton(T value) {
    if constexpr (Component<T>)
      return singleton<T>() = value;
    else
      return *static_cast<T*>(singletons().set(singletonTypeId<T>(),
                                               std::make_unique<SingletonOf<T>>(std::move(value))));
  }
  // Does not make it.
  template <class T>
  bool hasSingleton() const {
    return singletons().has(singletonTypeId<T>());
  }

  // ---- state
  // Hash of all entities and of the values of all components that are not transient. Independent
  // of the order of rows and tables, of history, of padding bytes and of the thread count. Columns
  // that did not change since the last call are not hashed again.
  uint64_t stateHash();
  // The same without any cached part: for tests, and to find a write that marked no column.
  uint64_t stateHashFromScratch() const;
  // Everything that stateHash covers, the order of tables and rows, the free handles, and the
  // parts, so that the simulation goes on exactly as it would have.
  Status save(const std::filesystem::path& path) const;
  // Replaces all entities and all singletons that are saved; on an error nothing has changed.
  Status load(const std::filesystem::path& path);
  // The same without a file; `where` begins the line of an error.
  std::string saveBytes() const;
  Status loadBytes(std::string_view content, std::string_view where);
  // Gives a part its owner. A file's part that has none is kept as it is: saved again, and loaded
  // here as soon as its owner comes, whose error is returned. A name is printable, without spaces.
  Status setPart(std::string_view name, SavedPart owner);

 private:
  friend class Schedule;
  // As spawnMany, but with values of unspecified bytes.
  TableRows spawnRaw(size_t count, std::span<const ComponentId> ids);
  QueryCache* queryCache(const QuerySignature& signature);
  Singletons& singletons() const;

  std::unique_ptr<WorldState> state_;
};

}  // namespace scree
