// Walking: camera-relative input, bounded turning and acceleration, gravity, no step over an edge.
#include "game/rules/creature.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "game/rules/ground.h"
#include "game/rules/heading.h"
#include "game/rules/rules.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"

namespace scree::hourglass {
namespace {

constexpr float kAcceleration = 14;    // m/s^2
constexpr float kGravity = 9.81f;      // m/s^2
constexpr float kFallSpeed = 30;       // m/s, terminal
constexpr float kWalkableNormal = 0.7f;  // y of the normal of ground that holds a foot
constexpr double kStepDown = 0.3;      // m: ground farther below than this is an edge
constexpr double kFootReach = 0.1;     // m: how far beyond its ground a foot may stand
constexpr float kLookSpeed = 2.2f;     // rad/s at full input

// The plough, seen from above: a straight blade with two wings that lead forward, so that grains
// stay before it; two capsules high, so that they do not ride over it.
struct Blade {
  float left, left_ahead, right, right_ahead;  // in half widths, and metres ahead of the blade
};
constexpr std::array<Blade, 3> kBlades{
    {{-1.0f, 0.22f, -0.62f, 0.0f}, {-0.62f, 0.0f, 0.62f, 0.0f}, {0.62f, 0.0f, 1.0f, 0.22f}}};
constexpr float kBladeRadius = 0.13f;                     // m
constexpr std::array<float, 3> kBladeHeights{0.14f, 0.36f, 0.58f};  // m
constexpr float kBladeAhead = 0.55f;                      // m before the creature's centre

float bodyRadius(const Creature& creature) { return 0.5f * creature.height_m; }

// True if there is ground below the foot, at most kStepDown lower.
bool standsOn(World& world, const dvec3& foot) {
  for (double down = 0; down <= kStepDown; down += kFootReach)
    if (isSupported(world, foot - dvec3(0, down, 0), kFootReach)) return true;
  return false;
}

// The first creature's camera heading, or +Z.
vec2 cameraHeading(World& world) {
  vec2 heading{0, 1};
  world.query<const FollowCamera>().each(
      [&](const FollowCamera& camera) { heading = camera.heading; });
  return heading;
}

void walk(World& world) {
  const auto dt = static_cast<float>(world.singleton<const Tick>().dt_s);
  const ActionState& actions = world.singleton<const ActionState>();
  const Controls& controls = world.singleton<const Controls>();
  const vec2 view = cameraHeading(world);
  vec2 wanted = rightOf(view) * actions.value(controls.move_x) + view * actions.value(controls.move_y);
  const float strength = std::min(1.0f, glm::length(wanted));

  world.query<const Creature, CreatureMotion, Transform>().each([&](const Creature& creature,
                                                                    CreatureMotion& motion,
                                                                    Transform& transform) {
    vec2 target{0, 0};
    if (strength > 0.05f) {
      const vec2 goal = normalizeOr(wanted, motion.heading);
      motion.heading = turnTowards(motion.heading, goal, creature.turn_speed_rad_s * dt);
      target = motion.heading * creature.walk_speed_m_s * strength *
               std::max(0.0f, glm::dot(motion.heading, goal));
    }
    vec2 ground_speed{motion.velocity.x, motion.velocity.z};
    const vec2 change = target - ground_speed;
    const float length = glm::length(change);
    const float most = kAcceleration * dt;
    ground_speed = length > most ? ground_speed + change * (most / length) : target;
    const float fall = std::max(motion.velocity.y - kGravity * dt, -kFallSpeed);

    const double radius = bodyRadius(creature);
    const dvec3 up{0, radius, 0};
    // Along both axes, else along one: an edge stops only the motion across it. Else it stays.
    const std::array<vec2, 3> tries{ground_speed, vec2{ground_speed.x, 0}, vec2{0, ground_speed.y}};
    SphereContact contact{transform.position + up, vec3(0, 1, 0)};
    ground_speed = {0, 0};
    for (const vec2& attempt : tries) {
      const dvec3 move = dvec3(attempt.x, fall, attempt.y) * static_cast<double>(dt);
      const SphereContact moved = pushOut(world, transform.position + up + move, radius);
      if (motion.grounded && !standsOn(world, moved.center - up)) continue;
      contact = moved;
      ground_speed = attempt;
      break;
    }
    const bool touches = contact.ground_normal.y >= kWalkableNormal;
    // Just above the ground, on a step down or over an edge's rounding, it still counts as grounded.
    motion.grounded = touches || (motion.grounded && contact.ground_normal.y == 0 &&
                                  standsOn(world, contact.center - up));
    motion.velocity = {ground_speed.x, touches ? 0.0f : fall, ground_speed.y};
    transform.position = contact.center - up;
    transform.rotation = rotationFromHeading(motion.heading);
  });

  world.query<const PloughPart, Transform>().each([&](const PloughPart& part, Transform& transform) {
    if (const Transform* creature = world.peek<Transform>(part.creature)) transform = *creature;
  });
}

// World-from-camera rotation that looks from `eye` to `point`, +Y up.
quat lookRotation(const dvec3& eye, const dvec3& point) {
  const vec3 back = glm::normalize(vec3(eye - point));
  const vec3 right = glm::normalize(glm::cross(vec3(0, 1, 0), back));
  return glm::normalize(glm::quat_cast(mat3(right, glm::cross(back, right), back)));
}

void place(FollowCamera& camera, Transform& transform, const Transform& target, double follow) {
  const dvec3 ahead(camera.heading.x, 0, camera.heading.y);
  const dvec3 goal = target.position - ahead * static_cast<double>(camera.distance_m) +
                     dvec3(0, camera.height_m, 0);
  transform.position += (goal - transform.position) * follow;
  transform.rotation =
      lookRotation(transform.position, target.position + ahead * static_cast<double>(camera.look_ahead_m));
}

void look(World& world) {
  const auto dt = static_cast<float>(world.singleton<const Tick>().dt_s);
  const float input = world.singleton<const ActionState>().value(
      world.singleton<const Controls>().look_x);
  world.query<FollowCamera, Transform>().each([&](FollowCamera& camera, Transform& transform) {
    camera.heading = turn(camera.heading, -input * kLookSpeed * dt);
    if (const Transform* target = world.peek<Transform>(camera.target))
      place(camera, transform, *target, 0.15);
  });
}

}  // namespace

void equipCreatures(World& world) {
  struct Found {
    Entity entity;
    Creature creature;
    Transform transform;
  };
  std::vector<Found> creatures;
  world.query<const Creature, const Transform, Without<CreatureMotion>>().each(
      [&](Entity entity, const Creature& creature, const Transform& transform) {
        creatures.push_back({entity, creature, transform});
      });
  for (const Found& found : creatures) {
    const vec3 ahead = found.transform.rotation * vec3(0, 0, 1);
    world.add(found.entity, CreatureMotion{.heading = normalizeOr({ahead.x, ahead.z}, {0, 1})});
    const auto addPart = [&](vec3 a, vec3 b, float radius) {
      world.spawn(found.transform, previousOf(found.transform), PloughPart{found.entity},
                  CapsuleCollider{.a = a, .b = b, .radius = radius, .friction = 0.3f});
    };
    const float half = 0.5f * found.creature.plough_width_m;
    for (const float height : kBladeHeights)
      for (const Blade& blade : kBlades)
        addPart({blade.left * half, height, kBladeAhead + blade.left_ahead},
                {blade.right * half, height, kBladeAhead + blade.right_ahead}, kBladeRadius);
    const float radius = bodyRadius(found.creature);
    addPart({0, radius, -0.35f}, {0, radius, 0.3f}, radius);
  }
}

void equipCamera(World& world) {
  Entity creature = Entity::kNone;
  world.query<With<Creature>>().each([&](Entity entity) {
    if (creature == Entity::kNone) creature = entity;
  });
  if (creature == Entity::kNone) return;
  Entity& camera = world.singleton<ActiveCamera>().entity;
  if (!world.alive(camera)) {
    Transform behind = *world.peek<Transform>(creature);
    behind.rotation = behind.rotation * quat(0, 0, 1, 0);  // a camera looks along -Z
    camera = world.spawn(behind, PreviousTransform{}, Camera{});
  }
  const FollowCamera* authored = world.peek<FollowCamera>(camera);
  FollowCamera follow = authored != nullptr ? *authored : FollowCamera();
  follow.target = creature;
  const vec3 ahead = world.peek<Transform>(camera)->rotation * vec3(0, 0, -1);
  follow.heading = normalizeOr({ahead.x, ahead.z}, {0, 1});
  Transform transform = *world.peek<Transform>(camera);
  place(follow, transform, *world.peek<Transform>(creature), 1.0);
  world.add(camera, follow);
  *world.find<Transform>(camera) = transform;
  world.add(camera, previousOf(transform));
}

void addCreature(App& app) {
  World& world = app.world();
  app.addSystem({.name = "creature.walk",
                 .phase = Phase::Simulate,
                 .needs = [q = world.query<const Creature>()] { return !q.empty(); },
                 .run = walk});
  app.addSystem({.name = "creature.look",
                 .phase = Phase::Simulate,
                 .needs = [q = world.query<const FollowCamera>()] { return !q.empty(); },
                 .run = look});
}

}  // namespace scree::hourglass
