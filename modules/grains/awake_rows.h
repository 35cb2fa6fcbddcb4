// Where the rows of the grains awake are.
#pragma once

#include <cstdint>
#include <span>

#include "modules/grains/grain_rows.h"

namespace scree::grains {

struct AwakeRow {
  uint32_t row;   // counted over all tables
  uint32_t slot;  // of its body
};

inline bool beforeRow(const AwakeRow& a, const AwakeRow& b) { return a.row < b.row; }

// Calls visit(table, row in it, slot) for rows in ascending order.
template <class Visit>
void eachRow(std::span<const GrainRows> tables, std::span<const AwakeRow> rows,
             const Visit& visit) {
  size_t table = 0, begin = 0;
  for (const AwakeRow& at : rows) {
    while (at.row - begin >= tables[table].entity.size()) begin += tables[table++].entity.size();
    visit(tables[table], at.row - begin, at.slot);
  }
}

}  // namespace scree::grains
