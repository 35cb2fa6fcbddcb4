// The distinct materials of many grains: most worlds have a handful, so that a grain keeps a number.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/hash.h"
#include "modules/grains/grains.h"
#include "modules/grains/room.h"

namespace scree::grains {

class Materials {
 public:
  // Of a material, to the bit.
  uint32_t numberOf(const GrainMaterial& material) {
    if (last_ < material_.size() && same(material_[last_], material)) return last_;
    if (2 * (material_.size() + 1) > table_.size()) grow();
    uint32_t& entry = entryOf(material);
    if (entry == kNone) {
      entry = static_cast<uint32_t>(material_.size());
      append(material_, material);
    }
    return last_ = entry;
  }
  const GrainMaterial& operator[](uint32_t number) const { return material_[number]; }
  static bool same(const GrainMaterial& a, const GrainMaterial& b) {
    return std::memcmp(&a, &b, sizeof(GrainMaterial)) == 0;
  }

  // Whether most can only be of grains that are no more, or that are of another by now.
  bool stale(size_t grains) const { return material_.size() > 2 * grains + kFew; }
  // Forgets those that are not named; eachNumber(visit) calls visit(number&) for every number kept.
  template <class EachNumber>
  void renew(const EachNumber& eachNumber) {
    const std::vector<GrainMaterial> before = std::exchange(material_, {});
    table_.clear();
    eachNumber([&](uint32_t& number) { number = numberOf(before[number]); });
  }

  size_t memoryBytes() const {
    return material_.capacity() * sizeof(GrainMaterial) + table_.capacity() * sizeof(uint32_t);
  }

 private:
  static constexpr uint32_t kNone = 0xffffffffu;
  static constexpr size_t kFew = 64;

  // Where its number is, or is to be.
  uint32_t& entryOf(const GrainMaterial& material) {
    const size_t mask = table_.size() - 1;
    size_t at = hashBytes(&material, sizeof(GrainMaterial)) & mask;
    while (table_[at] != kNone && !same(material_[table_[at]], material)) at = (at + 1) & mask;
    return table_[at];
  }
  void grow() {
    table_.assign(std::max<size_t>(16, 2 * table_.size()), kNone);
    for (uint32_t k = 0; k < material_.size(); ++k) entryOf(material_[k]) = k;
  }

  std::vector<GrainMaterial> material_;
  std::vector<uint32_t> table_;  // hashed; a power of two of entries, at most half of them in use
  uint32_t last_ = 0;            // asked for
};

}  // namespace scree::grains
