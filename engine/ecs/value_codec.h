// Values without their padding: hashing and packing of components. Private to engine/ecs.
#pragma once

#include <cstring>
#include <string>

#include "engine/core/hash.h"
#include "engine/ecs/component.h"

namespace scree {

// Length of the text in a char[capacity] field.
inline size_t textLength(const char* text, size_t capacity) {
  return strnlen(text, capacity);
}

// Hash of the values of all fields; bytes of padding, and behind the end of texts, do not count.
// Floating-point values count by their bits: -0 is not 0.
uint64_t hashValue(const ComponentInfo& info, const std::byte* value, uint64_t seed);

// Sum over `count` values of hashValue with each entity's seed, modulo 2^64: independent of order.
uint64_t hashValues(const ComponentInfo& info, const std::byte* values, const Entity* entities,
                    size_t count);

// Bytes of one packed value.
size_t packedSize(const ComponentInfo& info);
// Appends the values' runs, then their texts, with zeros behind the end of each text.
void packValue(const ComponentInfo& info, const std::byte* value, std::string& out);
// Reads packedSize bytes. Returns the name of the field whose bytes are no value of its type
// (a bool that is neither 0 nor 1), or an empty name.
std::string_view unpackValue(const ComponentInfo& info, const char* packed, std::byte* value);

}  // namespace scree
