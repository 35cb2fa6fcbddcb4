// Access: what a system says it reads and writes, checked while it runs.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/ecs/component.h"

namespace scree {

// Types of singletons without a SCREE_COMPONENT line in one program; using more ends the program
// with one line.
inline constexpr uint32_t kMaxPlainSingletonTypes = 256;
inline constexpr uint32_t kMaxSingletonTypes = kMaxComponentTypes + kMaxPlainSingletonTypes;

// A component type, or kFirstSingletonAccess + a type of singleton.
using AccessId = uint32_t;
inline constexpr AccessId kFirstSingletonAccess = kMaxComponentTypes;
inline constexpr AccessId kMaxAccessIds = kFirstSingletonAccess + kMaxSingletonTypes;
std::string_view accessName(AccessId id);

namespace detail {
// `signature` contains "T = <type>", as GCC and Clang print it.
uint32_t registerSingletonType(std::string_view signature);

template <class T>
uint32_t plainSingletonType() {
  static const uint32_t id = registerSingletonType(__PRETTY_FUNCTION__);
  return id;
}
}  // namespace detail

// Dense number of a singleton's type; that of the component type if it is one.
template <class T>
uint32_t singletonTypeId() {
  if constexpr (Component<T>)
    return componentId<T>();
  else
    return detail::plainSingletonType<T>();
}

// Lists for SystemDesc::reads and ::writes: component types and types of singletons. A type that
// is both (a singleton with a SCREE_COMPONENT line) stands for both.
template <class T>
void appendAccess(std::vector<AccessId>& ids) {
  if constexpr (Component<T>) ids.push_back(componentId<T>());
  ids.push_back(kFirstSingletonAccess + singletonTypeId<T>());
}
template <class... T>
std::vector<AccessId> reads() {
  std::vector<AccessId> ids;
  (appendAccess<T>(ids), ...);
  return ids;
}
template <class... T>
std::vector<AccessId> writes() {
  return reads<T...>();
}

// End the program with one line if the system that runs on this thread declared its access and
// left this out. Code outside systems may touch everything.
void checkRead(AccessId id);
void checkWrite(AccessId id);

}  // namespace scree
