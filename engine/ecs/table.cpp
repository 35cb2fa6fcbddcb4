// Storage of a table's rows.
#include "engine/ecs/table.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "engine/core/log.h"
#include "engine/ecs/query_cache.h"

namespace scree {
namespace {

// Rows of a table's first allocation; it doubles from there.
constexpr size_t kFirstCapacity = 16;

// A column of several huge pages asks for them: first touching a page costs microseconds on some
// machines, and random rows miss the address cache less.
constexpr size_t kHugePageBytes = size_t{2} << 20;
constexpr size_t kHugeColumnBytes = 2 * kHugePageBytes;

size_t alignmentOf(size_t bytes, size_t value_alignment) {
  return bytes >= kHugeColumnBytes ? kHugePageBytes : std::max(kColumnAlignment, value_alignment);
}

std::byte* allocate(size_t bytes, size_t value_alignment) {
  const size_t alignment = alignmentOf(bytes, value_alignment);
  const size_t whole = (bytes + alignment - 1) / alignment * alignment;
  void* data = ::operator new (whole, std::align_val_t{alignment});
  if (alignment == kHugePageBytes) madvise(data, whole, MADV_HUGEPAGE);
  return static_cast<std::byte*>(data);
}

void release(void* data, size_t bytes, size_t value_alignment) {
  ::operator delete (data, std::align_val_t{alignmentOf(bytes, value_alignment)});
}

// Moves the first `size` values, of memory for `old_capacity`, to memory for `capacity` of them.
std::byte* regrow(std::byte* data, size_t size, size_t old_capacity, size_t capacity,
                  size_t value_size, size_t value_alignment) {
  std::byte* grown = allocate(capacity * value_size, value_alignment);
  if (size) std::memcpy(grown, data, size * value_size);
  release(data, old_capacity * value_size, value_alignment);
  return grown;
}

}  // namespace

Table::Table(const ComponentMask& mask, uint32_t index, VersionClock& clock)
    : mask_(mask), index_(index), clock_(&clock) {
  column_of_.fill(-1);
  mask.each([&](ComponentId id) {
    column_of_[id] = static_cast<int16_t>(columns_.size());
    ids_.push_back(id);
    columns_.push_back({.info = &componentInfo(id)});
  });
}

Table::~Table() {
  for (Column& column : columns_)
    release(column.data, size_t{capacity_} * column.info->size, column.info->alignment);
  release(entities_, capacity_ * sizeof(Entity), alignof(Entity));
}

const Column& Table::column(ComponentId id) const {
  if (column_of_[id] < 0)
    fail(fmt::format("a table without '{}' is asked for that column", componentInfo(id).name));
  return columns_[static_cast<size_t>(column_of_[id])];
}

std::byte* Table::touch(ComponentId id) {
  Column& column = const_cast<Column&>(this->column(id));
  // Threads that touch one column through World::find must not write to one cache line each time.
  std::atomic_ref<Version> version(column.version);
  const Version now = clock_->now();
  if (version.load(std::memory_order_relaxed) != now) version.store(now, std::memory_order_relaxed);
  return column.data;
}

Version Table::versionNow(const Column& column) const {
  std::atomic_ref<Version> version(const_cast<Version&>(column.version));
  return std::max(version.load(std::memory_order_relaxed), rows_version_);
}

Version Table::version(ComponentId id) const {
  clock_->advance();
  return versionNow(column(id));
}

Version Table::rowsVersion() const {
  clock_->advance();
  return rows_version_;
}

void Table::reserve(size_t rows) {
  if (rows <= capacity_) return;
  if (rows > 0xffffffffu) fail(fmt::format("a table of {} rows; at most 2^32 - 1", rows));
  const size_t capacity =
      std::min<size_t>(std::max({rows, size_t{capacity_} * 2, kFirstCapacity}), 0xffffffffu);
  for (Column& column : columns_) {
    const ComponentInfo& info = *column.info;
    if (info.size) column.data = regrow(column.data, size_, capacity_, capacity, info.size, info.alignment);
  }
  entities_ =
      reinterpret_cast<Entity*>(regrow(reinterpret_cast<std::byte*>(entities_), size_, capacity_,
                                       capacity, sizeof(Entity), alignof(Entity)));
  capacity_ = static_cast<uint32_t>(capacity);
}

uint32_t Table::append(size_t count) {
  reserve(size_ + count);
  const uint32_t first = size_;
  size_ += static_cast<uint32_t>(count);
  resized(first == 0);
  return first;
}

Entity Table::removeRow(uint32_t row) {
  const uint32_t last = --size_;
  Entity moved = Entity::kNone;
  if (row != last) {
    for (Column& column : columns_) {
      const size_t size = column.info->size;
      if (size) std::memcpy(column.data + row * size, column.data + last * size, size);
    }
    moved = entities_[row] = entities_[last];
  }
  resized(false);
  return moved;
}

void Table::removeAll() {
  if (size_ == 0) return;
  size_ = 0;
  resized(false);
}

void Table::resized(bool was_empty) {
  touchRows();
  if (was_empty == (size_ == 0)) return;
  if (was_empty)
    for (QueryCache* query : queries_) ++query->filled_tables_;
  else if (size_ == 0)
    for (QueryCache* query : queries_) --query->filled_tables_;
}

void Table::copyRow(uint32_t row, const Table& from, uint32_t from_row) {
  for (Column& column : columns_) {
    const size_t size = column.info->size;
    const int16_t source = from.column_of_[column.info->id];
    if (source < 0 || size == 0) continue;
    std::memcpy(column.data + row * size,
                from.columns_[static_cast<size_t>(source)].data + from_row * size, size);
  }
}

void Table::fill(Column& column, size_t begin, size_t count, const void* value) {
  const size_t size = column.info->size;
  if (size == 0 || count == 0) return;
  std::byte* first = column.data + begin * size;
  std::memcpy(first, value, size);
  // Copies what is filled already, at most a first-level cache full of it.
  constexpr size_t kBlockBytes = 8192;
  const size_t total = count * size;
  for (size_t filled = size; filled < total;) {
    const size_t block =
        std::min({filled, total - filled, std::max(kBlockBytes / size, size_t{1}) * size});
    std::memcpy(first + filled, first, block);
    filled += block;
  }
}

Table::Edge& Table::edge(ComponentId id) {
  for (Edge& edge : edges_)
    if (edge.id == id) return edge;
  return edges_.emplace_back(Edge{id, nullptr, nullptr});
}

}  // namespace scree
