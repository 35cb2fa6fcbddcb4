// Query caches: matching, counting, versions, parallel chunks.
#include "engine/ecs/query_cache.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/ecs/world_state.h"

namespace scree {

Commands& ChunkCommands::get() {
  return scope_.commands();
}

size_t QueryCache::count() const {
  size_t rows = 0;
  for (const Table* table : tables_) rows += table->size();
  return rows;
}

Version QueryCache::version() const {
  world_.clock.advance();
  Version latest = floor_;
  for (const Table* table : tables_) {
    latest = std::max(latest, table->rows_version_);
    signature_.required.each(
        [&](ComponentId id) { latest = std::max(latest, table->versionNow(table->column(id))); });
  }
  return latest;
}

Version QueryCache::version(ComponentId id) const {
  world_.clock.advance();
  Version latest = floor_;
  for (const Table* table : tables_)
    latest = std::max(latest, table->versionNow(table->column(id)));
  return latest;
}

void QueryCache::addTable(Table& table) {
  tables_.push_back(&table);
  table.queries_.push_back(this);
  if (!table.empty()) ++filled_tables_;
}

void QueryCache::runChunks(size_t chunk_rows, const ChunkBody& body) {
  if (empty()) return;
  const QueryIteration iteration(*this);
  const auto chunksOf = [&](const Table& table) {
    return (table.size() + chunk_rows - 1) / chunk_rows;
  };
  size_t chunks = 0;
  for (const Table* table : tables_) chunks += chunksOf(*table);
  CommandScope* const current = CommandScope::current(world_);
  CommandScope& parent = current ? *current : world_.root_scope;
  const uint32_t sequence = parent.beginCall();
  const auto run = [&](size_t chunk, size_t, size_t) {
    size_t first = 0;
    size_t at = 0;
    while (chunk >= first + chunksOf(*tables_[at])) first += chunksOf(*tables_[at++]);
    CommandScope scope(parent, sequence, static_cast<uint32_t>(chunk), parent.access());
    ChunkCommands commands(scope);
    const size_t begin = (chunk - first) * chunk_rows;
    body(*tables_[at], begin, std::min(begin + chunk_rows, tables_[at]->size()), commands);
  };
  parallelChunks(chunks, 1, std::ref(run));
}

QueryIteration::QueryIteration(QueryCache& cache) : world_(cache.world_) {
  world_.iterations.fetch_add(1, std::memory_order_relaxed);
}

QueryIteration::~QueryIteration() {
  world_.iterations.fetch_sub(1, std::memory_order_relaxed);
}

QueryCache* WorldState::queryCache(const QuerySignature& signature) {
  const auto find = [&]() -> QueryCache* {
    for (const auto& query : queries)
      if (query->signature() == signature) return query.get();
    return nullptr;
  };
  {
    const std::shared_lock lock(queries_mutex);
    if (QueryCache* found = find()) return found;
  }
  const std::unique_lock lock(queries_mutex);
  if (QueryCache* found = find()) return found;
  queries.push_back(std::make_unique<QueryCache>(*this, signature));
  for (const auto& table : tables)
    if (signature.matches(table->mask())) queries.back()->addTable(*table);
  return queries.back().get();
}

void WorldState::rematchQueries() {
  for (const auto& query : queries) {
    query->tables_.clear();
    query->filled_tables_ = 0;
    query->floor_ = clock.now();
    for (const auto& table : tables)
      if (query->signature().matches(table->mask())) query->addTable(*table);
  }
}

}  // namespace scree
