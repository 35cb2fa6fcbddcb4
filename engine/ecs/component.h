// Component types: SCREE_COMPONENT describes one in a line; the description serves glTF extras, the
// state hash, saving and the inspector.
//
//   struct Grain { float radius_m = 0.05f; float mass_kg = 1; };
//   SCREE_COMPONENT(Grain, (radius_m, "m"), (mass_kg, "kg"))
//
// A function `std::string fault(const Grain&)`, declared before that line, says what is wrong with a
// value that comes from a file, with field, value and what is allowed; empty: nothing. A function
// `std::string faultIn(World&, Entity, const Grain&)`, declared there too, says what is wrong with a value where
// it stands, beside its entity's other components and among others; asked when all of the file is in the world.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/ecs/component_macros.h"
#include "engine/ecs/field.h"

namespace scree {

class World;

// Dense, in the order of registration, which differs between programs: never save or hash it.
using ComponentId = uint32_t;

// Component types in one program; registering more ends the program with one line.
inline constexpr uint32_t kMaxComponentTypes = 256;

struct ByteRun {
  uint32_t offset;
  uint32_t size;
};

struct ComponentInfo {
  std::string_view name;
  ComponentId id = 0;
  uint64_t hash = 0;              // of the name: the same in every program
  uint32_t size = 0;              // bytes; 0 for an empty type (a tag), which has no column memory
  uint32_t alignment = 1;         // bytes
  bool transient = false;         // neither hashed nor saved
  bool has_entities = false;      // some field is an Entity
  std::vector<FieldInfo> fields;  // in the order of the SCREE_COMPONENT line
  const void* default_value = nullptr;  // T{}
  std::string (*fault)(const void* value) = nullptr;  // null: every value is allowed
  std::string (*fault_in)(World& world, Entity entity, const void* value) = nullptr;  // null: everywhere

  // Where the values are, without padding and texts: in the order of offsets, adjacent fields
  // merged.
  std::vector<ByteRun> runs;

  const FieldInfo* findField(std::string_view field) const;
  // Adds the component with its default value, or finds it when the entity has it already.
  // Returns its storage (valid until the next structural change); nullptr if the entity is dead.
  void* addDefault(World& world, Entity entity) const;
};

// All component types that the program contains; nullptr when the name is unknown.
const ComponentInfo* findComponent(std::string_view name);
const ComponentInfo& componentInfo(ComponentId id);
// In the order of their names.
std::vector<const ComponentInfo*> components();

// A plain struct (aggregate, trivially copyable) with a SCREE_COMPONENT line.
template <class T>
concept Component = requires {
  screeComponentInfo(static_cast<const T*>(nullptr));
};

template <class T>
ComponentId componentId() {
  static_assert(Component<T>, "SCREE_COMPONENT(T, ...) is missing after the struct");
  return screeComponentInfo(static_cast<const T*>(nullptr)).id;
}

namespace detail {

// Registers one type; ends the program when the name is taken or there are too many types.
const ComponentInfo& registerComponent(ComponentInfo info);

struct AnyValue {
  template <class T>
  operator T() const;
};
template <size_t>
using AnyValueAt = AnyValue;

template <class T, class = void, class... Values>
struct CanInitialize : std::false_type {};
template <class T, class... Values>
struct CanInitialize<T, std::void_t<decltype(T{std::declval<Values>()...})>, Values...>
    : std::true_type {};

template <class T, size_t... i>
constexpr bool takesInitializers(std::index_sequence<i...>) {
  return CanInitialize<T, void, AnyValueAt<i>...>::value;
}

// True when the fields listed are as many as the struct's members.
template <class T, class... Fields>
constexpr bool listsEveryField() {
  constexpr size_t count = (size_t{0} + ... + FieldTypeOf<Fields>::kInitializers);
  return takesInitializers<T>(std::make_index_sequence<count>{}) &&
         !takesInitializers<T>(std::make_index_sequence<count + 1>{});
}

template <class T>
const ComponentInfo& registerType(std::string_view name, bool transient,
                                  std::initializer_list<FieldInfo> fields) {
  static_assert(std::is_trivially_copyable_v<T>, "components are trivially copyable");
  static_assert(std::is_aggregate_v<T>, "components are plain structs without constructors");
  static const T default_value{};
  ComponentInfo info;
  info.name = name;
  info.size = std::is_empty_v<T> ? 0 : sizeof(T);
  info.alignment = alignof(T);
  info.transient = transient;
  info.fields = fields;
  info.default_value = &default_value;
  if constexpr (requires(const T& value) { fault(value); })
    info.fault = [](const void* value) { return fault(*static_cast<const T*>(value)); };
  if constexpr (requires(World& world, Entity entity, const T& value) { faultIn(world, entity, value); })
    info.fault_in = [](World& world, Entity entity, const void* value) {
      return faultIn(world, entity, *static_cast<const T*>(value));
    };
  return registerComponent(std::move(info));
}

}  // namespace detail
}  // namespace scree
