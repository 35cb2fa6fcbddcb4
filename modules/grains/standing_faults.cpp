// What a level may say of where the module's components stand: beside which others, and within what bounds.
#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include "modules/grains/state.h"

namespace scree {
namespace {

using namespace grains;

int collidersOf(const World& world, Entity entity) {
  return world.has<PlaneCollider>(entity) + world.has<BoxCollider>(entity) + world.has<CapsuleCollider>(entity) +
         world.has<SphereCollider>(entity) + world.has<HullCollider>(entity) + world.has<MeshCollider>(entity) +
         world.has<SdfCollider>(entity);
}

// The lowest entity of the query for which `counts`.
template <class Component, class Counts>
Entity lowest(World& world, const Counts& counts) {
  Entity first = Entity::kNone;
  world.query<const Component>().each([&](Entity entity, const Component& component) {
    if ((first == Entity::kNone || entity < first) && counts(component)) first = entity;
  });
  return first;
}

// World singleton: the world's field, where it is or where the first tick will place it, as of these versions; none:
// nobody knows yet. Each of many blocks asks.
struct FieldToBe {
  Version fields = 0, blocks = 0, emitters = 0;
  std::optional<GrainField> field;
};

std::optional<GrainField> findFieldToBe(World& world) {
  const GrainField* there = peekField(world);
  GrainField field = there != nullptr ? *there : GrainField();
  if (field.placed) return field;
  Entity first = lowest<GrainBlock>(world, [](const GrainBlock&) { return true; });
  if (first == Entity::kNone)
    first = lowest<GrainEmitter>(world, [](const GrainEmitter& emitter) { return emitter.on && emitter.rate > 0; });
  const Transform* transform = world.peek<Transform>(first);
  if (transform == nullptr) return {};
  field.origin = glm::round(transform->position);
  return field;
}

const std::optional<GrainField>& fieldToBe(World& world) {
  FieldToBe& known = world.singleton<FieldToBe>();
  const Version fields = world.query<const GrainField>().version();
  const Version blocks = world.query<const Transform, const GrainBlock>().version();
  const Version emitters = world.query<const Transform, const GrainEmitter>().version();
  if (fields != known.fields || blocks != known.blocks || emitters != known.emitters)
    known = {fields, blocks, emitters, findFieldToBe(world)};
  return known.field;
}

// Of what starts within `reach` of the Transform along each axis; what starts outside would be lost at once.
std::string faultOutside(World& world, const Transform& transform, vec3 reach, const char* what) {
  const std::optional<GrainField>& field = fieldToBe(world);
  if (!field) return {};
  const dvec3 at = transform.position - field->origin, low = at - dvec3(reach), high = at + dvec3(reach);
  for (int axis = 0; axis < 3; ++axis) {
    const double from = low[axis], to = high[axis];
    const float least = field->bounds_min[axis], most = field->bounds_max[axis];
    if (from >= least && to <= most) continue;
    const std::string span = from < to ? fmt::format("{:.6g} to {:.6g}", from, to) : fmt::format("{:.6g}", from);
    return fmt::format("{0} at {1} = {2} from the origin of GrainField; allowed is bounds_min.{1} = {3} "
                       "to bounds_max.{1} = {4}",
                       what, "xyz"[axis], span, least, most);
  }
  return {};
}

std::string faultOfMesh(const World& world, Entity entity) {
  return world.has<MeshInstance>(entity) ? std::string() : "its node has no mesh; one is needed";
}

float longestArm(const ClumpForm& form) {
  float longest = 0;
  for (uint32_t k = 0; k < form.count; ++k) longest = std::max(longest, glm::length(form.arm[k]));
  return longest;
}

}  // namespace

std::string faultIn(World& world, Entity entity, const GrainField&) {
  const Entity first = lowest<GrainField>(world, [](const GrainField&) { return true; });
  if (first == entity) return {};
  return fmt::format("a world has one; {} has it", nameOf(world, first));
}

std::string faultIn(World& world, Entity entity, const GrainBlock& block) {
  const Transform& transform = *world.peek<Transform>(entity);
  const vec3 count(block.count[0], block.count[1], block.count[2]);
  if (count.x * count.y * count.z == 0) return {};
  // Centres of spheres keep off the walls of their lattice cells; members of clumps only stay within.
  const float smallest = block.radius * (1 - block.radius_jitter);
  vec3 half = 0.5f * spacingOf(block, 1) * count - smallest;
  if (const ClumpShape* shape = world.peek<ClumpShape>(entity)) {
    ClumpForms forms;
    if (std::string wrong = faultOfClumps(block, *shape, forms); !wrong.empty()) return wrong;
    half = 0.5f * spacingOf(block, forms.of(*shape).bound) * count;
  }
  const mat3 m = glm::mat3_cast(glm::normalize(transform.rotation));
  return faultOutside(world, transform, glm::abs(m[0]) * half.x + glm::abs(m[1]) * half.y + glm::abs(m[2]) * half.z,
                      "its grains start");
}

std::string faultIn(World& world, Entity entity, const GrainEmitter& emitter) {
  const Transform& transform = *world.peek<Transform>(entity);
  float arm = 0;
  if (const ClumpShape* shape = world.peek<ClumpShape>(entity)) {
    const float largest = emitter.radius * (1 + emitter.radius_jitter);
    std::string wrong = faultOfClumps(*shape, emitter.radius * (1 - emitter.radius_jitter), largest);
    if (!wrong.empty()) return wrong;
    arm = largest * longestArm(formOf(*shape));
  }
  if (!emitter.on) return {};  // whoever turns it on may move it first
  const mat3 m = glm::mat3_cast(glm::normalize(transform.rotation));
  const vec3 x = emitter.mouth * transform.scale.x * m[0], z = emitter.mouth * transform.scale.z * m[2];
  return faultOutside(world, transform, glm::sqrt(x * x + z * z) + arm, "its grains start");
}

std::string faultIn(World& world, Entity entity, const ClumpShape&) {
  const bool maker = world.has<GrainBlock>(entity) || world.has<GrainEmitter>(entity);
  return maker ? std::string() : "says what a GrainBlock or a GrainEmitter makes; its node has neither";
}

std::string faultIn(World& world, Entity entity, const HullCollider&) { return faultOfMesh(world, entity); }
std::string faultIn(World& world, Entity entity, const MeshCollider&) { return faultOfMesh(world, entity); }
std::string faultIn(World& world, Entity entity, const SdfCollider& sdf) {
  return sdf.field == 0 ? faultOfMesh(world, entity) : std::string();
}

std::string faultIn(World& world, Entity entity, const LoadSensor&) {
  return collidersOf(world, entity) > 0 ? std::string() : "reads what presses on a collider; its node has none";
}

std::string faultIn(World& world, Entity entity, const RigidBody&) {
  const int colliders = collidersOf(world, entity);
  if (colliders != 1) return fmt::format("its node has {} colliders; a body has one", colliders);
  if (world.has<PlaneCollider>(entity)) return "its collider is a plane; a body's has a volume";
  const MeshCollider* mesh = world.peek<MeshCollider>(entity);
  if (mesh != nullptr && !mesh->solid) return "its MeshCollider is a sheet; a body's is solid";
  std::string wrong = Shapes::faultAsBody(world.singleton<const MeshStore>(), world, entity);
  if (!wrong.empty()) return wrong;
  return faultOutside(world, *world.peek<Transform>(entity), vec3(0), "it starts");
}

std::string faultIn(World& world, Entity entity, const BodyHinge&) {
  return world.has<RigidBody>(entity) ? std::string() : "holds a RigidBody; its node has none";
}

std::string faultIn(World& world, Entity entity, const BodySlider&) {
  if (!world.has<RigidBody>(entity)) return "holds a RigidBody; its node has none";
  return world.has<BodyHinge>(entity) ? "a body has a BodyHinge or a BodySlider; its node has both" : std::string();
}

}  // namespace scree
