// Components from JSON, by their reflected names: how a node's extras become components.
//
// {"BoxCollider": {"half_extent": [1, 2, 3]}} adds BoxCollider with its defaults and that field.
// Values: numbers and booleans; arrays for vectors, quaternions (x, y, z, w) and arrays; strings
// for text; the name of a node (or null) for an Entity; a number for an enum. `true` instead of an
// object adds the component as it is by default, `false` takes it away.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"
#include "engine/ecs/component.h"
#include "engine/ecs/world.h"

namespace scree {

// Components read from JSON, checked, not yet attached.
struct ParsedExtras {
  struct Patch {
    size_t offset = 0;  // of the field in the component
    std::vector<std::byte> bytes;
  };
  struct Link {
    size_t offset = 0;  // of an Entity field
    std::string name;   // of the node it refers to
  };
  struct Value {
    const ComponentInfo* component = nullptr;
    bool present = true;  // false: {"CastsShadow": false} takes a component away
    std::vector<Patch> patches;
    std::vector<Link> links;
  };
  std::vector<Value> values;  // in the order of the components' names
};

// How many nodes have a name; an Entity field must name exactly one.
using CountNodes = std::function<size_t(std::string_view name)>;
// Turns a node's name into its entity; Entity::kNone if there is none.
using FindNode = std::function<Entity(std::string_view name)>;

// `where` begins every message: "level.glb: node 4 \"scale\"". Keys that are no component's name
// are ignored, with one warning a name and process (artists' tools store their own extras); so are
// extras that are no object. Values that the component's own fault() refuses, wrong types, unknown fields, values out of a field's range, numbers
// that are not finite, and nodes that do not exist are errors.
Result<ParsedExtras> parseExtras(const nlohmann::json& extras, std::string_view where,
                                 const CountNodes& count_nodes = {});

// Adds the components to a living entity; fields of a component it has already keep their values
// unless the JSON sets them.
void attach(World& world, Entity entity, const ParsedExtras& parsed,
            const FindNode& find_node = {});

// Both at once; on an error nothing is attached.
Status attachExtras(World& world, Entity entity, const nlohmann::json& extras,
                    std::string_view where, const FindNode& find_node = {});

}  // namespace scree
