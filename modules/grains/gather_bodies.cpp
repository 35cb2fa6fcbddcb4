// Rigid bodies of the world as the solver wants them, and back.
#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "modules/grains/state.h"

namespace scree::grains {
namespace {

// The collider of the entity; null: `why` says.
const Collider* colliderOf(const GrainsState& state, Entity entity, std::string& why) {
  const uint32_t first = firstKeyOf(entity);
  const auto from = std::lower_bound(state.colliders.begin(), state.colliders.end(), first,
                                     [](const Collider& c, uint32_t key) { return c.key < key; });
  const auto to = std::find_if(from, state.colliders.end(),
                               [&](const Collider& c) { return c.key >= first + kKeysOfEntity; });
  if (to - from != 1) {
    why = fmt::format("its entity has {} colliders; a body has one", to - from);
    return nullptr;
  }
  const Collider& collider = *from;
  const bool flat = collider.shape == Shape::Box && !(std::min({collider.half_extent.x, collider.half_extent.y,
                                                                collider.half_extent.z}) >= kLeastRadius);
  const bool thin = collider.shape == Shape::Capsule && !(collider.radius >= kLeastRadius);
  const bool sheet = collider.shape == Shape::Field && state.world.has<MeshCollider>(entity) &&
                     collider.field->corners().empty();
  if (collider.shape == Shape::Plane || flat || thin || sheet) {
    why = sheet ? "its MeshCollider is a sheet; a body's is solid"
                : fmt::format("its collider has no volume, or is thinner than {} m", 2 * kLeastRadius);
    return nullptr;
  }
  if (collider.shape == Shape::Field) {
    const auto [low, high] = collider.field->bounds();
    if (!(glm::length(high - low) < kMostDistance)) {
      why = "its field has no end";
      return nullptr;
    }
    why = state.shapes.faultAsBody(collider.field_identity);
    if (!why.empty()) return nullptr;
  }
  return &collider;
}

std::string placeHinge(World& world, Entity entity, const Transform& transform, const dvec3& origin, RigidRow& row) {
  const BodyHinge& seen = *world.peek<BodyHinge>(entity);
  if (std::string wrong = fault(seen); !wrong.empty()) return "BodyHinge: " + wrong;
  const quat rotation = glm::normalize(transform.rotation);
  row.freedom = Freedom::Hinge;
  row.point_local = seen.point * transform.scale;
  row.line_local = glm::normalize(seen.axis);
  row.resistance = seen.resistance;
  if (!seen.placed) {
    BodyHinge& hinge = *world.find<BodyHinge>(entity);
    hinge.placed = true;
    hinge.pivot = transform.position + dvec3(rotation * row.point_local);
    hinge.line = glm::normalize(rotation * row.line_local);
  }
  const BodyHinge& hinge = *world.peek<BodyHinge>(entity);
  row.pivot = hinge.pivot - origin;
  row.line = glm::normalize(hinge.line);
  return {};
}

std::string placeSlider(World& world, Entity entity, const Transform& transform, const dvec3& origin, RigidRow& row) {
  const BodySlider& seen = *world.peek<BodySlider>(entity);
  if (std::string wrong = fault(seen); !wrong.empty()) return "BodySlider: " + wrong;
  if (!seen.placed) {
    BodySlider& slider = *world.find<BodySlider>(entity);
    slider.placed = true;
    slider.home = transform.position;
  }
  const BodySlider& slider = *world.peek<BodySlider>(entity);
  row.freedom = Freedom::Slider;
  row.line = glm::normalize(slider.axis);
  row.pivot = slider.home - origin;
  row.stiffness = slider.stiffness;
  row.resistance = slider.resistance;
  row.low = slider.low;
  row.high = slider.high;
  return {};
}

}  // namespace

void gatherBodies(GrainsState& state, const dvec3& origin) {
  state.body_rows.clear();
  state.body_entities.clear();
  if (state.bodies.empty()) {
    state.refused_bodies = {};
    return;
  }
  World& world = state.world;
  state.bodies.each([&](Entity entity, const Transform&, const RigidBody&) { state.body_entities.push_back(entity); });
  // By key: the order of rows must not show.
  std::sort(state.body_entities.begin(), state.body_entities.end(),
            [](Entity a, Entity b) { return a.index < b.index; });
  state.refused_bodies = {state.refused_bodies.now, 0};
  std::erase_if(state.body_entities, [&](Entity entity) {
    const Transform& transform = *world.peek<Transform>(entity);
    const RigidBody& body = *world.peek<RigidBody>(entity);
    std::string wrong = fault(body);
    const Collider* collider = wrong.empty() ? colliderOf(state, entity, wrong) : nullptr;
    RigidRow row;
    if (wrong.empty()) {
      row.key = collider->key;
      row.position = transform.position - origin;
      row.rotation = transform.rotation;
      row.velocity = body.velocity;
      row.spin = body.spin;
      row.density = body.density;
      row.mass = body.mass;
      row.damping = body.damping;
      row.asleep = body.asleep;
      const bool hinge = world.has<BodyHinge>(entity), slider = world.has<BodySlider>(entity);
      if (hinge && slider) wrong = "it has a BodyHinge and a BodySlider; one is allowed";
      else if (hinge) wrong = placeHinge(world, entity, transform, origin, row);
      else if (slider) wrong = placeSlider(world, entity, transform, origin, row);
    }
    if (wrong.empty()) {
      state.body_rows.push_back(row);
      return false;
    }
    if (state.refused_bodies.now++ == 0 && state.refused_bodies.before == 0)
      logWarning("grains.step: RigidBody of {} refused: {}; it stands still", nameOf(world, entity), wrong);
    return true;
  });
  state.body_rows_before = state.body_rows;
}

void writeBodies(GrainsState& state, const dvec3& origin) {
  World& world = state.world;
  BodyStats* stats = state.bodies.empty() && state.body_rows.empty() ? nullptr : &world.singleton<BodyStats>();
  if (stats == nullptr) return;
  stats->bodies = static_cast<uint32_t>(state.body_rows.size());
  stats->asleep = 0;
  stats->contacts = state.solver.rigids().contactCount();
  stats->solved = state.solver.rigids().solved();
  uint64_t lost = 0;
  for (size_t k = 0; k < state.body_rows.size(); ++k) {
    const RigidRow &row = state.body_rows[k], &before = state.body_rows_before[k];
    const Entity entity = state.body_entities[k];
    stats->asleep += row.asleep;
    if (row.position != before.position || row.rotation != before.rotation) {
      Transform& transform = *world.find<Transform>(entity);
      transform.position = origin + row.position;
      transform.rotation = row.rotation;
    }
    if (row.velocity != before.velocity || row.spin != before.spin || row.asleep != before.asleep) {
      RigidBody& body = *world.find<RigidBody>(entity);
      body.velocity = row.velocity;
      body.spin = row.spin;
      body.asleep = row.asleep;
    }
    if (row.freedom == Freedom::Slider) {
      const float travel = static_cast<float>(glm::dot(dvec3(row.line), row.position - row.pivot));
      if (world.peek<BodySlider>(entity)->travel != travel) world.find<BodySlider>(entity)->travel = travel;
    }
    if (!row.lost) continue;
    world.destroy(entity);
    ++lost;
  }
  if (lost > 0) grainField(world).lost += lost;
}

}  // namespace scree::grains
