// 64-bit hashing of bytes and of numbers: the same value on every machine and thread count.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace scree {

// Finalizer of SplitMix64 (Steele, Lea, Flood 2014): a bijection in which every input bit reaches
// every output bit.
constexpr uint64_t mix64(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

constexpr uint64_t hashCombine(uint64_t seed, uint64_t value) { return mix64(seed ^ mix64(value)); }

// Hash of `size` bytes; not for keys that an attacker chooses.
uint64_t hashBytes(const void* data, size_t size, uint64_t seed = 0);

// Hash of a name, usable at compile time (FNV-1a, then mixed).
constexpr uint64_t hashName(std::string_view name) {
  uint64_t hash = 0xcbf29ce484222325ull;
  for (char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return mix64(hash);
}

}  // namespace scree
