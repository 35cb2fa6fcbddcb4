// The format of saved worlds, little-endian:
//
//   header      char[8] "SCREEWLD", uint32 version, uint64 bytes of the whole file
//   components  uint32 count; each: text name, uint32 fields; each: text name, uint32 FieldType,
//               uint32 count
//   handles     uint32 count, uint32 generation each; uint32 count of free indices, uint32 each
//   tables      uint32 count; each: uint32 components, uint32 index in `components` each;
//               uint32 rows, uint32 index of the entity each; for each component the packed values
//   singletons  uint32 count; each: uint32 index in `components`, packed value
//   parts       only if there are any: uint32 count; each: text name, uint64 size, bytes (see SavedPart)
//   trailer     uint64 hashBytes of all before
//
// A text is a uint32 length and its characters. Transient components are left out; tables that
// then have the same components become one. Private to engine/ecs.
#pragma once

#include <cstdint>
#include <string_view>

namespace scree {

inline constexpr std::string_view kSaveMagic = "SCREEWLD";
inline constexpr uint32_t kSaveVersion = 1;
inline constexpr size_t kSaveHeaderBytes = 20;
inline constexpr size_t kSaveTrailerBytes = 8;

}  // namespace scree
