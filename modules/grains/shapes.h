// The shapes of hull, mesh and SDF colliders: made of meshes once, shared, kept while they are used.
#pragma once

#include <string>
#include <vector>

#include "modules/grains/surface_field.h"

namespace scree {
class MeshStore;
}

namespace scree::grains {

// A field, null if there is none, and what tells it from others in every process (Collider).
struct FoundShape {
  SharedField field;
  uint64_t identity = 0;
};

class Shapes {
 public:
  // Around the questions of a tick: what was not asked for in some ticks is let go.
  void begin(World& world);
  void end();
  // There are no such colliders.
  void forget(World& world);

  // The shape of an entity's mesh, scaled; null if it has none that will do, which one line says when
  // it is first found. `key` identifies the collider.
  FoundShape hull(uint32_t key, Entity entity, vec3 scale);
  FoundShape mesh(uint32_t key, Entity entity, vec3 scale, const MeshCollider& collider);
  FoundShape sdf(uint32_t key, Entity entity, vec3 scale, const SdfCollider& collider);

  // What is wrong with a shape of closed triangles as a body's, by its identity; empty: nothing.
  std::string faultAsBody(uint64_t identity) const;
  // The same of an entity's HullCollider or solid MeshCollider, if it has one, and of the mesh: makes the shape.
  static std::string faultAsBody(const MeshStore& store, const World& world, Entity entity);

 private:
  enum class Kind : uint32_t { Hull, Sheet, Solid, Sdf };
  struct Recipe {
    Kind kind = Kind::Hull;
    uint32_t mesh = 0;
    vec3 scale{1};
    float detail = 0;  // thickness, or resolution
    bool operator==(const Recipe&) const = default;
  };
  struct Shape {
    Recipe recipe;
    FoundShape found;  // null: refused
    std::string fault_as_body;
    std::string fault;
    uint32_t unused = 0;  // ticks
  };

  FoundShape find(uint32_t key, Entity entity, const char* collider, Recipe recipe);
  static void make(const MeshStore& store, Shape& shape);
  FoundShape refuse(uint32_t key, Entity entity, const char* collider, const std::string& why);
  void count();

  World* world_ = nullptr;
  std::vector<Shape> shape_;
  std::vector<uint32_t> refused_, refused_now_;  // keys, sorted
};

}  // namespace scree::grains
