// The world's collider components as the solver wants them, with their motion over the tick.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "modules/grains/state.h"

namespace scree::grains {
namespace {

// Each entity may carry one collider of each kind.
enum class Kind : uint32_t { Plane, Box, Capsule, Sphere, Hull, Mesh, Sdf };
static_assert(static_cast<uint32_t>(Kind::Sdf) < kKeysOfEntity);
uint32_t keyOf(Entity entity, Kind kind) { return firstKeyOf(entity) + static_cast<uint32_t>(kind); }

bool placeable(const Transform& transform) {
  const glm::dvec3& p = transform.position;
  const float q = glm::dot(transform.rotation, transform.rotation);
  return std::isfinite(p.x + p.y + p.z) && q > 0.25f && q < 4 && std::isfinite(transform.scale.x + transform.scale.y + transform.scale.z);
}

template <class Component>
Collider place(const GrainsState& state, Entity entity, Kind kind, Shape shape,
               const Transform& transform, const Component& component, const dvec3& origin, float dt) {
  Collider collider;
  collider.key = keyOf(entity, kind);
  collider.shape = shape;
  collider.position0 = collider.position1 = vec3(transform.position - origin);
  collider.rotation0 = collider.rotation1 = glm::normalize(transform.rotation);
  if (const ColliderPose* pose = state.world.peek<ColliderPose>(entity)) {
    const double moved = glm::length(transform.position - pose->position);
    if (moved <= kColliderTeleport * dt) {
      collider.position0 = vec3(pose->position - origin);
      collider.rotation0 = transform.rotation == pose->rotation ? collider.rotation1
                                                                : glm::normalize(pose->rotation);
    }
  }
  collider.friction = component.friction;
  collider.rolling_friction = component.rolling_friction;
  collider.restitution = component.restitution;
  collider.cohesion = component.cohesion;
  collider.surface_velocity = component.surface_velocity;
  collider.sensed = state.world.has<LoadSensor>(entity);
  return collider;
}

// The sizes of a shape in the world, after scaling.
bool sized(vec3 size) { return size.x < 1e9f && size.y < 1e9f && size.z < 1e9f; }

template <class Component>
std::string faultIn(const Transform& transform, const Component& component, vec3 size) {
  if (std::string wrong = fault(component); !wrong.empty()) return wrong;
  if (!placeable(transform)) return "its Transform must be finite, with a unit rotation";
  if (!sized(size)) return "scaled, it must be smaller than 1e9 m";
  return {};
}

}  // namespace

void gatherColliders(GrainsState& state, const dvec3& origin, float dt) {
  state.colliders.clear();
  state.collider_entities.clear();
  size_t refused = 0;
  const auto add = [&](Entity entity, const Transform& transform, const auto& component,
                       const Collider& collider, vec3 size, const char* shape) {
    const std::string wrong = faultIn(transform, component, size);
    if (wrong.empty()) {
      state.colliders.push_back(collider);
    } else if (refused++ == 0 && state.refused_colliders == 0) {
      logWarning("grains.step: {} of {} refused: {}", shape, nameOf(state.world, entity), wrong);
    }
  };
  state.planes.each([&](Entity entity, const Transform& transform, const PlaneCollider& plane) {
    add(entity, transform, plane,
        place(state, entity, Kind::Plane, Shape::Plane, transform, plane, origin, dt), vec3(0),
        "PlaneCollider");
  });
  state.boxes.each([&](Entity entity, const Transform& transform, const BoxCollider& box) {
    Collider collider = place(state, entity, Kind::Box, Shape::Box, transform, box, origin, dt);
    collider.half_extent = box.half_extent * glm::abs(transform.scale);
    add(entity, transform, box, collider, collider.half_extent, "BoxCollider");
  });
  state.capsules.each([&](Entity entity, const Transform& transform, const CapsuleCollider& capsule) {
    Collider collider = place(state, entity, Kind::Capsule, Shape::Capsule, transform, capsule, origin, dt);
    collider.a = capsule.a * transform.scale;
    collider.b = capsule.b * transform.scale;
    const vec3 scale = glm::abs(transform.scale);
    collider.radius = capsule.radius * std::max({scale.x, scale.y, scale.z});
    add(entity, transform, capsule, collider,
        vec3(glm::length(collider.a), glm::length(collider.b), collider.radius), "CapsuleCollider");
  });
  state.spheres.each([&](Entity entity, const Transform& transform, const SphereCollider& sphere) {
    Collider collider =
        place(state, entity, Kind::Sphere, Shape::Capsule, transform, sphere, origin, dt);
    collider.a = collider.b = sphere.center * transform.scale;
    const vec3 scale = glm::abs(transform.scale);
    collider.radius = sphere.radius * std::max({scale.x, scale.y, scale.z});
    add(entity, transform, sphere, collider, vec3(glm::length(collider.a), collider.radius, 0),
        "SphereCollider");
  });
  // Those of the entity's mesh. A mesh that will not do has its own line: Shapes::of.
  const auto addField = [&](Entity entity, const Transform& transform, const auto& component, Kind kind,
                            const char* name, const auto& ask) {
    Collider collider = place(state, entity, kind, Shape::Field, transform, component, origin, dt);
    if (faultIn(transform, component, vec3(0)).empty()) {
      FoundShape found = ask(keyOf(entity, kind), entity, transform.scale);
      if (found.field == nullptr) return;
      collider.field = std::move(found.field);
      collider.field_identity = found.identity;
    }
    add(entity, transform, component, collider, vec3(0), name);
  };
  if (state.hulls.empty() && state.meshes.empty() && state.fields.empty()) {
    state.shapes.forget(state.world);
  } else {
    state.shapes.begin(state.world);
    state.hulls.each([&](Entity entity, const Transform& transform, const HullCollider& hull) {
      addField(entity, transform, hull, Kind::Hull, "HullCollider",
               [&](uint32_t key, Entity of, vec3 scale) { return state.shapes.hull(key, of, scale); });
    });
    state.meshes.each([&](Entity entity, const Transform& transform, const MeshCollider& mesh) {
      addField(entity, transform, mesh, Kind::Mesh, "MeshCollider",
               [&](uint32_t key, Entity of, vec3 scale) { return state.shapes.mesh(key, of, scale, mesh); });
    });
    state.fields.each([&](Entity entity, const Transform& transform, const SdfCollider& sdf) {
      addField(entity, transform, sdf, Kind::Sdf, "SdfCollider",
               [&](uint32_t key, Entity of, vec3 scale) { return state.shapes.sdf(key, of, scale, sdf); });
    });
    state.shapes.end();
  }
  if (refused > 1 && refused > state.refused_colliders)
    logWarning("grains.step: {} colliders refused, the first is named above", refused);
  state.refused_colliders = refused;
  // By key: the order of tables and rows must not show in the results.
  std::sort(state.colliders.begin(), state.colliders.end(),
            [](const Collider& a, const Collider& b) { return a.key < b.key; });
}

void keepColliderPoses(GrainsState& state) {
  World& world = state.world;
  std::vector<Entity>& entities = state.collider_entities;
  entities.clear();
  const auto collect = [&](Entity entity, const Transform&, const auto&) {
    entities.push_back(entity);
  };
  state.planes.each(collect);
  state.boxes.each(collect);
  state.capsules.each(collect);
  state.spheres.each(collect);
  state.hulls.each(collect);
  state.meshes.each(collect);
  state.fields.each(collect);
  for (const Entity entity : entities) {
    const Transform& transform = *world.peek<Transform>(entity);
    const ColliderPose now{transform.position, transform.rotation};
    const ColliderPose* kept = world.peek<ColliderPose>(entity);
    if (kept == nullptr) {
      world.add(entity, now);
    } else if (kept->position != now.position || kept->rotation != now.rotation) {
      *world.find<ColliderPose>(entity) = now;
    }
  }
}

}  // namespace scree::grains
