// QueryCache: the tables that match one query, kept up to date as tables are created and as they
// become empty or filled.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/ecs/table.h"

namespace scree {

class Commands;
struct WorldState;
class CommandScope;

struct QuerySignature {
  ComponentMask required;
  ComponentMask excluded;
  ComponentMask data;  // whose values are read or written; a subset of `required`

  bool matches(const ComponentMask& table) const {
    return table.containsAll(required) && !table.intersects(excluded);
  }
  friend bool operator==(const QuerySignature&, const QuerySignature&) = default;
};

// The commands of one chunk of a parallel iteration; made when first asked for.
class ChunkCommands {
 public:
  explicit ChunkCommands(CommandScope& scope) : scope_(scope) {}
  Commands& get();

 private:
  CommandScope& scope_;
};

class QueryCache {
 public:
  QueryCache(WorldState& world, const QuerySignature& signature)
      : world_(world), signature_(signature) {}

  const QuerySignature& signature() const { return signature_; }
  bool empty() const { return filled_tables_ == 0; }
  size_t count() const;
  Version version() const;
  Version version(ComponentId id) const;
  std::span<Table* const> tables() const { return tables_; }

  using ChunkBody = std::function<void(Table&, size_t begin, size_t end, ChunkCommands&)>;
  // Calls body for every chunk of every filled table; chunks are numbered in the order of tables
  // and rows, which orders their commands.
  template <class Body>
  void eachChunk(size_t chunk_rows, const Body& body) {
    runChunks(chunk_rows, std::ref(body));
  }

 private:
  friend class QueryIteration;
  friend class Table;
  friend struct WorldState;
  void runChunks(size_t chunk_rows, const ChunkBody& body);
  void addTable(Table& table);

  WorldState& world_;
  QuerySignature signature_;
  std::vector<Table*> tables_;
  uint32_t filled_tables_ = 0;
  Version floor_ = 0;  // of the last load(), since the tables whose versions were read are gone
};

// While one lives, structural changes of the World are refused.
class QueryIteration {
 public:
  explicit QueryIteration(QueryCache& cache);
  ~QueryIteration();
  QueryIteration(const QueryIteration&) = delete;
  QueryIteration& operator=(const QueryIteration&) = delete;

 private:
  WorldState& world_;
};

}  // namespace scree
