// Table: all entities with one set of component types, one contiguous column a component.
#pragma once

#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/ecs/access.h"
#include "engine/ecs/component_mask.h"

namespace scree {

class QueryCache;
class World;

// Columns begin at multiples of this, bytes, and their memory is a multiple of it, so that a SIMD
// load that begins inside a column stays inside its memory.
inline constexpr size_t kColumnAlignment = 64;

// Counts changes in a World. A larger version is a later change; 0 is before all changes. Versions
// depend on who reads them: compare them, but never let them into the simulation.
using Version = uint64_t;

// Gives changes their versions. It advances when a version is read, not when one is written, so
// that marking a column as changed is cheap and threads do not contend for it.
class VersionClock {
 public:
  Version now() const { return time_.load(std::memory_order_relaxed); }
  // Call before reading versions: later changes get larger ones.
  void advance() { time_.fetch_add(1, std::memory_order_relaxed); }

 private:
  std::atomic<Version> time_{1};
};

// A hash and the version of what was hashed.
struct CachedHash {
  uint64_t hash = 0;
  Version version = 0;
};

struct Column {
  const ComponentInfo* info = nullptr;
  std::byte* data = nullptr;  // null for empty types and before the first row
  Version version = 0;        // of the values; of the rows, see Table
  CachedHash cached_hash;
};

class Table {
 public:
  Table(const ComponentMask& mask, uint32_t index, VersionClock& clock);
  ~Table();
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const ComponentMask& mask() const { return mask_; }
  std::span<const ComponentId> componentIds() const { return ids_; }
  bool has(ComponentId id) const { return mask_.contains(id); }
  std::span<const Entity> entities() const { return {entities_, size_}; }

  // Columns by type; ends the program if the table has none. The spans are valid until the next
  // structural change. `write` marks the column as changed now: take it again for each change.
  template <class T>
  std::span<const T> read() const {
    static_assert(!std::is_empty_v<T>, "a tag has no values");
    checkRead(componentId<T>());
    return {reinterpret_cast<const T*>(column(componentId<T>()).data), size_};
  }
  template <class T>
  std::span<T> write() {
    static_assert(!std::is_empty_v<T>, "a tag has no values");
    checkWrite(componentId<T>());
    return {reinterpret_cast<T*>(touch(componentId<T>())), size_};
  }

  // When values of the column, or the set or order of rows, last changed.
  Version version(ComponentId id) const;
  template <class T>
  Version version() const {
    return version(componentId<T>());
  }
  // When the set or order of rows last changed.
  Version rowsVersion() const;

 private:
  friend class QueryCache;
  friend struct WorldState;
  template <class... Terms>
  friend class Query;

  const Column& column(ComponentId id) const;
  Column* findColumn(ComponentId id) {
    return column_of_[id] < 0 ? nullptr : &columns_[static_cast<size_t>(column_of_[id])];
  }
  // The column's memory, marked as changed.
  std::byte* touch(ComponentId id);
  void touchRows() { rows_version_ = clock_->now(); }
  // max(values, rows), without advancing the clock.
  Version versionNow(const Column& column) const;

  // Makes room for `rows` rows; what a new row holds is left undefined.
  void reserve(size_t rows);
  // Returns the first of `count` new rows.
  uint32_t append(size_t count);
  // The last row takes the place of `row`; returns its entity (Entity::kNone if `row` was the
  // last).
  Entity removeRow(uint32_t row);
  void removeAll();
  void copyRow(uint32_t row, const Table& from, uint32_t from_row);
  void fill(Column& column, size_t begin, size_t count, const void* value);
  void resized(bool was_empty);

  // The tables of entities that gain or lose one component; null: not looked up yet.
  struct Edge {
    ComponentId id;
    Table* with;
    Table* without;
  };
  Edge& edge(ComponentId id);

  ComponentMask mask_;
  std::vector<ComponentId> ids_;
  std::vector<Column> columns_;                        // parallel to ids_
  std::array<int16_t, kMaxComponentTypes> column_of_;  // -1: none
  Entity* entities_ = nullptr;
  uint32_t index_;  // in the World's list
  uint32_t size_ = 0;
  uint32_t capacity_ = 0;
  Version rows_version_ = 0;
  CachedHash entities_hash_;
  VersionClock* clock_;
  std::vector<QueryCache*> queries_;  // that match
  std::vector<Edge> edges_;
};

}  // namespace scree
