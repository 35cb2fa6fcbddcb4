// SCREE_COMPONENT and the preprocessor steps behind it.
#pragma once

#include <cstddef>

// SCREE_COMPONENT(Type, (field, "unit"), ...) at namespace scope, right after the struct; all
// fields must be listed. The name is that of the type, without its namespace, and is unique.
#define SCREE_COMPONENT(Type, ...) SCREE_COMPONENT_AS(Type, false __VA_OPT__(, ) __VA_ARGS__)

// The same for a type that is derived from others: neither hashed nor saved.
#define SCREE_COMPONENT_TRANSIENT(Type, ...) \
  SCREE_COMPONENT_AS(Type, true __VA_OPT__(, ) __VA_ARGS__)

#define SCREE_COMPONENT_AS(Type, transient, ...)                                               \
  inline const ::scree::ComponentInfo& screeComponentInfo(const Type*) {                       \
    using Self = Type;                                                                         \
    static_assert(::scree::detail::listsEveryField<Self __VA_OPT__(, ) SCREE_LIST(             \
                      SCREE_FIELD_TYPE __VA_OPT__(, ) __VA_ARGS__)>(),                         \
                  "SCREE_COMPONENT(" #Type ", ...) must list every field of the struct once"); \
    static const ::scree::ComponentInfo& info = ::scree::detail::registerType<Self>(           \
        #Type, transient, {SCREE_LIST(SCREE_FIELD_INFO __VA_OPT__(, ) __VA_ARGS__)});          \
    return info;                                                                               \
  }                                                                                            \
  [[maybe_unused]] inline const ::scree::ComponentInfo& scree_registered_##Type =              \
      screeComponentInfo(static_cast<const Type*>(nullptr))

#define SCREE_FIELD_TYPE(field, unit) decltype(Self::field)
#define SCREE_FIELD_INFO(field, unit)                                        \
  ::scree::FieldInfo {                                                       \
#field, ::scree::detail::FieldTypeOf < decltype(Self::field)> ::kType,   \
        static_cast < uint32_t>(offsetof(Self, field)),                      \
        ::scree::detail::FieldTypeOf < decltype(Self::field)> ::kCount, unit \
  }

// SCREE_LIST(macro, (a, b), (c, d)) is macro(a, b), macro(c, d); up to 80 fields.
#define SCREE_LIST(macro, ...) __VA_OPT__(SCREE_RESCAN(SCREE_LIST_STEP(macro, __VA_ARGS__)))
#define SCREE_LIST_STEP(macro, first, ...) \
  macro first __VA_OPT__(, SCREE_LIST_AGAIN SCREE_PARENS(macro, __VA_ARGS__))
#define SCREE_LIST_AGAIN() SCREE_LIST_STEP
#define SCREE_PARENS ()
#define SCREE_RESCAN(...) SCREE_RESCAN3(SCREE_RESCAN3(SCREE_RESCAN3(__VA_ARGS__)))
#define SCREE_RESCAN3(...) SCREE_RESCAN2(SCREE_RESCAN2(SCREE_RESCAN2(__VA_ARGS__)))
#define SCREE_RESCAN2(...) SCREE_RESCAN1(SCREE_RESCAN1(SCREE_RESCAN1(__VA_ARGS__)))
#define SCREE_RESCAN1(...) SCREE_RESCAN0(SCREE_RESCAN0(SCREE_RESCAN0(__VA_ARGS__)))
#define SCREE_RESCAN0(...) __VA_ARGS__
