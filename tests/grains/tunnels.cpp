// Nothing goes through what is thin: walls and sheets in the way of fast grains, and fast blades.
#include <gtest/gtest.h>

#include "modules/grains/surface_field.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

constexpr float kFast = 50;  // m/s
constexpr float kRadii[] = {0.01f, 0.02f, 0.05f, 0.1f};
constexpr float kThicknesses[] = {0.001f, 0.003f, 0.01f};

enum class Wall { Box, Sheet, Solid, Hull };
constexpr Wall kWalls[] = {Wall::Box, Wall::Sheet, Wall::Solid, Wall::Hull};
const char* nameOf(Wall wall) {
  return std::array{"box", "sheet", "solid mesh", "hull"}[static_cast<size_t>(wall)];
}

// A plate around the origin.
Collider& addPlate(Field& field, Wall wall, vec3 half_extent, float friction) {
  if (wall == Wall::Box) return field.addBox({0, 0, 0}, half_extent, friction);
  const vec3 h = half_extent;
  const Soup box = boxSoup(-h, h);
  Soup sheet;
  addQuad(sheet, {0, -h.y, -h.z}, {0, h.y, -h.z}, {0, h.y, h.z}, {0, -h.y, h.z});
  return addField(field, wall == Wall::Sheet   ? *makeMesh(sheet, false, 2 * h.x)
                         : wall == Wall::Solid ? *makeMesh(box, true, 0)
                                               : *makeHull(box), friction);
}

quat yTo(vec3 n) {
  const vec3 half = glm::normalize(n + vec3(0, 1, 0));
  return n.y < -0.999f ? quat(0, 1, 0, 0) : quat(half.y, half.z, 0, -half.x);
}

// Fast grains among slow ones, so that no mean motion helps.
TEST(Tunnels, NoneThroughAThinWall) {
  for (const Wall wall : kWalls)
    for (const float thickness : kThicknesses)
      for (const float radius : kRadii) {
        Field field;
        field.parameters.gravity = vec3(0);
        addPlate(field, wall, {0.5f * thickness, 5, 5}, 0.3f);
        const uint64_t seed = 100 + static_cast<uint64_t>(1000 * thickness);
        for (uint64_t k = 0; k < 60; ++k) {
          const float angle = unit(seed, k, 1) - 0.5f, across = unit(seed, k, 2) - 0.5f;
          field.add({-0.3f - 2 * unit(seed, k, 3), 0.15f * static_cast<float>(k) - 4.4f, 0}, radius,
                    {1000, 0.3f, 0, k % 3 == 0 ? 0.9f : 0.0f},
                    kFast * glm::normalize(vec3(1, angle, across)));
        }
        for (uint64_t k = 0; k < 60; ++k) field.add({-3, 0.15f * static_cast<float>(k) - 4.4f, 1}, radius);
        int wrong = 0;
        for (int tick = 0; tick < 15; ++tick) {
          field.step();
          for (const Grain& grain : field.grain)
            wrong += grain.position.x > 0 && std::abs(grain.position.y) < 4.8f && std::abs(grain.position.z) < 4.8f;
        }
        EXPECT_EQ(wrong, 0) << nameOf(wall) << ' ' << thickness << " m thick, radius " << radius;
        EXPECT_TRUE(field.finite());
      }
}

// A grain at rest before a wall is hit from behind: within one substep it would be beyond it.
TEST(Tunnels, NoneThroughAWallByABlow) {
  for (const Wall wall : kWalls)
    for (const float radius : kRadii)
      for (uint64_t k = 0; k < 20; ++k) {
        Field field;
        field.parameters.gravity = vec3(0);
        addPlate(field, wall, {0.0005f, 5, 5}, 0.3f);
        const float gap = (1.05f + 2 * unit(7, k, 1)) * radius;
        field.add({-gap, 0, 0}, radius, {1000, 0.3f, 0, 1});
        field.add({-gap - 2 * radius - 0.02f - 0.2f * unit(7, k, 2), 0.3f * radius, 0}, radius, {50000, 0.3f, 0, 1},
                  {kFast, 0, 0});
        for (int j = 0; j < 20; ++j) field.add({-30, static_cast<float>(j), 0}, radius);
        for (int tick = 0; tick < 6; ++tick) {
          field.step();
          ASSERT_LT(field.grain[0].position.x, 0) << nameOf(wall) << ", radius " << radius << ", case " << k;
          ASSERT_LT(field.grain[1].position.x, 0) << nameOf(wall) << ", radius " << radius << ", case " << k;
        }
      }
}

// A blade clears a channel: what was before it stays before it.
TEST(Tunnels, NoneThroughAMovingBlade) {
  for (const Wall wall : kWalls)
    for (const float thickness : kThicknesses)
      for (const float radius : kRadii) {
        Field field;
        const float s = std::sqrt(0.5f);
        field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.3f);
        field.addPlane({0, 0, -0.5f}, quat(s, s, 0, 0), 0.3f);
        field.addPlane({0, 0, 0.5f}, quat(s, -s, 0, 0), 0.3f);
        field.addPlane({0, 1, 0}, quat(0, 1, 0, 0), 0.3f);
        for (uint64_t k = 0; k < 150; ++k) {
          const vec3 at = vec3(0.25f + radius, radius, radius - 0.5f) +
                          unitCube(9, k) * vec3(2, 0.9f - 2 * radius, 1 - 2 * radius);
          // Some come towards it.
          field.add(at, radius, {1000, 0.3f, 0, k % 4 == 0 ? 0.5f : 0.0f}, {k % 5 == 0 ? -kFast : 0.0f, 0, 0});
        }
        Collider& blade = addPlate(field, wall, {0.5f * thickness, 1, 1}, 0.3f);
        // Overlaps of the start are undone first.
        blade.position0 = blade.position1 = {-1, 0.5f, 0};
        for (GrainVelocity& v : field.velocity) std::swap(v.linear.x, v.linear.y);
        field.step(5);
        for (GrainVelocity& v : field.velocity) v.linear.x -= std::abs(v.linear.y);
        float at = -1;
        int wrong = 0;
        for (int tick = 0; tick < 12; ++tick) {
          blade.position0 = {at, 0.5f, 0};
          at += kFast / 60;
          blade.position1 = {at, 0.5f, 0};
          field.step();
          for (const Grain& grain : field.grain) wrong += grain.position.x < at;
        }
        EXPECT_EQ(wrong, 0) << nameOf(wall) << ' ' << thickness << " m thick, radius " << radius;
        EXPECT_TRUE(field.finite());
      }
}

// A blade turns in a drum that it fills: each half keeps its grains.
TEST(Tunnels, NoneThroughATurningBlade) {
  for (const Wall wall : kWalls)
    for (const float drum : {0.35f, 1.0f})
      for (const float thickness : kThicknesses)
        for (const float radius : kRadii) {
          if (radius > 0.2f * drum) continue;
          Field field;
          field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.3f);
          field.addPlane({0, 0.6f, 0}, quat(0, 1, 0, 0), 0.3f);
          constexpr int kSides = 12;
          for (int k = 0; k < kSides; ++k) {
            const float a = static_cast<float>(2 * kPi * k / kSides);
            const vec3 inward(-std::cos(a), 0, -std::sin(a));
            field.addPlane(-inward * drum, yTo(inward), 0.3f);
          }
          Collider& blade = addPlate(field, wall, {0.5f * thickness, 0.5f, 1.3f * drum}, 0.3f);
          blade.position0 = blade.position1 = {0, 0.3f, 0};
          std::vector<float> side;
          for (uint64_t k = 0; k < 80; ++k) {
            const float a = static_cast<float>(kPi) * (unit(11, k, 1) - 0.5f);
            const float reach = (drum - radius) * std::sqrt(unit(11, k, 2));
            vec3 at(reach * std::cos(a), radius + (0.6f - 2 * radius) * unit(11, k, 3), reach * std::sin(a));
            at.x = std::max(at.x, 1.1f * radius);
            side.push_back(k % 2 == 0 ? 1.0f : -1.0f);
            field.add(at * vec3(side.back(), 1, 1), radius, {1000, 0.3f, 0, 0});
          }
          const auto turned = [](float a) { return quat(std::cos(a / 2), 0, std::sin(a / 2), 0); };
          const float rate = kFast / drum;  // the tip's speed
          float angle = 0;
          int wrong = 0;
          for (int tick = 0; tick < 40; ++tick) {
            blade.rotation0 = turned(angle);
            if (tick >= 10) angle += rate / 60;
            blade.rotation1 = turned(angle);
            field.step();
            for (size_t k = 0; k < side.size(); ++k) {
              const vec3 local = glm::conjugate(turned(angle)) * field.grain[k].position;
              wrong += local.x * side[k] < 0;
            }
          }
          EXPECT_EQ(wrong, 0) << nameOf(wall) << ' ' << thickness << " m thick in a drum of " << drum << ", radius "
                              << radius;
          EXPECT_TRUE(field.finite());
        }
}

}  // namespace
}  // namespace scree::grains::test
