// Making the shapes of colliders out of meshes, and keeping them.
#include "modules/grains/shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "modules/grains/hull.h"
#include "modules/grains/rigid_form.h"
#include "modules/grains/state.h"
#include "modules/grains/triangle_surface.h"

namespace scree {
namespace grains {
namespace {

// A shape that nothing asked for in so many ticks is let go.
constexpr uint32_t kTicksKept = 60;

// World singleton: fields that programs gave.
struct DistanceFields {
  std::vector<SharedField> field;
};

// Corners of a mesh's triangles, three each, scaled. A mirrored mesh keeps its outside outside.
std::vector<vec3> cornersOf(const MeshStore& store, const StoredMesh& mesh, vec3 scale) {
  const bool mirrored = scale.x * scale.y * scale.z < 0;
  std::vector<vec3> corners;
  for (const MeshPart& part : mesh.parts) {
    const std::span<const Vertex> vertices = store.vertices(part);
    for (const uint32_t index : store.indices(part)) corners.push_back(vertices[index].position * scale);
  }
  if (mirrored)
    for (size_t k = 0; k + 3 <= corners.size(); k += 3) std::swap(corners[k + 1], corners[k + 2]);
  return corners;
}

size_t trianglesOf(const StoredMesh& mesh) {
  size_t indices = 0;
  for (const MeshPart& part : mesh.parts) indices += part.index_count;
  return indices / 3;
}

// Of closed triangles as a body: below what a box may be thin.
std::string faultOfThickness(double thickness) {
  if (thickness >= kLeastRadius) return {};
  return fmt::format("its mesh is {:.3g} m thick, twice the volume over the area; a body's is {} m or more", thickness, kLeastRadius);
}

}  // namespace

void Shapes::begin(World& world) {
  world_ = &world;
  refused_now_.clear();
  for (Shape& shape : shape_) ++shape.unused;
}

void Shapes::end() {
  std::erase_if(shape_, [](const Shape& shape) { return shape.unused > kTicksKept; });
  std::sort(refused_now_.begin(), refused_now_.end());
  refused_.swap(refused_now_);
  count();
}

void Shapes::forget(World& world) {
  if (shape_.empty() && refused_.empty()) return;
  begin(world);
  end();
}

void Shapes::count() {
  ColliderShapes& counts = world_->singleton<ColliderShapes>();
  counts.kept = 0;
  counts.bytes = 0;
  for (const Shape& shape : shape_) {
    if (shape.found.field == nullptr) continue;
    ++counts.kept;
    counts.bytes += shape.found.field->memoryBytes();
  }
}

FoundShape Shapes::hull(uint32_t key, Entity entity, vec3 scale) {
  return find(key, entity, "HullCollider", {Kind::Hull, 0, scale, 0});
}

FoundShape Shapes::mesh(uint32_t key, Entity entity, vec3 scale, const MeshCollider& collider) {
  const vec3 size = glm::abs(scale);
  return find(key, entity, "MeshCollider",
              {collider.solid ? Kind::Solid : Kind::Sheet, 0, scale,
               collider.thickness * std::max({size.x, size.y, size.z})});
}

FoundShape Shapes::sdf(uint32_t key, Entity entity, vec3 scale, const SdfCollider& collider) {
  if (collider.field == 0)
    return find(key, entity, "SdfCollider", {Kind::Sdf, 0, scale, static_cast<float>(collider.resolution)});
  const std::vector<SharedField>& given = world_->singleton<DistanceFields>().field;
  if (collider.field > given.size())
    return refuse(key, entity, "SdfCollider",
                  fmt::format("field = {}; the program has given {}", collider.field, given.size()));
  if (scale != vec3(1))
    return refuse(key, entity, "SdfCollider",
                  fmt::format("its Transform's scale is ({}, {}, {}); allowed is 1 for a field that a program gave",
                              scale.x, scale.y, scale.z));
  // Programs give their fields in a set order.
  return {given[collider.field - 1], collider.field};
}

FoundShape Shapes::find(uint32_t key, Entity entity, const char* collider, Recipe recipe) {
  const MeshInstance* instance = world_->peek<MeshInstance>(entity);
  if (instance == nullptr) return refuse(key, entity, collider, "its node has no mesh");
  recipe.mesh = instance->mesh;
  auto at = std::find_if(shape_.begin(), shape_.end(),
                         [&](const Shape& shape) { return shape.recipe == recipe; });
  if (at == shape_.end()) {
    shape_.push_back({.recipe = recipe});
    at = std::prev(shape_.end());
    make(world_->singleton<const MeshStore>(), *at);
    ColliderShapes& counts = world_->singleton<ColliderShapes>();
    const uint64_t made = at->found.field != nullptr;
    (recipe.kind == Kind::Hull ? counts.hulls : recipe.kind == Kind::Sdf ? counts.fields : counts.meshes) += made;
  }
  at->unused = 0;
  return at->found.field != nullptr ? at->found : refuse(key, entity, collider, at->fault);
}

void Shapes::make(const MeshStore& store, Shape& shape) {
  const Recipe& recipe = shape.recipe;
  if (recipe.mesh >= store.size()) {
    shape.fault = fmt::format("its MeshInstance names mesh {}; there are {}", recipe.mesh, store.size());
    return;
  }
  const StoredMesh& mesh = store.mesh(recipe.mesh);
  const auto named = [&](const std::string& wrong) {
    return fmt::format("mesh \"{}\": {}", mesh.name, wrong);
  };
  if (recipe.scale.x == 0 || recipe.scale.y == 0 || recipe.scale.z == 0) {
    shape.fault = named(fmt::format("scaled by ({}, {}, {}) it is flat", recipe.scale.x, recipe.scale.y,
                                    recipe.scale.z));
    return;
  }
  const size_t triangles = trianglesOf(mesh);
  if (triangles > kMostTriangles) {  // before they are copied
    shape.fault = named(fmt::format("it has {} triangles; allowed are {}", triangles, kMostTriangles));
    return;
  }
  const std::vector<vec3> corners = cornersOf(store, mesh, recipe.scale);
  Result<SharedField> made = SharedField();
  switch (recipe.kind) {
    case Kind::Hull:
      made = makeHull(corners);
      break;
    case Kind::Sheet:
    case Kind::Solid:
      made = makeMesh(corners, recipe.kind == Kind::Solid, recipe.detail);
      break;
    case Kind::Sdf:
      made = bakeMesh(corners, static_cast<int>(recipe.detail));
      break;
  }
  if (made.ok()) {
    const struct {
      Kind kind;
      float detail;
    } how{recipe.kind, recipe.detail};
    shape.found = {*made, hashBytes(corners.data(), corners.size() * sizeof(vec3), hashBytes(&how, sizeof how))};
    if (const std::span<const vec3> closed = (*made)->corners(); !closed.empty())
      shape.fault_as_body = faultOfThickness(thicknessOf(closed));
  } else {
    shape.fault = named(made.error());
  }
}

std::string Shapes::faultAsBody(uint64_t identity) const {
  for (const Shape& shape : shape_)
    if (shape.found.field != nullptr && shape.found.identity == identity) return shape.fault_as_body;
  return {};
}

std::string Shapes::faultAsBody(const MeshStore& store, const World& world, Entity entity) {
  const MeshInstance* instance = world.peek<MeshInstance>(entity);
  const MeshCollider* mesh = world.peek<MeshCollider>(entity);
  if (instance == nullptr || (mesh == nullptr && !world.has<HullCollider>(entity))) return {};
  Shape shape;
  shape.recipe = {mesh != nullptr ? Kind::Solid : Kind::Hull, instance->mesh, world.peek<Transform>(entity)->scale, 0};
  make(store, shape);
  return shape.fault.empty() ? shape.fault_as_body : shape.fault;
}

FoundShape Shapes::refuse(uint32_t key, Entity entity, const char* collider, const std::string& why) {
  refused_now_.push_back(key);
  if (!std::binary_search(refused_.begin(), refused_.end(), key)) {
    logWarning("grains.step: {} of {} refused: {}", collider, nameOf(*world_, entity), why);
    ++world_->singleton<ColliderShapes>().refused;
  }
  return {};
}

}  // namespace grains

uint32_t addDistanceField(World& world, std::shared_ptr<const DistanceField> field) {
  std::vector<grains::SharedField>& given = world.singleton<grains::DistanceFields>().field;
  given.push_back(std::move(field));
  return static_cast<uint32_t>(given.size());
}

}  // namespace scree
