// Reordering a table's rows.
#include <cstring>

#include "engine/core/log.h"
#include "engine/core/parallel.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

// Rows that one task moves.
constexpr size_t kPermuteChunkRows = 16384;

// A compile-time size lets the compiler move a value through registers.
template <size_t kSize>
void gatherFixed(std::byte* to, const std::byte* from, const uint32_t* order, size_t begin,
                 size_t end) {
  for (size_t i = begin; i < end; ++i)
    std::memcpy(to + i * kSize, from + size_t{order[i]} * kSize, kSize);
}

void gather(std::byte* to, const std::byte* from, size_t size, const uint32_t* order, size_t begin,
            size_t end) {
  switch (size) {
    case 4:
      return gatherFixed<4>(to, from, order, begin, end);
    case 8:
      return gatherFixed<8>(to, from, order, begin, end);
    case 12:
      return gatherFixed<12>(to, from, order, begin, end);
    case 16:
      return gatherFixed<16>(to, from, order, begin, end);
    case 32:
      return gatherFixed<32>(to, from, order, begin, end);
    default:
      for (size_t i = begin; i < end; ++i)
        std::memcpy(to + i * size, from + size_t{order[i]} * size, size);
  }
}

}  // namespace

void WorldState::permute(Table& table, std::span<const uint32_t> order) {
  const size_t rows = table.size();
  if (order.size() != rows)
    fail(fmt::format("World::permute: an order of {} rows for a table of {}", order.size(), rows));
  permutation_seen.assign((rows + 63) / 64, 0);
  for (size_t i = 0; i < rows; ++i) {
    const uint32_t row = order[i];
    if (row >= rows || permutation_seen[row / 64] >> row % 64 & 1)
      fail(fmt::format("World::permute: order[{}] = {} is out of range or there twice", i, row));
    permutation_seen[row / 64] |= uint64_t{1} << row % 64;
  }

  const auto reorder = [&](std::byte* data, size_t size) {
    if (permuted.size() < rows * size) permuted.resize(rows * size);
    const auto run = [&](size_t, size_t begin, size_t end) {
      gather(permuted.data(), data, size, order.data(), begin, end);
    };
    parallelChunks(rows, kPermuteChunkRows, std::ref(run));
    const auto copy_back = [&](size_t, size_t begin, size_t end) {
      std::memcpy(data + begin * size, permuted.data() + begin * size, (end - begin) * size);
    };
    parallelChunks(rows, kPermuteChunkRows, std::ref(copy_back));
  };
  for (Column& column : table.columns_)
    if (column.info->size) reorder(column.data, column.info->size);
  reorder(reinterpret_cast<std::byte*>(table.entities_), sizeof(Entity));
  for (uint32_t row = 0; row < rows; ++row) slots.find(table.entities_[row])->row = row;
  table.touchRows();
}

}  // namespace scree
