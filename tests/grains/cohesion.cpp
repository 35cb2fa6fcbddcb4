// Laws of cohesion: the force that parts two grains, what hangs by it, and what it does to slopes,
// impacts and columns.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/grains/wet.h"

namespace scree::grains::test {
namespace {

// Pushes the grains of x > 0 to the right and the others to the left.
void pullApart(Field& field, std::vector<Force>& forces, double newtons) {
  forces.assign(2, Force{});
  for (size_t k = 0; k < 2; ++k) {
    const float side = k == 0 ? -1.0f : 1.0f;
    forces[k].half = vec3(1000);
    forces[k].centre = {side * 1000, 0, 0};
    forces[k].low = forces[k].centre - 1000.0f;
    forces[k].high = forces[k].centre + 1000.0f;
    forces[k].acceleration = {side * static_cast<float>(newtons / field.mass(k)), 0, 0};
  }
  field.parameters.forces = forces;
}

// The least share of the law's force that parts two grains (of one cohesion each), found by bisection.
double partingForce(float left, float right, float c_left, float c_right) {
  const double law = force(std::sqrt(static_cast<double>(c_left) * static_cast<double>(c_right)),
                           static_cast<double>(left), static_cast<double>(right));
  double low = 0.5, high = 2;
  while (high - low > 1e-3) {
    const double middle = 0.5 * (low + high);
    Field field;
    field.parameters.gravity = vec3(0);
    field.add({-left, 0, 0}, left, {1000, 0.5f, 0, 0, c_left});
    field.add({right, 0, 0}, right, {1500, 0.5f, 0, 0, c_right});
    std::vector<Force> forces;
    pullApart(field, forces, law * middle);
    field.step(600);
    const bool holds = field.grain[1].position.x - field.grain[0].position.x < 1.02f * (left + right);
    (holds ? low : high) = middle;
  }
  return low;
}

TEST(Cohesion, TwoGrainsPartAtTheForceOfDerjaguin) {
  std::vector<Point> measured, law;
  for (const float ratio : {20.0f, 10.0f, 5.0f, 2.0f, 1.0f})
    for (const float c : {0.1f, 1.0f, 100.0f}) {
      const double share = partingForce(kRadius, kRadius / ratio, c, 4 * c);
      EXPECT_NEAR(share, 1, 0.01) << "ratio of radii " << ratio << ", cohesion " << c;
      if (c == 1) {
        const double r = static_cast<double>(kRadius), r2 = r / static_cast<double>(ratio);
        measured.push_back({r2, share * force(2, r, r2)});
      }
    }
  for (double r2 = 0.002; r2 <= 0.051; r2 += 0.001)
    law.push_back({r2, force(2, static_cast<double>(kRadius), r2)});
  plotLaw({.name = "cohesion_force",
           .title = "Force that parts two grains, one of 0.05 m; 2 N/m",
           .x = "radius of the other, m",
           .y = "force, N (2 pi cohesion R*)",
           .measured = measured,
           .law = law,
           .share = 0.01});
}

TEST(Cohesion, OneThatHasNoneIsNotHeld) {
  Field field;
  field.parameters.gravity = vec3(0);
  field.add({0, 0, 0}, kRadius, {1000, 0.5f, 0, 0, 100});
  field.add({2 * kRadius, 0, 0}, kRadius, {1000, 0.5f, 0, 0, 0}, {0.01f, 0, 0});
  field.step(10);
  EXPECT_EQ(field.velocity[1].linear, vec3(0.01f, 0, 0));
}

// Walls in all directions; the wall's cohesion is another one.
TEST(Cohesion, GrainHangsFromAWallWhileItIsLightEnough) {
  const float s = std::sqrt(0.5f);
  const quat turns[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {s, 0, 0, -s}, {s, 0, 0, s}};
  for (const quat& turn : turns)
    for (const double share : {0.9, 0.98, 0.995, 1.005, 1.02, 1.5}) {
      Field field;
      const vec3 normal = turn * vec3(0, 1, 0);
      field.add(normal * kRadius, kRadius, {1000, 0.5f, 0, 0, 0.5f});
      const double c = share > 1 ? 2.0 : 3.0;
      field.addPlane(vec3(0), turn, 0.5f).cohesion = static_cast<float>(c);
      const double pull = share * force(std::sqrt(0.5 * c), static_cast<double>(kRadius)) / field.mass(0);
      field.parameters.gravity = normal * static_cast<float>(pull);
      field.step(120);
      const float gap = glm::dot(field.grain[0].position, normal) - kRadius;
      if (share < 1) {
        EXPECT_NEAR(gap, 0, 1e-3f * kRadius) << share;
      } else {
        EXPECT_GT(gap, kRadius) << share;
      }
    }
}

TEST(Cohesion, GrainFallsOffACeilingThatHasNone) {
  Field field;
  field.addPlane({0, 0, 0}, {0, 1, 0, 0}, 0.5f);
  field.add({0, -kRadius, 0}, kRadius, {1000, 0.5f, 0, 0, 1000});
  field.step(60);
  EXPECT_LT(field.grain[0].position.y, -4.0f);
}

// The uppermost contact of a chain bears all but one of its grains, that with the ceiling all.
TEST(Cohesion, ChainBearsItsOwnWeight) {
  for (const int grains : {2, 5, 10})
    for (const double share : {0.97, 1.03}) {
      Field field;
      field.addPlane({0, 0, 0}, {0, 1, 0, 0}, 0.5f).cohesion = 1e6f;
      const float c = cohesionFor((grains - 1) / share);
      for (int k = 0; k < grains; ++k)
        field.add({0, -kRadius * static_cast<float>(1 + 2 * k), 0}, kRadius, {1000, 0.5f, 0, 0, c});
      for (int tick = 1; tick <= 60; ++tick) {  // its weight comes slowly
        field.parameters.gravity.y = -static_cast<float>(kG) * static_cast<float>(tick) / 60;
        field.step();
      }
      field.step(240);
      const float end = -kRadius * static_cast<float>(2 * grains - 1);
      if (share < 1) {
        EXPECT_NEAR(field.grain.back().position.y, end, 0.02f * kRadius * static_cast<float>(grains)) << grains;
      } else {
        EXPECT_LT(field.grain.back().position.y, end - kRadius) << grains;
        EXPECT_NEAR(field.grain[0].position.y, -kRadius, 1e-3f) << grains;
      }
    }
}

// The steepest slope that holds a grain of so much friction, by bisection: tan a.
double steepestSlope(float friction, float rolling_friction, double weights) {
  double low = 0, high = 0.5 * kPi;
  while (high - low > 5e-4) {
    const double a = 0.5 * (low + high);
    Field field;
    field.parameters.gravity =
        vec3(static_cast<float>(kG * std::sin(a)), static_cast<float>(-kG * std::cos(a)), 0);
    const float c = 0.5f * cohesionFor(weights);  // a plane's R* is twice that of an equal grain
    field.addPlane(vec3(0), quat(1, 0, 0, 0), friction).cohesion = c;
    field.add({0, kRadius, 0}, kRadius, {1000, friction, rolling_friction, 0, c});
    field.step(120);
    (field.velocity[0].linear.x < 5e-3f ? low : high) = a;
  }
  return std::tan(low);
}

// tan a = mu (1 + C / N), N = m g cos a: sin a - mu cos a = mu C / (m g).
double slopeLaw(double mu, double weights) {
  const double size = std::sqrt(1 + mu * mu), held = mu * weights / size;
  return held < 1 ? std::tan(std::asin(held) + std::atan(mu)) : std::numeric_limits<double>::infinity();
}

TEST(Cohesion, SlopesHoldByWhatPressesAndPulls) {
  std::vector<Point> measured, law;
  const auto degrees = [](double slope) { return std::atan(slope) * 180 / kPi; };
  for (double weights = 0; weights <= 2; weights += 0.02)
    law.push_back({weights, degrees(slopeLaw(static_cast<double>(0.3f), weights))});
  for (const double weights : {0.0, 0.5, 1.0, 1.5, 2.0}) {
    // Cannot roll, may slide; and the other way round.
    const double slides = steepestSlope(0.3f, 100, weights);
    measured.push_back({weights, degrees(slides)});
    EXPECT_NEAR(slides / slopeLaw(static_cast<double>(0.3f), weights), 1, 0.01) << weights;
    EXPECT_NEAR(steepestSlope(100, 0.2f, weights) / slopeLaw(static_cast<double>(0.2f), weights), 1, 0.01) << weights;
  }
  plotLaw({.name = "cohesion_slope",
           .title = "Steepest slope that a grain of friction 0.3 sticks to",
           .x = "cohesion's force, weights of the grain",
           .y = "slope, degrees",
           .measured = measured,
           .law = law,
           .share = 0.01});
}

// The impact speed up to which two grains of restitution e stay together: the rebound's energy is the
// work of parting, 1/2 m* (e v)^2 = force x reach.
TEST(Cohesion, SlowImpactsStick) {
  const double e = 0.5, r = static_cast<double>(kRadius), mass = 4.0 / 3 * kPi * r * r * r * 1000;
  std::vector<Point> measured, law;
  const auto lawOf = [&](double weights, bool wall) {
    const double reduced = wall ? r : r / 2, pull = force(static_cast<double>(cohesionFor(weights)), reduced);
    return std::sqrt(2 * pull * static_cast<double>(kReach) * reduced / (wall ? mass : mass / 2)) / e;
  };
  for (double weights = 4; weights < 600; weights *= 1.1) law.push_back({weights, lawOf(weights, false)});
  for (const bool wall : {false, true})
    for (const double weights : {5.0, 20.0, 50.0, 150.0, 500.0})
      for (const int substeps : {4, 16, 64}) {
        const float c = cohesionFor(weights);
        const double due = lawOf(weights, wall);
        double low = 0.2 * due, high = 5 * due;
        while (high / low > 1.005) {
          const double v = std::sqrt(low * high);
          Field field;
          field.parameters.gravity = vec3(0);
          field.parameters.substeps = substeps;
          const GrainMaterial material{1000, 0.5f, 0, static_cast<float>(e), c};
          if (wall) {
            field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f).cohesion = c;
          } else {
            field.add({0, -kRadius, 0}, kRadius, material);
          }
          field.add({0, kRadius + 0.02f, 0}, kRadius, material, {0, static_cast<float>(-v), 0});
          field.step(20 + static_cast<int>(60 * 0.2 / v));
          const float gap = wall ? field.grain[0].position.y - kRadius
                                 : field.grain[1].position.y - field.grain[0].position.y - 2 * kRadius;
          (gap < kReach * kRadius ? low : high) = v;
        }
        // Worst where a few substeps lead through the reach.
        EXPECT_NEAR(low / due, 1, 0.15) << (wall ? "wall, " : "grain, ") << weights << ' ' << substeps;
        if (!wall && substeps == 4) measured.push_back({weights, low});
      }
  plotLaw({.name = "cohesion_impact",
           .title = "Speed up to which two grains of restitution 0.5 stick",
           .x = "cohesion's force, weights of a grain",
           .y = "speed, m/s",
           .measured = measured,
           .law = law,
           .share = 0.15,
           .logarithmic = true});
}

// What is left of a column after its walls have gone: the mean height of its grains as a share of what it
// was, and the slope of its sides.
struct Heap {
  double height, angle;
};
double meanHeight(const Field& field) {
  double sum = 0;
  for (const Grain& g : field.grain) sum += static_cast<double>(g.position.y) / static_cast<double>(field.grain.size());
  return sum;
}
Heap collapse(double bond) {
  Field field;
  constexpr int kWide = 8, kHigh = 16;
  const float spacing = 2.04f * kRadius;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f).cohesion = cohesionFor(bond);
  for (int y = 0; y < kHigh; ++y)
    for (int z = 0; z < kWide; ++z)
      for (int x = 0; x < kWide; ++x) {
        const uint64_t k = field.grain.size();
        field.add((vec3(x, y, z) + vec3(0.5f - 0.5f * kWide, 0.5f, 0.5f - 0.5f * kWide)) * spacing +
                      (unitCube(5, k) - 0.5f) * (0.03f * kRadius),
                  kRadius * (1 - 0.1f * unit(5, k, 3)), {1000, 0.5f, 0.02f, 0, cohesionFor(bond)});
      }
  const float s = std::sqrt(0.5f), w = 0.5f * kWide * spacing;
  field.addPlane({-w, 0, 0}, quat(s, 0, 0, -s), 0);
  field.addPlane({w, 0, 0}, quat(s, 0, 0, s), 0);
  field.addPlane({0, 0, -w}, quat(s, s, 0, 0), 0);
  field.addPlane({0, 0, w}, quat(s, -s, 0, 0), 0);
  field.step(120);
  const double filled = meanHeight(field);
  field.colliders.resize(1);
  field.step(240);
  // A cone's mean height is a quarter of its height, its mean distance from the axis half its radius.
  double way = 0;
  for (const Grain& g : field.grain)
    way += static_cast<double>(std::sqrt(g.position.x * g.position.x + g.position.z * g.position.z)) /
           static_cast<double>(field.grain.size());
  const double height = meanHeight(field);
  return {height / filled, std::atan(2 * height / way) * 180 / kPi};
}

TEST(Cohesion, ColumnStandsWhereADryOneCollapses) {
  std::vector<Point> measured, slopes;
  for (const double bond : {0.0, 1.0, 3.0, 10.0, 30.0, 100.0}) {
    const Heap heap = collapse(bond);
    std::printf("Bond number %.0f: %.3f of the height, %.1f degrees\n", bond, heap.height, heap.angle);
    if (!measured.empty()) {
      EXPECT_GT(heap.angle, measured.back().y) << bond;
    }
    measured.push_back({bond, heap.angle});
    slopes.push_back({bond + 1, heap.angle});
    if (bond == 0) {
      EXPECT_LT(heap.height, 0.3);
    }
    if (bond == 100) {
      EXPECT_GT(heap.height, 0.9);
    }
  }
  plotLaw({.name = "cohesion_column",
           .title = "What is left of a column by cohesion",
           .x = "1 + force of a contact / weight of a grain",
           .y = "slope of the cone with its moments, degrees",
           .measured = slopes,
           .law = {},
           .logarithmic = true});
}

}  // namespace
}  // namespace scree::grains::test
