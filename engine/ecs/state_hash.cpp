// The state hash: a sum over entities and components, so that no order matters.
#include "engine/core/parallel.h"
#include "engine/ecs/value_codec.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

// Rows that one task hashes. The sum does not depend on it.
constexpr size_t kHashChunkRows = 16384;
constexpr uint64_t kEntitySeed = hashName("entity");
constexpr uint64_t kSingletonSeed = hashName("singleton");

template <class HashRange>
uint64_t sumChunks(size_t rows, const HashRange& hash_range) {
  std::atomic<uint64_t> sum{0};
  const auto run = [&](size_t, size_t begin, size_t end) {
    sum.fetch_add(hash_range(begin, end), std::memory_order_relaxed);
  };
  parallelChunks(rows, kHashChunkRows, std::ref(run));
  return sum.load(std::memory_order_relaxed);
}

template <class Compute>
uint64_t cached(CachedHash& cache, Version version, bool use_cache, const Compute& compute) {
  if (!use_cache) return compute();
  if (cache.version != version) cache = {compute(), version};
  return cache.hash;
}

}  // namespace

uint64_t WorldState::hash(bool use_cache) {
  clock.advance();
  uint64_t sum = 0;
  for (const auto& table : tables) {
    if (table->empty()) continue;
    const size_t rows = table->size();
    const Entity* entities = table->entities_;
    sum += cached(table->entities_hash_, table->rows_version_, use_cache, [&] {
      return sumChunks(rows, [&](size_t begin, size_t end) {
        uint64_t part = 0;
        for (size_t i = begin; i < end; ++i) part += mix64(entities[i].bits() ^ kEntitySeed);
        return part;
      });
    });
    for (Column& column : table->columns_) {
      const ComponentInfo& info = *column.info;
      if (info.transient) continue;
      sum += cached(column.cached_hash, table->versionNow(column), use_cache, [&] {
        return sumChunks(rows, [&](size_t begin, size_t end) {
          return hashValues(info, column.data + begin * info.size, entities + begin, end - begin);
        });
      });
    }
  }
  for (uint32_t type = 0; type < kMaxComponentTypes; ++type) {
    const auto* value = static_cast<const std::byte*>(singletons.find(type));
    if (!value) continue;
    const ComponentInfo& info = componentInfo(type);
    if (info.transient) continue;
    // Zero for the default value: that somebody looked at a singleton is not state.
    sum += hashValue(info, value, kSingletonSeed) -
           hashValue(info, static_cast<const std::byte*>(info.default_value), kSingletonSeed);
  }
  return mix64(sum);
}

}  // namespace scree
