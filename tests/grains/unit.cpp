// Laws of one and two grains, against closed forms.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/grains/field.h"
#include "tests/support/law_plot.h"

namespace scree::grains::test {
namespace {

constexpr double kG = 9.81;

TEST(OneGrain, FallsOnAParabola) {
  Field field;
  field.add({1, 100, -2}, 0.05f, {}, {3, 2, -1});
  field.step(120);
  const double t = 2;
  EXPECT_NEAR(field.grain[0].position.y, 100 + 2 * t - 0.5 * kG * t * t, 1e-3);
  EXPECT_NEAR(field.grain[0].position.x, 1 + 3 * t, 1e-4);
  EXPECT_NEAR(field.velocity[0].linear.y, 2 - kG * t, 1e-4);
}

TEST(OneGrain, FallTimeIsExact) {
  // From rest at height H above the floor: at sqrt(2 H / g) it must be there, to 1e-4 s.
  std::vector<Point> measured, law;
  for (const auto& [passes, height] :
       {std::pair{1, 5.0}, {4, 0.5}, {4, 1.0}, {4, 2.0}, {4, 5.0}, {4, 10.0}}) {
    Field field;
    field.parameters.passes = passes;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
    field.add({0, static_cast<float>(height) + 0.05f, 0}, 0.05f);
    const double due = std::sqrt(2 * height / kG);
    const int before = static_cast<int>(due * 60);
    field.step(before);
    const double left = field.grain[0].position.y - 0.05;
    const double speed = -field.velocity[0].linear.y;
    const double rest = (std::sqrt(speed * speed + 2 * kG * left) - speed) / kG;
    EXPECT_NEAR(before / 60.0 + rest, due, 1e-4);
    if (passes == 4) {
      measured.push_back({height, before / 60.0 + rest});
    }
    field.step(60);
    EXPECT_NEAR(field.grain[0].position.y, 0.05, 1e-4);
    EXPECT_LT(std::abs(field.velocity[0].linear.y), 1e-3);
  }
  for (double height = 0.2; height <= 10.2; height += 0.1) law.push_back({height, std::sqrt(2 * height / kG)});
  plotLaw({.name = "fall",
           .title = "Free fall",
           .x = "height, m",
           .y = "time of the fall, s",
           .measured = measured,
           .law = law,
           .tolerance = 1e-4});
}

TEST(OneGrain, BouncesToTheSquareOfTheRestitution) {
  std::vector<Point> measured, law;
  for (const float e : {0.3f, 0.5f, 0.8f, 1.0f}) {
    Field field;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0, e);
    const double height = 1.2345;
    field.add({0, static_cast<float>(height) + 0.05f, 0}, 0.05f, {1000, 0, 0, e});
    double peak = 0;
    bool down = false;
    for (int k = 0; k < 240; ++k) {
      field.step();
      const double v = field.velocity[0].linear.y;
      if (v > 0) {  // the height that this upward speed reaches, so that ticks do not matter
        peak = std::max(peak, field.grain[0].position.y - 0.05 + v * v / (2 * kG));
        down = true;
      } else if (down) {
        break;
      }
    }
    const double want = static_cast<double>(e) * static_cast<double>(e) * height;
    EXPECT_NEAR(peak / want, 1, 0.005) << "restitution " << e;
    measured.push_back({static_cast<double>(e), peak / height});
  }
  for (double e = 0; e <= 1; e += 0.01) law.push_back({e, e * e});
  plotLaw({.name = "bounce",
           .title = "Height of the first bounce",
           .x = "restitution",
           .y = "share of the height of the fall",
           .measured = measured,
           .law = law,
           .share = 0.005});
}

TEST(OneGrain, SlidingStopsAfterTheRightDistance) {
  // A sphere that cannot turn would need v^2 / (2 mu g); one that can goes over to rolling: it slides
  // until t = 2 v / (7 mu g), over 12 v^2 / (49 mu g), and then rolls on at 5/7 v.
  for (const float mu : {0.1f, 0.5f}) {
    Field field;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), mu);
    const double v = 3;
    field.add({0, 0.05f, 0}, 0.05f, {1000, mu, 0, 0}, {static_cast<float>(v), 0, 0});
    const double time = 2 * v / (7 * static_cast<double>(mu) * kG);
    const double way = 12 * v * v / (49 * static_cast<double>(mu) * kG);
    const int ticks = static_cast<int>(std::ceil(time * 60)) + 30;
    field.step(ticks);
    EXPECT_NEAR(field.velocity[0].linear.x, 5.0 / 7 * v, 0.002 * v) << mu;
    const double rolled = 5.0 / 7 * v * (ticks / 60.0 - time);
    EXPECT_NEAR(field.grain[0].position.x, way + rolled, 0.005 * (way + rolled)) << mu;
    // Rolling: the contact point rests.
    EXPECT_NEAR(field.spin[0].angular.z * 0.05f, -field.velocity[0].linear.x, 1e-3);
  }
}

TEST(OneGrain, RollsAndSlipsDownAnIncline) {
  const double mu = 0.5;
  std::vector<Point> measured, law;
  const auto lawOf = [&](double a) {
    return std::tan(a) <= 3.5 * mu ? 5.0 / 7 * kG * std::sin(a) : kG * (std::sin(a) - mu * std::cos(a));
  };
  for (const double degrees : {10.0, 20.0, 30.0, 40.0, 50.0, 58.0, 62.0, 65.0, 70.0, 75.0}) {
    const double a = degrees * kPi / 180;
    Field field;
    // The incline is the plane y = 0 with gravity turned, as in an inclined frame.
    field.parameters.gravity =
        vec3(static_cast<float>(kG * std::sin(a)), static_cast<float>(-kG * std::cos(a)), 0);
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
    field.add({0, 0.05f, 0}, 0.05f, {1000, 0.5f, 0, 0});
    field.step(60);
    const double acceleration = lawOf(a);
    measured.push_back({degrees, static_cast<double>(field.velocity[0].linear.x)});
    EXPECT_NEAR(field.velocity[0].linear.x / acceleration, 1, 1e-3) << degrees << " degrees";
    EXPECT_NEAR(field.grain[0].position.x / (0.5 * acceleration), 1, 2e-3) << degrees;
    EXPECT_NEAR(field.grain[0].position.y, 0.05, 2e-4) << degrees;
  }
  for (double degrees = 0; degrees <= 80; degrees += 0.5) law.push_back({degrees, lawOf(degrees * kPi / 180)});
  plotLaw({.name = "incline",
           .title = "A sphere rolls, then slips, down an incline; friction 0.5",
           .x = "incline, degrees",
           .y = "acceleration, m/s^2",
           .measured = measured,
           .law = law,
           .share = 1e-3});
}

TEST(OneGrain, TiltedPlaneIsTheSameIncline) {
  // The same with gravity down and the plane tilted by 30 degrees about z.
  const float a = static_cast<float>(kPi / 6);
  Field field;
  field.addPlane({0, 0, 0}, quat(std::cos(a / 2), 0, 0, -std::sin(a / 2)), 0.5f);
  const vec3 normal(std::sin(a), std::cos(a), 0);
  field.add(normal * 0.05f, 0.05f, {1000, 0.5f, 0, 0});
  field.step(60);
  const double v = glm::length(field.velocity[0].linear);
  EXPECT_NEAR(v / (5.0 / 7 * kG * 0.5), 1, 1e-3);
}

TEST(OneGrain, RollingFrictionStopsItWhereItShould) {
  // Pure rolling at v: the torque mu_r r m g slows it by a = mu_r g / (1 + 2/5).
  std::vector<Point> measured, law;
  const double v = 1;
  for (const double mu_r : {0.02, 0.04, 0.08, 0.12}) {
    Field field;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.8f);
    field.add({0, 0.05f, 0}, 0.05f, {1000, 0.8f, static_cast<float>(mu_r), 0},
              {static_cast<float>(v), 0, 0});
    field.spin[0].angular = {0, 0, static_cast<float>(-v / 0.05)};
    field.step(900);
    const double way = v * v / (2 * mu_r * kG / 1.4);
    EXPECT_NEAR(field.grain[0].position.x / way, 1, 2e-3) << mu_r;
    EXPECT_LT(std::abs(field.velocity[0].linear.x), 1e-4) << mu_r;
    measured.push_back({mu_r, static_cast<double>(field.grain[0].position.x)});
  }
  for (double mu_r = 0.018; mu_r < 0.13; mu_r += 0.001) law.push_back({mu_r, v * v / (2 * mu_r * kG / 1.4)});
  plotLaw({.name = "rolling",
           .title = "Rolling friction stops a sphere that rolls at 1 m/s",
           .x = "rolling friction",
           .y = "way, m",
           .measured = measured,
           .law = law,
           .share = 2e-3});
}

TEST(OneGrain, StaysOnASlopeThatRollingFrictionHolds) {
  // A ball rests on a slope while tan a < mu_r.
  const double a = 0.15;
  for (const double mu_r : {0.10, 0.20}) {
    Field field;
    field.parameters.gravity =
        vec3(static_cast<float>(kG * std::sin(a)), static_cast<float>(-kG * std::cos(a)), 0);
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.8f);
    field.add({0, 0.05f, 0}, 0.05f, {1000, 0.8f, static_cast<float>(mu_r), 0});
    field.step(120);
    if (mu_r > std::tan(a)) {
      EXPECT_LT(field.grain[0].position.x, 1e-3);
    } else {
      EXPECT_GT(field.grain[0].position.x, 0.1);
    }
  }
}

TEST(OneGrain, ConveyorCarriesIt) {
  Field field;
  Collider& belt = field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.8f);
  belt.surface_velocity = {1, 0, 0};
  field.add({0, 0.05f, 0}, 0.05f, {1000, 0.8f, 0.1f, 0});
  field.step(600);
  // Rolling friction lets it come to rest relative to the belt.
  EXPECT_NEAR(field.velocity[0].linear.x, 1, 0.02);
}

TEST(TwoGrains, CentralImpactKeepsMomentumAndRestitution) {
  for (const float e : {0.0f, 0.5f, 1.0f})
    for (const float ratio : {1.0f, 2.0f}) {
      Field field;
      field.parameters.gravity = vec3(0);
      const float density = 1000;
      field.add({0, 0, 0}, 0.05f, {density, 0, 0, e}, {2, 0, 0});
      field.add({0.5f, 0, 0}, 0.05f * ratio, {density, 0, 0, e}, {-1, 0, 0});
      const double m1 = field.mass(0), m2 = field.mass(1);
      const glm::dvec3 before = field.momentum();
      field.step(60);
      EXPECT_NEAR(glm::length(field.momentum() - before), 0, 1e-6 * glm::length(before) + 1e-7);
      const double v1 = (m1 * 2 - m2 * 1 + m2 * static_cast<double>(e) * (-1 - 2)) / (m1 + m2);
      const double v2 = v1 + 3 * static_cast<double>(e);
      EXPECT_NEAR(field.velocity[0].linear.x, v1, 0.005 * 3) << "e " << e;
      EXPECT_NEAR(field.velocity[1].linear.x, v2, 0.005 * 3) << "e " << e;
    }
}

TEST(TwoGrains, ObliqueImpactIsTheClosedForm) {
  // Equal spheres, no friction: along the line of centres at contact the velocities are exchanged
  // (e = 1), across it they stay.
  for (const double offset : {0.2, 0.5, 0.8}) {
    Field field;
    field.parameters.gravity = vec3(0);
    const float r = 0.05f;
    field.add({0, 0, 0}, r, {1000, 0, 0, 1}, {1, 0, 0});
    const double y = offset * 2 * static_cast<double>(r);
    field.add({0.4f, static_cast<float>(y), 0}, r, {1000, 0, 0, 1});
    field.step(90);
    const double sine = offset, cosine = std::sqrt(1 - offset * offset);
    EXPECT_NEAR(field.velocity[1].linear.x, cosine * cosine, 0.03) << offset;
    EXPECT_NEAR(field.velocity[1].linear.y, cosine * sine, 0.03) << offset;
    EXPECT_NEAR(field.velocity[0].linear.x, sine * sine, 0.03) << offset;
    EXPECT_NEAR(field.velocity[0].linear.y, -cosine * sine, 0.03) << offset;
  }
}

TEST(TwoGrains, PassingByDoesNotTouch) {
  // Two fast grains whose paths cross at a distance just over the sum of radii at their nearest.
  Field field;
  field.parameters.gravity = vec3(0);
  field.add({-1, 0, 0}, 0.05f, {}, {8, 0, 0});
  field.add({1, 0.1005f, 0}, 0.05f, {}, {-8, 0, 0});
  field.step(30);
  EXPECT_EQ(field.velocity[0].linear, vec3(8, 0, 0));
  EXPECT_EQ(field.velocity[1].linear, vec3(-8, 0, 0));
}

TEST(TwoGrains, FrictionTurnsThemBothTheSameWay) {
  // A grazing touch gives equal grains equal spins; all that is lost in momentum shows in spin.
  Field field;
  field.parameters.gravity = vec3(0);
  field.add({0, 0, 0}, 0.05f, {1000, 0.4f, 0, 0}, {1, 0, 0});
  field.add({0.3f, 0.07f, 0}, 0.05f, {1000, 0.4f, 0, 0});
  const glm::dvec3 angular = field.angularMomentum();
  field.step(60);
  EXPECT_GT(std::abs(field.spin[0].angular.z), 0.1f);
  EXPECT_NEAR(field.spin[0].angular.z, field.spin[1].angular.z, 1e-5);
  EXPECT_LT(glm::length(field.angularMomentum() - angular), 1e-4 * field.mass(0) * 1.0 * 0.07);
}

TEST(TwoGrains, StackStandsWithoutOverlap) {
  Field field;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
  for (int k = 0; k < 10; ++k)
    field.add({0, 0.05f + 0.1f * static_cast<float>(k), 0}, 0.05f, {1000, 0.5f, 0.05f, 0});
  field.step(300);
  for (size_t k = 0; k < 10; ++k) {
    EXPECT_NEAR(field.grain[k].position.y, 0.05 + 0.1 * static_cast<double>(k), 5e-4) << k;
    EXPECT_NEAR(field.grain[k].position.x, 0, 1e-4) << k;
  }
  EXPECT_LT(field.deepestOverlap(), 0.01);
}

TEST(Orientation, TurnsWithTheSpin) {
  Field field;
  field.parameters.gravity = vec3(0);
  field.add({0, 0, 0}, 0.05f);
  const double rate = 2;
  field.spin[0].angular = {0, static_cast<float>(rate), 0};
  field.step(60);
  const quat q = field.orientation[0].rotation;
  EXPECT_NEAR(q.w, std::cos(rate / 2), 1e-3);
  EXPECT_NEAR(q.y, std::sin(rate / 2), 1e-3);
}

}  // namespace
}  // namespace scree::grains::test
