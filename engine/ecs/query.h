// Query: all rows that have some components and lack others, in the order of tables and rows.
//
//   Query<Position, const Velocity, Without<Asleep>> moving = world.query<...same...>();
//   moving.each([](Position& p, const Velocity& v) { p.x += v.x; });
//
// Keep the Query: making one looks its cache up. A Query is two pointers and lives as long as the
// World. Iterating over a non-const component marks its columns as changed. While it iterates,
// structural changes are refused; record them with World::commands().
#pragma once

#include <functional>
#include <span>
#include <tuple>
#include <type_traits>

#include "engine/ecs/query_cache.h"
#include "engine/ecs/table.h"

namespace scree {

class Commands;

// Query terms that ask for a component, or for its absence, without touching its values.
template <class T>
struct With {};
template <class T>
struct Without {};

// Rows that one call of eachParallel's body covers at most; a part of the semantics, since commands
// are applied chunk by chunk.
inline constexpr size_t kParallelChunkRows = 1024;

namespace detail {

template <class Term>
struct TermOf {
  using Type = std::remove_const_t<Term>;
  static_assert(!std::is_reference_v<Term> && !std::is_pointer_v<Term>);
  static_assert(!std::is_empty_v<Type>, "a tag has no values: ask for With<Tag>");
  static constexpr bool kData = true;
  static constexpr bool kWrites = !std::is_const_v<Term>;
  using Data = std::tuple<Term*>;
  static void addTo(QuerySignature& signature) {
    signature.required.insert(componentId<Type>());
    signature.data.insert(componentId<Type>());
  }
};
template <class T>
struct TermOf<With<T>> {
  static constexpr bool kData = false;
  using Data = std::tuple<>;
  static void addTo(QuerySignature& signature) { signature.required.insert(componentId<T>()); }
};
template <class T>
struct TermOf<Without<T>> {
  static constexpr bool kData = false;
  using Data = std::tuple<>;
  static void addTo(QuerySignature& signature) { signature.excluded.insert(componentId<T>()); }
};

template <class... Terms>
QuerySignature querySignature() {
  QuerySignature signature;
  (TermOf<Terms>::addTo(signature), ...);
  return signature;
}

}  // namespace detail

template <class... Terms>
class Query {
 public:
  Query() = default;

  // In constant time.
  bool empty() const { return cache_->empty(); }
  // Rows; in the number of matching tables.
  size_t count() const { return cache_->count(); }
  // The latest change of the terms' columns or of the set or order of rows; grows at each change.
  Version version() const { return cache_->version(); }
  // Only of the column of T.
  template <class T>
  Version version() const {
    return cache_->version(componentId<T>());
  }
  // Matching tables, the empty ones included.
  std::span<Table* const> tables() const { return cache_->tables(); }

  // body(Entity, terms&...) or body(terms&...) for each row.
  template <class Body>
  void each(Body&& body) const {
    const QueryIteration iteration(*cache_);
    for (Table* table : cache_->tables()) {
      if (table->empty()) continue;
      const auto data = columns(*table);
      eachRow(body, *table, data, 0, table->size());
    }
  }

  // body(span<const Entity>, span<term>...) for each table that is not empty. Columns begin at
  // multiples of kColumnAlignment.
  template <class Body>
  void spans(Body&& body) const {
    const QueryIteration iteration(*cache_);
    for (Table* table : cache_->tables()) {
      if (table->empty()) continue;
      const size_t size = table->size();
      std::apply([&](auto*... data) { body(table->entities(), std::span(data, size)...); },
                 columns(*table));
    }
  }

  // As `each`, in chunks of at most `chunk_rows` rows of one table, on any thread and in any order.
  // The body may take a trailing Commands&, whose commands are applied in the order of the chunks.
  // The body must touch nothing but its own row, or what nobody writes.
  template <class Body>
  void eachParallel(Body&& body, size_t chunk_rows = kParallelChunkRows) const {
    touchColumns();
    const auto run = [&](Table& table, size_t begin, size_t end, ChunkCommands& commands) {
      eachRow(body, table, rawColumns(table), begin, end, commands);
    };
    cache_->eachChunk(chunk_rows, run);
  }

  // As `spans`, once a chunk, on any thread: body(span<const Entity>, span<term>...[, Commands&]).
  template <class Body>
  void spansParallel(Body&& body, size_t chunk_rows = kParallelChunkRows) const {
    touchColumns();
    const auto run = [&](Table& table, size_t begin, size_t end, ChunkCommands& commands) {
      std::apply(
          [&](auto*... data) {
            const auto entities = table.entities().subspan(begin, end - begin);
            if constexpr (std::is_invocable_v<Body&, std::span<const Entity>,
                                              std::span<std::remove_pointer_t<decltype(data)>>...,
                                              Commands&>)
              body(entities, std::span(data + begin, end - begin)..., commands.get());
            else
              body(entities, std::span(data + begin, end - begin)...);
          },
          rawColumns(table));
    };
    cache_->eachChunk(chunk_rows, run);
  }

 private:
  friend class World;
  explicit Query(QueryCache* cache) : cache_(cache) {}

  template <class Term>
  static typename detail::TermOf<Term>::Data columnOf(Table& table, bool touch) {
    if constexpr (detail::TermOf<Term>::kData) {
      using Type = std::remove_const_t<Term>;
      const ComponentId id = componentId<Type>();
      if constexpr (detail::TermOf<Term>::kWrites) {
        if (touch) {
          checkWrite(id);
          return {reinterpret_cast<Term*>(table.touch(id))};
        }
      } else if (touch) {
        checkRead(id);
      }
      return {reinterpret_cast<Term*>(table.column(id).data)};
    } else {
      return {};
    }
  }
  static auto columns(Table& table) { return std::tuple_cat(columnOf<Terms>(table, true)...); }
  static auto rawColumns(Table& table) { return std::tuple_cat(columnOf<Terms>(table, false)...); }
  void touchColumns() const {
    for (Table* table : cache_->tables())
      if (!table->empty()) columns(*table);
  }

  template <class Body, class Data, class... Trailing>
  static void eachRow(Body& body, const Table& table, const Data& columns, size_t begin, size_t end,
                      Trailing&... trailing) {
    std::apply(
        [&](auto*... data) {
          const Entity* entities = table.entities().data();
          if constexpr (std::is_invocable_v<Body&, decltype(*data)...>) {
            for (size_t row = begin; row < end; ++row) body(data[row]...);
          } else if constexpr (std::is_invocable_v<Body&, Entity, decltype(*data)...>) {
            for (size_t row = begin; row < end; ++row) body(entities[row], data[row]...);
          } else if constexpr (std::is_invocable_v<Body&, decltype(*data)..., Commands&>) {
            for (size_t row = begin; row < end; ++row) body(data[row]..., trailing.get()...);
          } else {
            for (size_t row = begin; row < end; ++row)
              body(entities[row], data[row]..., trailing.get()...);
          }
        },
        columns);
  }

  QueryCache* cache_ = nullptr;
};

}  // namespace scree
