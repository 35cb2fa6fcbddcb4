// Commands: structural changes that are recorded now and applied at World::flush().
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/ecs/component.h"

namespace scree {

// A component's type and the address of its value.
struct ComponentValue {
  ComponentId id;
  const void* value;
};

// A buffer of commands, recorded by one thread at a time. Commands on an entity that is dead when
// they are applied are refused and counted (World::flush), which is no error: two systems may
// destroy one entity.
class Commands {
 public:
  // The handle returned is pending: it may be used in later commands of the same buffer and in the
  // Entity fields of their components, and names the new entity after the flush.
  template <Component... T>
  Entity spawn(const T&... values) {
    const std::array<ComponentValue, sizeof...(T)> list{
        ComponentValue{componentId<T>(), &values}...};
    return spawn(std::span<const ComponentValue>(list));
  }
  void destroy(Entity entity);
  // Overwrites the value if the entity has the component already.
  template <Component T>
  void add(Entity entity, const T& value = T{}) {
    add(entity, ComponentValue{componentId<T>(), &value});
  }
  template <Component T>
  void remove(Entity entity) {
    remove(entity, componentId<T>());
  }

  Entity spawn(std::span<const ComponentValue> values);
  void add(Entity entity, ComponentValue value);
  void remove(Entity entity, ComponentId id);
  bool empty() const { return bytes_.empty(); }

 private:
  friend struct WorldState;
  enum class Op : uint32_t { Spawn, Destroy, Add, Remove };
  struct Header {
    Op op;
    uint32_t count;  // Spawn: components; Add, Remove: the component's id
    Entity entity;   // Spawn: unused
  };
  void push(const void* data, size_t size);
  void pushHeader(const Header& header);
  void pushValue(ComponentValue value);

  std::vector<std::byte> bytes_;  // headers, each followed by its values
  uint32_t spawned_ = 0;
  bool open_ = false;  // false: flushed, so that whoever still holds it must take another
};

}  // namespace scree
