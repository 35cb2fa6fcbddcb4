// Grains on meshes, hulls and grids as on the same ground made of planes and boxes.
#include <gtest/gtest.h>

#include "engine/core/parallel.h"
#include "modules/grains/surface_field.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

constexpr GrainMaterial kRough{1000, 0.5f, 0, 0};

Soup flatFloor(float half, int n) { return floorSoup(half, n, [](float, float) { return 0.0f; }); }

Soup turned(Soup soup, quat q) {
  for (vec3& corner : soup) corner = q * corner;
  return soup;
}

// Places and speeds of a grain on a plane and on its copy, for `ticks`.
struct Apart {
  double place = 0, speed = 0, spin = 0;  // worst, in radii, and of the speed
};
Apart race(Field& copy, Field& plane, int ticks) {
  Apart worst;
  for (int tick = 0; tick < ticks; ++tick) {
    copy.step();
    plane.step();
    const double r = plane.grain[0].radius, v = std::max(0.1f, glm::length(plane.velocity[0].linear));
    worst.place = std::max(worst.place, static_cast<double>(glm::length(copy.grain[0].position - plane.grain[0].position)) / r);
    worst.speed = std::max(worst.speed, static_cast<double>(glm::length(copy.velocity[0].linear - plane.velocity[0].linear)) / v);
    worst.spin = std::max(worst.spin, static_cast<double>(glm::length(copy.spin[0].angular - plane.spin[0].angular)) * r / v);
  }
  return worst;
}

// The edges inside a flat floor are not felt, whatever the size of its triangles.
TEST(MeshGround, RollsAndSlidesAsOnAPlane) {
  for (const int squares : {1, 8, 63, 200})  // of 20 m to 0.1 m
    for (const float radius : {0.02f, 0.05f, 0.3f})
      for (const float speed : {0.5f, 3.0f, 9.0f})
        for (const float friction : {0.0f, 0.5f}) {
          Field copy, plane;
          addField(copy, *makeMesh(flatFloor(10, squares), false, 0), friction);
          plane.addPlane({0, 0, 0}, quat(1, 0, 0, 0), friction);
          for (Field* field : {&copy, &plane})
            field->add({-8.03f, radius, 0.07f}, radius, {1000, friction, 0, 0}, speed * glm::normalize(vec3(1, 0, 0.23f)));
          const Apart apart = race(copy, plane, 100);
          EXPECT_LT(apart.place, 1e-3) << squares << ' ' << radius << ' ' << speed << ' ' << friction;
          EXPECT_LT(apart.speed, 1e-3) << squares << ' ' << radius << ' ' << speed << ' ' << friction;
          EXPECT_LT(apart.spin, 1e-3) << squares << ' ' << radius << ' ' << speed << ' ' << friction;
        }
}

TEST(MeshGround, InclinesBouncesAndSolidsAsPlanes) {
  const quat tilt = glm::angleAxis(0.5f, glm::normalize(vec3(0.3f, 0, 1)));
  const Soup slab = turned(boxSoup({-10, -1, -10}, {10, 0, 10}), tilt);
  const Soup sheet = turned(flatFloor(10, 50), tilt);
  std::vector<vec3> points(slab.begin(), slab.end());
  const std::shared_ptr<const DistanceField> grounds[] = {
      *makeMesh(slab, true, 0), *makeMesh(sheet, false, 0), *makeHull(points),
      *sampleDistance([&](vec3 p) { return glm::dot(tilt * vec3(0, 1, 0), p); }, vec3(-9), vec3(9), 0.5f)};
  for (const auto& ground : grounds)
    for (const float restitution : {0.0f, 0.6f}) {
      Field copy, plane;
      addField(copy, ground, 0.4f);
      plane.addPlane({0, 0, 0}, tilt, 0.4f);
      for (Field* field : {&copy, &plane})
        field->add(tilt * vec3(2, 0.4f, 0.1f), 0.05f, {1000, 0.4f, 0, restitution});
      const Apart apart = race(copy, plane, 120);
      EXPECT_LT(apart.place, 5e-3) << restitution;
      EXPECT_LT(apart.speed, 5e-3) << restitution;
    }
}

// A grain in a groove, and in a corner, leans on both sides: as between planes.
TEST(MeshGround, GroovesAndCornersHoldFromAllSides) {
  for (const float angle : {0.3f, 0.8f, 1.2f}) {
    const quat left = glm::angleAxis(angle, vec3(0, 0, 1)), right = glm::angleAxis(-angle, vec3(0, 0, 1));
    Soup soup;
    const float c = 2 * std::cos(angle), s = 2 * std::sin(angle);
    for (int k = -8; k < 8; ++k) {
      const float z0 = 0.25f * static_cast<float>(k), z1 = z0 + 0.25f;
      addQuad(soup, {0, 0, z0}, {0, 0, z1}, {c, s, z1}, {c, s, z0});
      addQuad(soup, {-c, s, z0}, {-c, s, z1}, {0, 0, z1}, {0, 0, z0});
    }
    Field copy, planes;
    addField(copy, *makeMesh(soup, false, 0), 0.3f);
    planes.addPlane({0, 0, 0}, left, 0.3f);
    planes.addPlane({0, 0, 0}, right, 0.3f);
    for (Field* field : {&copy, &planes})
      field->add({0.03f, 0.3f, -1}, 0.05f, {1000, 0.3f, 0, 0}, {0, 0, 0.8f});
    const Apart apart = race(copy, planes, 150);
    EXPECT_LT(apart.place, 0.02) << angle;
    if (angle < 0.5f) continue;  // rolls to and fro for long
    EXPECT_NEAR(copy.grain[0].position.x, 0, 1e-3) << angle;
    EXPECT_NEAR(copy.grain[0].position.y, 0.05f / std::cos(angle), 1e-3) << angle;
    EXPECT_LT(std::abs(copy.velocity[0].linear.x) + std::abs(copy.velocity[0].linear.y), 1e-3) << angle;
  }
  Field box;
  const Soup room = boxSoup(vec3(-1), vec3(1));
  addField(box, *makeMesh(room, false, 0), 0.3f);
  box.parameters.gravity = {-5, -6, -4};
  box.add({0.3f, 0.2f, 0.1f}, 0.1f, kRough);
  box.step(240);
  EXPECT_LT(glm::length(box.grain[0].position - vec3(-0.9f)), 1e-3f);
  EXPECT_LT(glm::length(box.velocity[0].linear), 1e-3f);
}

// Rolling into a ramp and a wall of one mesh.
TEST(MeshGround, ConcaveEdgesAreMetLikeSeparatePlanes) {
  for (const float speed : {1.0f, 4.0f, 9.0f}) {
    const float angle = 0.4f, c = 3 * std::cos(angle), s = 3 * std::sin(angle);
    Soup soup;
    addQuad(soup, {-3, 0, -1}, {-3, 0, 1}, {0, 0, 1}, {0, 0, -1});
    addQuad(soup, {0, 0, -1}, {0, 0, 1}, {c, s, 1}, {c, s, -1});
    Field copy, planes;
    addField(copy, *makeMesh(soup, false, 0), 0.5f);
    planes.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
    planes.addPlane({0, 0, 0}, glm::angleAxis(angle, vec3(0, 0, 1)), 0.5f);
    for (Field* field : {&copy, &planes}) field->add({-1, 0.05f, 0.1f}, 0.05f, kRough, {speed, 0, 0});
    const Apart apart = race(copy, planes, speed > 5 ? 24 : 90);  // the ramp ends
    EXPECT_LT(apart.place, 0.15) << speed;
  }
}

TEST(MeshGround, APileInABowlWeighsWhatItWeighs) {
  // On a mesh, and on the grid of the same solid: the load is the weight of all.
  const Soup bowl = floorSoup(1.5f, 40, [](float x, float z) { return 0.4f * (x * x + z * z); });
  for (const bool grid : {false, true}) {
    Field field;
    Collider& ground = addField(
        field, grid ? *sampleDistance([](vec3 p) {
                        const float y = 0.4f * (p.x * p.x + p.z * p.z);
                        return (p.y - y) / std::sqrt(1 + 0.64f * (p.x * p.x + p.z * p.z));
                      }, vec3(-1.5f, -0.5f, -1.5f), vec3(1.5f), 0.05f)
                    : *makeMesh(bowl, false, 0), 0.5f);
    ground.sensed = true;
    double weight = 0;
    for (int k = 0; k < 216; ++k) {
      const vec3 at(0.11f * static_cast<float>(k % 6) - 0.3f, 0.5f + 0.11f * static_cast<float>(k / 36),
                    0.11f * static_cast<float>(k / 6 % 6) - 0.3f);
      weight += field.mass(field.add(at, 0.05f, kRough)) * 9.81;
    }
    field.step(300);
    double load = 0;
    constexpr int kMean = 60;
    for (int k = 0; k < kMean; ++k) {
      field.step();
      load -= field.colliders[0].load.y * 60 / kMean;
    }
    EXPECT_NEAR(load / weight, 1, 2e-3) << grid;
    EXPECT_LT(field.deepestOverlap(), 0.05) << grid;
    EXPECT_LT(field.kineticEnergy() / weight, 1e-5) << grid;
    const double r = 0.05;
    for (const Grain& grain : field.grain) {
      EXPECT_GT(bruteDistance(bowl, grain.position), (grid ? 0.9 : 0.98) * r);
    }
  }
}

// Many shapes, some of which move: the same bits for any thread count and any order of rows.
TEST(MeshGround, SameBitsForThreadsAndRows) {
  const auto run = [](int threads, bool reversed) {
    setThreadCount(threads);
    Field field;
    addField(field, *makeMesh(floorSoup(2, 30, [](float x, float z) { return 0.1f * std::sin(5 * x) * std::cos(4 * z); }),
                              false, 0), 0.5f);
    addField(field, *makeHull(bumpySoup(2, 3, 0.3f)), 0.4f).position0 = {0.5f, 0.4f, 0};
    addField(field, *bakeMesh(bumpySoup(2, 4, 0.3f), 16), 0.4f).position0 = {-0.6f, 0.4f, 0.2f};
    addField(field, *makeMesh(bumpySoup(2, 5, 0.25f), true, 0), 0.4f).position0 = {0, 0.4f, -0.7f};
    for (size_t k = 1; k < 4; ++k) field.colliders[k].position1 = field.colliders[k].position0;
    for (int k = 0; k < 1500; ++k) {
      const int j = reversed ? 1499 - k : k;
      field.add(vec3(0.13f * static_cast<float>(j % 10), 0.9f + 0.13f * static_cast<float>(j / 100),
                     0.13f * static_cast<float>(j / 10 % 10)) - vec3(0.6f, 0, 0.6f),
                0.05f, {1000, 0.4f, 0.01f, 0.1f});
      field.entity.back().index = static_cast<uint32_t>(j);
    }
    for (int tick = 0; tick < 80; ++tick) {
      Collider& moving = field.colliders[3];
      moving.position0 = moving.position1;
      moving.rotation0 = moving.rotation1;
      moving.position1 += vec3(0.004f, 0.001f, 0.003f);
      moving.rotation1 = glm::normalize(moving.rotation1 * quat(0.9995f, 0.01f, 0.02f, 0));
      field.step();
    }
    setThreadCount(0);
    EXPECT_TRUE(field.finite());
    return field.hash();
  };
  const uint64_t one = run(1, false);
  EXPECT_EQ(run(2, false), one);
  EXPECT_EQ(run(4, false), one);
  EXPECT_EQ(run(2, true), one);
}

}  // namespace
}  // namespace scree::grains::test
