// Field types that a component may have, and their description at run time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "engine/core/math.h"
#include "engine/ecs/entity.h"

namespace scree {

enum class FieldType : uint8_t {
  Bool,
  Int32,
  Uint32,
  Int64,
  Uint64,
  Float,
  Double,
  Vec2,
  Vec3,
  Vec4,
  DVec3,
  Quat,    // in memory x, y, z, w
  Entity,  // index, generation: uint32 each
  Enum,    // 32 bits
  Text,    // char[count], ends with the first NUL or after `count` characters
};
std::string_view fieldTypeName(FieldType type);
// Bytes of one element; 1 for Text.
size_t fieldTypeSize(FieldType type);

struct FieldInfo {
  std::string_view name;
  FieldType type;
  uint32_t offset;        // bytes from the component's begin
  uint32_t count;         // elements: N of std::array<T, N> and of char[N], else 1
  std::string_view unit;  // "m", "kg", "rad" ...; empty: none

  size_t size() const { return fieldTypeSize(type) * count; }
};

namespace detail {

template <class T>
struct FieldTypeOf {
  static_assert(std::is_enum_v<T>,
                "a component's fields are bool, (u)int32, (u)int64, float, double, vec2/3/4, "
                "dvec3, quat, Entity, enums of 32 bits, char[N], or std::array of these");
  static_assert(sizeof(T) == 4, "an enum in a component has a 32-bit base");
  static constexpr FieldType kType = FieldType::Enum;
  static constexpr uint32_t kCount = 1;
  static constexpr size_t kInitializers = 1;
};

template <FieldType type>
struct PlainField {
  static constexpr FieldType kType = type;
  static constexpr uint32_t kCount = 1;
  static constexpr size_t kInitializers = 1;
};
template <>
struct FieldTypeOf<bool> : PlainField<FieldType::Bool> {};
template <>
struct FieldTypeOf<int32_t> : PlainField<FieldType::Int32> {};
template <>
struct FieldTypeOf<uint32_t> : PlainField<FieldType::Uint32> {};
template <>
struct FieldTypeOf<int64_t> : PlainField<FieldType::Int64> {};
template <>
struct FieldTypeOf<uint64_t> : PlainField<FieldType::Uint64> {};
template <>
struct FieldTypeOf<float> : PlainField<FieldType::Float> {};
template <>
struct FieldTypeOf<double> : PlainField<FieldType::Double> {};
template <>
struct FieldTypeOf<vec2> : PlainField<FieldType::Vec2> {};
template <>
struct FieldTypeOf<vec3> : PlainField<FieldType::Vec3> {};
template <>
struct FieldTypeOf<vec4> : PlainField<FieldType::Vec4> {};
template <>
struct FieldTypeOf<dvec3> : PlainField<FieldType::DVec3> {};
template <>
struct FieldTypeOf<quat> : PlainField<FieldType::Quat> {};
template <>
struct FieldTypeOf<Entity> : PlainField<FieldType::Entity> {};

template <class T, size_t n>
struct FieldTypeOf<std::array<T, n>> {
  static_assert(n > 0);
  static_assert(FieldTypeOf<T>::kCount == 1 && FieldTypeOf<T>::kType != FieldType::Text,
                "arrays of arrays or of text are not supported in components");
  static constexpr FieldType kType = FieldTypeOf<T>::kType;
  static constexpr uint32_t kCount = n;
  static constexpr size_t kInitializers = 1;
};
template <size_t n>
struct FieldTypeOf<char[n]> {
  static constexpr FieldType kType = FieldType::Text;
  static constexpr uint32_t kCount = n;
  static constexpr size_t kInitializers = n;  // brace elision: one a character
};

}  // namespace detail
}  // namespace scree
