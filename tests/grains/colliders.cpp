// Colliders: distance queries against brute force, moving shapes, seams, thin walls.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

quat rotationOf(uint64_t seed, uint64_t k) {
  const vec3 v = unitCube(seed, k) * 2.0f - 1.0f;
  return glm::normalize(quat(unit(seed, k, 3) + 0.1f, v.x, v.y, v.z));
}

// The nearest of many points of the surface, in double: an upper bound that is off by less than the
// step of the sampling.
double nearestByPoints(const Collider& c, glm::dvec3 p) {
  const glm::dquat q(c.rotation0);
  const auto distance = [&](glm::dvec3 local) {
    return glm::length(q * local + glm::dvec3(c.position0) - p);
  };
  double best = 1e9;
  constexpr int kSteps = 60;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const double a = static_cast<double>(i) / kSteps, b = static_cast<double>(j) / kSteps;
      if (c.shape == Shape::Box) {
        for (int axis = 0; axis < 3; ++axis)
          for (const double side : {-1.0, 1.0}) {
            glm::dvec3 local;
            local[axis] = side;
            local[(axis + 1) % 3] = 2 * a - 1;
            local[(axis + 2) % 3] = 2 * b - 1;
            best = std::min(best, distance(local * glm::dvec3(c.half_extent)));
          }
      } else {
        // Rings of the sphere swept along the axis: sphere points at both ends, and along it.
        const double z = 2 * a - 1, phi = 2 * kPi * b, r = std::sqrt(1 - z * z);
        const glm::dvec3 d(r * std::cos(phi), r * std::sin(phi), z);
        for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          const glm::dvec3 axis = glm::dvec3(c.a) + t * glm::dvec3(c.b - c.a);
          best = std::min(best, distance(axis + static_cast<double>(c.radius) * d));
        }
      }
    }
  return best;
}

TEST(Surface, BoxDistanceIsTheNearestPoint) {
  for (uint64_t k = 0; k < 60; ++k) {
    Collider c;
    c.shape = Shape::Box;
    c.half_extent = 0.3f + 0.7f * unitCube(1, k, 10);
    c.position0 = c.position1 = unitCube(1, k, 20) * 4.0f - 2.0f;
    c.rotation0 = c.rotation1 = rotationOf(2, k);
    const vec3 p = c.position0 + (unitCube(3, k) - 0.5f) * 5.0f;
    const SurfacePoint near = nearestSurface(poseCollider(c, 0, 0, 0), p);
    EXPECT_NEAR(std::abs(near.distance), nearestByPoints(c, glm::dvec3(p)), 0.01) << k;
    EXPECT_NEAR(glm::length(near.normal), 1, 1e-5);
    // Walking the distance along the normal ends on the surface.
    const SurfacePoint there =
        nearestSurface(poseCollider(c, 0, 0, 0), p - near.normal * near.distance);
    EXPECT_NEAR(there.distance, 0, 1e-5) << k;
    const vec3 local = glm::conjugate(c.rotation0) * (p - c.position0);
    const bool inside = std::abs(local.x) < c.half_extent.x && std::abs(local.y) < c.half_extent.y &&
                        std::abs(local.z) < c.half_extent.z;
    EXPECT_EQ(near.distance < 0, inside) << k;
  }
}

TEST(Surface, CapsuleDistanceIsTheNearestPoint) {
  for (uint64_t k = 0; k < 60; ++k) {
    Collider c;
    c.shape = Shape::Capsule;
    c.a = unitCube(4, k) - 0.5f;
    c.b = k % 5 == 0 ? c.a : unitCube(4, k, 5) - 0.5f;  // some are spheres
    c.radius = 0.2f + 0.3f * unit(4, k, 9);
    c.position0 = c.position1 = unitCube(5, k) * 4.0f - 2.0f;
    c.rotation0 = c.rotation1 = rotationOf(6, k);
    const vec3 p = c.position0 + (unitCube(7, k) - 0.5f) * 5.0f;
    const SurfacePoint near = nearestSurface(poseCollider(c, 0, 0, 0), p);
    if (near.distance > 0) {
      EXPECT_NEAR(near.distance, nearestByPoints(c, glm::dvec3(p)), 0.03) << k;
    }
    const SurfacePoint there =
        nearestSurface(poseCollider(c, 0, 0, 0), p - near.normal * near.distance);
    EXPECT_NEAR(there.distance, 0, 1e-5) << k;
  }
}

TEST(Surface, DegeneratePointsHaveANormal) {
  Collider box;
  box.shape = Shape::Box;
  box.half_extent = {0.5f, 0.5f, 0.5f};
  Collider capsule;
  capsule.shape = Shape::Capsule;
  capsule.a = {0, -1, 0};
  capsule.b = {0, 1, 0};
  capsule.radius = 0.3f;
  Collider sphere = capsule;
  sphere.a = sphere.b = vec3(0);
  for (const Collider& c : {box, capsule, sphere})
    for (const vec3 p : {vec3(0), vec3(0.5f, 0, 0), vec3(0.5f, 0.5f, 0.5f), vec3(0, 1, 0), vec3(0, 0.3f, 0)}) {
      const SurfacePoint near = nearestSurface(poseCollider(c, 0, 0, 0), p);
      EXPECT_NEAR(glm::length(near.normal), 1, 1e-5);
      EXPECT_TRUE(std::isfinite(near.distance));
    }
  EXPECT_FLOAT_EQ(nearestSurface(poseCollider(box, 0, 0, 0), vec3(0)).distance, -0.5f);
  EXPECT_FLOAT_EQ(nearestSurface(poseCollider(capsule, 0, 0, 0), vec3(0)).distance, -0.3f);
}

TEST(Motion, VelocityIsThatOfThePose) {
  // A turning, moving box: material points move as poses say, to the order of the substep.
  Collider c;
  c.shape = Shape::Box;
  c.half_extent = {1, 0.2f, 0.3f};
  c.position0 = {1, 2, 3};
  c.position1 = {1.02f, 2.01f, 2.97f};
  c.rotation0 = rotationOf(9, 1);
  c.rotation1 = glm::normalize(c.rotation0 * quat(0.9998f, 0.01f, -0.015f, 0.005f));
  const float h = 1.0f / 240;
  const vec3 local(0.7f, -0.1f, 0.2f);
  for (int s = 0; s < 4; ++s) {
    const float t0 = 0.25f * static_cast<float>(s), t1 = t0 + 0.25f;
    const PosedCollider a = poseCollider(c, t0, t1, h), b = poseCollider(c, t1, t1, 0);
    const vec3 from = a.position + a.world_from_local * local,
               to = b.position + b.world_from_local * local;
    EXPECT_LT(glm::length(velocityAt(a, from) - (to - from) / h), 0.02f * glm::length(to - from) / h);
  }
  // Bounds and motionBound hold for every point.
  const Bounds bounds = sweptBounds(c);
  for (uint64_t k = 0; k < 200; ++k) {
    const vec3 p = (unitCube(10, k) * 2.0f - 1.0f) * c.half_extent;
    vec3 first(0);
    for (const float t : {0.0f, 0.3f, 0.6f, 1.0f}) {
      const PosedCollider posed = poseCollider(c, t, t, 0);
      const vec3 w = posed.position + posed.world_from_local * p;
      if (t == 0) first = w;
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(w, bounds.min - 1e-5f)) &&
                  glm::all(glm::lessThanEqual(w, bounds.max + 1e-5f)));
      EXPECT_LE(glm::length(w - first), motionBound(c) + 1e-5f);
    }
  }
}

// A capsule that sweeps through a row of grains at game speeds: all end in front of it, none behind.
TEST(Motion, CapsulePushesWithoutTunnelling) {
  for (const float speed : {1.0f, 4.0f, 10.0f, 20.0f}) {
    Field field;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
    for (int x = 0; x < 6; ++x)
      for (int z = -4; z <= 4; ++z)
        for (int y = 0; y < 2; ++y)
          field.add({0.11f * static_cast<float>(x), 0.05f + 0.1f * static_cast<float>(y),
                     0.11f * static_cast<float>(z)}, 0.05f, {1000, 0.5f, 0, 0});
    Collider& blade = field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.3f);
    blade.shape = Shape::Capsule;
    blade.a = {0, 0.12f, -3};
    blade.b = {0, 0.12f, 3};
    blade.radius = 0.12f;
    float at = -0.5f;
    blade.position1 = {at, 0, 0};
    const int ticks = static_cast<int>(2.0f / speed * 60) + 1;
    for (int k = 0; k < ticks; ++k) {
      blade.position0 = {at, 0, 0};
      at += speed / 60;
      blade.position1 = {at, 0, 0};
      field.step();
      ASSERT_TRUE(field.finite());
      for (size_t g = 0; g < field.grain.size(); ++g) {
        const vec3 p = field.grain[g].position;
        // On the floor's level nothing may be behind the blade's axis.
        if (p.y < 0.15f) {
          ASSERT_GT(p.x, at) << "grain " << g << " tick " << k << " speed " << speed;
        }
      }
    }
    // Carried along, not exploded.
    for (size_t g = 0; g < field.grain.size(); ++g)
      EXPECT_LT(glm::length(field.velocity[g].linear), 2.5f * speed + 3);
  }
}

TEST(Motion, TurningBoxStrikesWithItsSurfaceSpeed) {
  // A paddle that turns about y strikes a grain at 0.8 m from the axis: it leaves at about w r.
  Field field;
  field.parameters.gravity = vec3(0);
  const float rate = 3;
  field.add({0.8f, 0, 0.101f}, 0.05f, {1000, 0, 0, 0});
  Collider& paddle = field.addBox({0, 0, 0}, {1, 0.3f, 0.05f}, 0);
  float angle = 0;
  const auto turned = [](float a) { return quat(std::cos(a / 2), 0, std::sin(a / 2), 0); };
  for (int k = 0; k < 3; ++k) {
    paddle.rotation0 = turned(angle);
    angle -= rate / 60;
    paddle.rotation1 = turned(angle);
    field.step();
  }
  EXPECT_NEAR(field.velocity[0].linear.z, rate * 0.8, 0.15);
}

TEST(Motion, RisingFloorLiftsAndCarries) {
  Field field;
  Collider& lift = field.addBox({0, -0.5f, 0}, {1, 0.5f, 1}, 0.9f);
  field.add({0, 0.05f, 0}, 0.05f, {1000, 0.9f, 0.05f, 0});
  float y = -0.5f, x = 0;
  for (int k = 0; k < 180; ++k) {
    lift.position0 = {x, y, 0};
    y += 0.5f / 60;
    x += 0.1f / 60;
    lift.position1 = {x, y, 0};
    field.step();
  }
  EXPECT_NEAR(field.grain[0].position.y, y + 0.55f, 2e-3);
  EXPECT_NEAR(field.velocity[0].linear.x, 0.1, 0.01);
}

TEST(Walls, NothingTunnelsThroughAThinWall) {
  for (const float speed : {5.0f, 20.0f, 50.0f})
    for (int angle = 0; angle < 4; ++angle) {
      Field field;
      field.parameters.gravity = vec3(0);
      field.addBox({0, 0, 0}, {0.005f, 5, 5}, 0.3f);  // 1 cm thick
      const float a = 0.3f * static_cast<float>(angle);
      for (int k = 0; k < 40; ++k)
        field.add({-1 - 0.013f * static_cast<float>(k), 0.2f * static_cast<float>(k) - 4, 0}, 0.02f,
                  {1000, 0.3f, 0, 0.2f}, speed * vec3(std::cos(a), 0, std::sin(a)));
      for (int tick = 0; tick < 30; ++tick) {
        field.step();
        for (size_t g = 0; g < field.grain.size(); ++g)
          if (std::abs(field.grain[g].position.z) < 4) {
            ASSERT_LT(field.grain[g].position.x, 0) << "speed " << speed << " grain " << g;
          }
      }
    }
}

TEST(Walls, SeamsBetweenBoxesAreSmooth) {
  // A ball rolls over a floor of tiles as over one slab.
  Field tiles, slab;
  for (int k = -20; k < 60; ++k)
    tiles.addBox({0.25f * static_cast<float>(k), -0.5f, 0}, {0.125f, 0.5f, 1}, 0.5f);
  slab.addBox({5, -0.5f, 0}, {10, 0.5f, 1}, 0.5f);
  for (Field* field : {&tiles, &slab}) {
    field->add({0, 0.05f, 0}, 0.05f, {1000, 0.5f, 0, 0}, {3, 0, 0});
    field->step(180);
  }
  EXPECT_NEAR(tiles.grain[0].position.x, slab.grain[0].position.x, 0.01);
  EXPECT_NEAR(tiles.grain[0].position.y, slab.grain[0].position.y, 2e-4);
  EXPECT_NEAR(tiles.velocity[0].linear.x, slab.velocity[0].linear.x, 0.01);
}

TEST(Walls, DeeplyBuriedGrainsGetOut) {
  Field field;
  field.parameters.gravity = vec3(0);
  field.addBox({0, 0, 0}, {1, 0.3f, 1}, 0.5f);
  field.add({0.1f, 0.05f, 0.1f}, 0.05f);
  field.add({0, 0, 0}, 0.05f);  // at the very centre
  field.step(120);
  EXPECT_TRUE(field.finite());
  for (const Grain& g : field.grain)
    EXPECT_GT(std::max(std::abs(g.position.y) - 0.3f, std::abs(g.position.x) - 1.0f), 0.04f);
  EXPECT_LT(field.kineticEnergy() / field.mass(0), 1e-6);  // pushed out, not shot out
}

}  // namespace
}  // namespace scree::grains::test
