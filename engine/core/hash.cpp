// Hashes bytes eight at a time, little-endian.
#include "engine/core/hash.h"

#include <bit>
#include <cstring>

namespace scree {

static_assert(std::endian::native == std::endian::little, "hashes are defined little-endian");

uint64_t hashBytes(const void* data, size_t size, uint64_t seed) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  uint64_t hash = mix64(seed ^ size);
  size_t at = 0;
  for (; at + 8 <= size; at += 8) {
    uint64_t word;
    std::memcpy(&word, bytes + at, 8);
    hash = mix64(hash ^ word);
  }
  if (at < size) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + at, size - at);
    hash = mix64(hash ^ word);
  }
  return hash;
}

}  // namespace scree
