// Clumps as rigid bodies: mass, free rotation, impact, rolling, friction, conservation.
#include <gtest/gtest.h>

#include <random>

#include "tests/grains/clump_field.h"

namespace scree::grains::test {
namespace {

// Volume, centre and inertia about it of the union of spheres, by points, in double.
struct Solid {
  double volume = 0;
  dvec3 centre{0};
  dmat3 inertia{0};
};
Solid solidOf(std::span<const Sphere> spheres) {
  dvec3 low(1e300), high(-1e300);
  for (const Sphere& s : spheres) {
    low = glm::min(low, dvec3(s.centre) - static_cast<double>(s.radius));
    high = glm::max(high, dvec3(s.centre) + static_cast<double>(s.radius));
  }
  constexpr int kPoints = 240;
  const dvec3 step = (high - low) / static_cast<double>(kPoints);
  Solid solid;
  dmat3 second(0);
  double count = 0;
  for (int x = 0; x < kPoints; ++x)
    for (int y = 0; y < kPoints; ++y)
      for (int z = 0; z < kPoints; ++z) {
        const dvec3 p = low + step * (dvec3(x, y, z) + 0.5);
        for (const Sphere& s : spheres) {
          const dvec3 d = p - dvec3(s.centre);
          if (glm::dot(d, d) > static_cast<double>(s.radius) * static_cast<double>(s.radius)) continue;
          count += 1;
          solid.centre += p;
          second += glm::outerProduct(p, p);
          break;
        }
      }
  const double cell = step.x * step.y * step.z;
  solid.centre /= count;
  second = (second - count * glm::outerProduct(solid.centre, solid.centre)) * cell;
  solid.volume = count * cell;
  solid.inertia = dmat3(second[0][0] + second[1][1] + second[2][2]) - second;
  return solid;
}

TEST(Clump, HasTheMassOfItsUnionAndNearlyItsInertia) {
  struct Case {
    const char* name;
    double inertia;  // allowed, as a share of the true one
    double centre;   // m, with radii of about 1
  };
  for (const Case& c : {Case{"bean", 0.12, 1e-3}, Case{"bolt", 0.06, 0.055}, Case{"rod", 0.135, 1e-3},
                        Case{"triangle", 0.025, 1e-3}, Case{"tetrapod", 0.001, 1e-3}}) {
    ClumpShape shape;
    std::string_view(c.name).copy(shape.name, sizeof shape.name - 1);
    ASSERT_EQ(fault(shape), "");
    const ClumpForm form = formOf(shape);
    std::vector<Sphere> spheres;
    ClumpField field;
    for (uint32_t k = 0; k < form.count; ++k) spheres.push_back({form.arm[k], form.radius[k]});
    field.addClump(spheres, vec3(0), quat(1, 0, 0, 0), {1000});
    const Solid solid = solidOf(spheres);
    EXPECT_NEAR(field.massOf(0) / (1000 * solid.volume), 1, 1.5e-3) << c.name;
    EXPECT_LT(glm::length(solid.centre), c.centre) << c.name;
    const dmat3 mine = field.inertiaOf(0), truth = 1000.0 * solid.inertia;
    for (int axis = 0; axis < 3; ++axis) {
      const double ratio = mine[axis][axis] / truth[axis][axis];
      RecordProperty(std::string(c.name) + "_" + "xyz"[axis], std::to_string(ratio));
      std::printf("%s: inertia about %c / true %.4f, centre off by %.4f\n", c.name, "xyz"[axis], ratio,
                  glm::length(solid.centre));
      EXPECT_NEAR(ratio, 1, c.inertia) << c.name << " " << "xyz"[axis];
    }
  }
}

// Euler's equations by small steps of fourth order, from the same inertia.
struct Euler {
  dmat3 inertia, inverse;
  dquat q;
  dvec3 w;  // body
  void step(double h) {
    const auto rate = [&](const dquat& at, dvec3 spin, dquat& dq, dvec3& dw) {
      dq = 0.5 * (at * dquat(0, spin.x, spin.y, spin.z));
      dw = inverse * glm::cross(inertia * spin, spin);
    };
    dquat q1, q2, q3, q4;
    dvec3 w1, w2, w3, w4;
    rate(q, w, q1, w1);
    rate(q + (0.5 * h) * q1, w + 0.5 * h * w1, q2, w2);
    rate(q + (0.5 * h) * q2, w + 0.5 * h * w2, q3, w3);
    rate(q + h * q3, w + h * w3, q4, w4);
    q = glm::normalize(q + (h / 6) * (q1 + 2.0 * q2 + 2.0 * q3 + q4));
    w += h / 6 * (w1 + 2.0 * w2 + 2.0 * w3 + w4);
  }
};

TEST(Clump, TumblesAsEulerSays) {
  for (const vec3 spin : {vec3(3, 0.2f, 1), vec3(0.02f, 6, 0.02f), vec3(0.01f, 0.02f, 5)}) {
    ClumpField field;
    field.parameters.gravity = vec3(0);
    const size_t row = field.addClump(crooked(0.1f), vec3(0.2f, 0.1f, -0.3f), quat(1, 0, 0, 0), {1000},
                                      vec3(0.01f, 0, -0.02f), spin);
    const dmat3 inertia = field.inertiaOf(row);
    Euler euler{inertia, glm::inverse(inertia), dquat(1, 0, 0, 0), dvec3(spin)};
    const dvec3 momentum = inertia * dvec3(spin);
    const double energy = 0.5 * glm::dot(momentum, dvec3(spin));
    double off = 0, highest = 0, lowest = 1e300, lost = 0;
    for (int tick = 0; tick < 600; ++tick) {
      field.step();
      for (int k = 0; k < 100; ++k) euler.step(1.0 / 6000);
      const dmat3 now = field.inertiaOf(row);
      const dvec3 w(field.spin[row].angular), l = now * w;
      lost = std::max(lost, glm::length(l - momentum) / glm::length(momentum));
      highest = std::max(highest, 0.5 * glm::dot(l, w) / energy);
      lowest = std::min(lowest, 0.5 * glm::dot(l, w) / energy);
      const dquat q(field.orientation[row].rotation);
      off = std::max(off, 2 * std::sqrt(std::max(0.0, 1 - std::pow(glm::dot(q, euler.q), 2))));
    }
    std::printf("momentum lost %.2e, energy %.7f to %.7f, turned %.4f rad off\n", lost, lowest, highest, off);
    EXPECT_LT(lost, 1e-4);
    EXPECT_LT(highest, 1 + 2e-5);
    EXPECT_GT(lowest, 1 - 2e-5);
    EXPECT_LT(off, 0.01);  // after 50 rad
    EXPECT_LT(field.bent(), 1e-5);
  }
}

// A rod that falls and strikes a plane with one end: v' = v - J/M, w' = w + r x J / I, and the struck
// point leaves with e times its approach.
TEST(Clump, StrikesAPlaneWithOneEndAsARigidBody) {
  for (const float restitution : {0.0f, 0.5f})
    for (const float tilt : {0.2f, 0.6f, 1.2f})
      for (const int passes : {3, 12}) {
        ClumpField field;
        field.parameters.gravity = vec3(0);
        field.parameters.passes = passes;
        field.parameters.dt = 1.0f / 2400;  // while it strikes it hardly turns
        field.parameters.substeps = 1;
        field.addPlane(vec3(0), quat(1, 0, 0, 0), 0, restitution);
        const float r = 0.05f;
        const quat q = glm::angleAxis(tilt, vec3(0, 0, 1));
        const size_t row = field.addClump(rod(3 * r, r), vec3(0, 0.2f, 0), q, {1000, 0, 0, restitution},
                                          vec3(0, -2, 0));
        const dmat3 inertia = field.inertiaOf(row);
        const double m = field.massOf(row);
        const dvec3 reach = dvec3(field.grain[row].position) - field.centreOf(row) - dvec3(0, 0.05, 0);
        const double k = 1 / m + glm::dot(dvec3(0, 1, 0), glm::cross(glm::inverse(inertia) *
                                                          glm::cross(reach, dvec3(0, 1, 0)), reach));
        const double impulse = (1 + static_cast<double>(restitution)) * 2 / k;
        const dvec3 w = glm::inverse(inertia) * glm::cross(reach, dvec3(0, impulse, 0));
        const double v = -2 + impulse / m;
        // Until it has struck, and before the other end does.
        for (int tick = 0; tick < 2400 && field.spin[row].angular == vec3(0); ++tick) field.step();
        field.step(2);
        const double got = field.velocityOf(row).y, spun = field.spin[row].angular.z;
        std::printf("e %.1f tilt %.1f passes %2d: v %.4f (%.4f), w %.3f (%.3f)\n",
                    static_cast<double>(restitution), static_cast<double>(tilt), passes, got, v, spun, w.z);
        const double allowed = passes == 12 ? 0.01 : 0.12;
        EXPECT_NEAR(got, v, allowed * 2);
        EXPECT_NEAR(spun, w.z, allowed * std::abs(w.z) + 0.02);
      }
}

// Two spheres side by side roll about the axis through them: a = g sin / (1 + I / (m r^2)).
TEST(Clump, RollsDownAnIncline) {
  for (const double degrees : {8.0, 20.0}) {
    const double angle = degrees * kPi / 180;
    ClumpField field;
    field.parameters.damping = 0;
    const quat tilt = glm::angleAxis(static_cast<float>(-angle), vec3(0, 0, 1));
    field.addPlane(vec3(0), tilt, 1);
    const float r = 0.05f;
    // Its axis along z, across the slope.
    const quat q = tilt * glm::angleAxis(static_cast<float>(kPi / 2), vec3(0, 1, 0));
    const size_t row = field.addClump(rod(1.2f * r, r), tilt * vec3(0, r, 0), q, {1000, 1});
    field.step(60);
    const dvec3 along = dvec3(tilt * vec3(1, 0, 0));
    const dvec3 axis = dvec3(tilt * vec3(0, 0, 1));
    const double i = glm::dot(axis, field.inertiaOf(row) * axis);
    const double want = 9.81 * std::sin(angle) / (1 + i / (field.massOf(row) * 0.05 * 0.05));
    const double got = glm::dot(field.velocityOf(row), along) / 1.0;
    std::printf("rolls at %.5f m/s^2 (%.5f)\n", got, want);
    EXPECT_NEAR(got / want, 1, 0.005);
    EXPECT_NEAR(glm::dot(dvec3(field.spin[row].angular), axis) * 0.05, -got, 0.005 * got);
  }
}

// Lying along the slope it cannot roll: it sticks up to atan(friction), and slides beyond.
TEST(Clump, SticksAndSlidesAtTheRightAngle) {
  const auto speedAfter = [](double degrees, float friction) {
    const double angle = degrees * kPi / 180;
    ClumpField field;
    field.parameters.damping = 0;
    const quat tilt = glm::angleAxis(static_cast<float>(-angle), vec3(0, 0, 1));
    field.addPlane(vec3(0), tilt, friction);
    const float r = 0.05f;
    const size_t row = field.addClump(rod(2 * r, r), tilt * vec3(0, r, 0), tilt, {1000, friction});
    field.step(60);
    return glm::dot(field.velocityOf(row), dvec3(tilt * vec3(1, 0, 0)));
  };
  const double limit = std::atan(0.4) * 180 / kPi;
  EXPECT_LT(std::abs(speedAfter(limit - 1, 0.4f)), 1e-3);
  EXPECT_GT(speedAfter(limit + 1, 0.4f), 0.05);
  const double angle = 35 * kPi / 180;
  const double want = 9.81 * (std::sin(angle) - 0.4 * std::cos(angle));
  std::printf("slides at %.5f (%.5f)\n", speedAfter(35, 0.4f), want);
  EXPECT_NEAR(speedAfter(35, 0.4f) / want, 1, 0.01);
}

TEST(Clump, CloudConservesMomentum) {
  ClumpField field;
  field.parameters.gravity = vec3(0);
  field.parameters.substeps = 16;  // see ConservesAngularMomentumWhileNothingOverlaps
  constexpr uint64_t kSeed = 21;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y)
      for (int z = 0; z < 5; ++z) {
        const vec3 at = 0.27f * (vec3(x, y, z) - 2.0f);
        const uint64_t k = field.grain.size();
        const quat q = glm::normalize(quat(unit(kSeed, k, 1) + 0.01f, 2 * unit(kSeed, k, 2) - 1,
                                           2 * unit(kSeed, k, 3) - 1, 2 * unit(kSeed, k, 4) - 1));
        field.addClump(k % 2 == 0 ? crooked(0.05f) : rod(0.09f, 0.05f), at, q, {1000, 0.4f, 0.01f, 0.3f},
                       -3.0f * at + glm::cross(vec3(0, 2, 0), at) + 0.5f * (unitCube(kSeed, k, 5) - 0.5f),
                       4.0f * (unitCube(kSeed, k, 9) - 0.5f));
      }
  const dvec3 linear = field.momentum(), angular = field.angularMomentum();
  double scale = 0;
  for (size_t k = 0; k < field.grain.size(); ++k)
    scale += field.mass(k) * static_cast<double>(glm::length(field.velocity[k].linear));
  const double start = field.kineticEnergy();
  double last = start;
  for (int tick = 0; tick < 120; ++tick) {
    field.step();
    const double now = field.kineticEnergy();
    EXPECT_LT(now, last + 1e-4 * start) << "energy grew at tick " << tick;
    last = now;
  }
  std::printf("energy %.3f of the first; momentum %.2e, angular %.2e\n", last / start,
              glm::length(field.momentum() - linear) / scale,
              glm::length(field.angularMomentum() - angular) / glm::length(angular));
  EXPECT_TRUE(field.finite());
  EXPECT_LT(last, 0.9 * start);
  EXPECT_LT(glm::length(field.momentum() - linear) / scale, 1e-5);
  EXPECT_LT(glm::length(field.angularMomentum() - angular) / glm::length(angular), 1e-3);  // bounces move mass
  EXPECT_LT(field.bent(), 1e-5);
}

// A heavy head on a thin foot: the foot bears all, though it weighs next to nothing.
TEST(Clump, StandsOnASmallMember) {
  ClumpField field;
  field.addPlane(vec3(0), quat(1, 0, 0, 0), 0.8f);
  field.colliders[0].sensed = true;
  const float r = 0.2f;
  const std::vector<Sphere> foot{{vec3(0, r, 0), r}, {vec3(0, -0.01f, 0), 0.01f}};
  const size_t row = field.addClump(foot, vec3(0, r + 0.0195f, 0), quat(1, 0, 0, 0), {2000, 0.8f});
  field.step(20);  // it topples later, but not yet
  const double depth = 0.01 - static_cast<double>(field.grain[row + 1].position.y);
  std::printf("foot %.4f of its radius deep; floor bears %.4f of the weight\n", depth / 0.01,
              field.weightBorne() / field.totalMass());
  EXPECT_LT(depth / 0.01, 0.25);
  EXPECT_NEAR(field.weightBorne() / field.totalMass(), 1, 0.02);
}

}  // namespace
}  // namespace scree::grains::test
