// Mass, centre and moments of the shapes of bodies against closed forms and sums over a fine lattice.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>
#include <vector>

#include "modules/grains/rigid_form.h"
#include "modules/grains/surface_field.h"
#include "tests/grains/meshes.h"

namespace scree::grains {
namespace {

// Of lattice points inside the collider.
RigidForm byLattice(const Collider& collider, dvec3 low, dvec3 high, int cells) {
  const PosedCollider posed = poseCollider(collider, 0, 0, 0);
  const dvec3 step = (high - low) / static_cast<double>(cells);
  RigidForm sum;
  glm::dmat3 second(0.0);
  for (int x = 0; x < cells; ++x)
    for (int y = 0; y < cells; ++y)
      for (int z = 0; z < cells; ++z) {
        const dvec3 p = low + step * (dvec3(x, y, z) + 0.5);
        if (nearestSurface(posed, vec3(p)).distance > 0) continue;
        sum.volume += 1;
        sum.centre += p;
        second += glm::dmat3(p * p.x, p * p.y, p * p.z);
      }
  sum.centre /= sum.volume;
  second -= glm::dmat3(sum.centre * sum.centre.x, sum.centre * sum.centre.y, sum.centre * sum.centre.z) * sum.volume;
  const double trace = second[0][0] + second[1][1] + second[2][2], cell = step.x * step.y * step.z;
  sum.inertia = (glm::dmat3(trace) - second) * cell;
  sum.volume *= cell;
  return sum;
}

void expectLike(const RigidForm& a, const RigidForm& b, double tolerance, double size) {
  EXPECT_NEAR(a.volume / b.volume, 1, tolerance);
  EXPECT_LT(glm::length(a.centre - b.centre), tolerance * size);
  const double most = b.inertia[0][0] + b.inertia[1][1] + b.inertia[2][2];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(a.inertia[i][j] / most, b.inertia[i][j] / most, tolerance) << i << j;
}

Collider box(vec3 half) {
  Collider c;
  c.shape = Shape::Box;
  c.half_extent = half;
  return c;
}
Collider of(std::shared_ptr<const DistanceField> field) {
  Collider c;
  c.shape = Shape::Field;
  c.field = std::move(field);
  return c;
}

TEST(BodyForm, BoxByFormulaAndByTriangles) {
  const vec3 half(0.1f, 0.25f, 0.4f), middle(3, -2, 1);
  const RigidForm exact = formOf(box(half));
  const double x = half.x, y = half.y, z = half.z, volume = 8 * x * y * z;
  EXPECT_NEAR(exact.volume, volume, 1e-9);
  EXPECT_NEAR(exact.inertia[0][0], volume / 3 * (y * y + z * z), 1e-9);
  EXPECT_NEAR(exact.inertia[1][1], volume / 3 * (x * x + z * z), 1e-9);
  const std::vector<vec3> soup = test::boxSoup(middle - half, middle + half);
  RigidForm shifted = exact;
  shifted.centre = dvec3(middle);
  for (const RigidForm& made : {formOf(of(*makeMesh(soup, true, 0))), formOf(of(*makeHull(soup)))}) {
    expectLike(made, shifted, 1e-5, 1);
    EXPECT_EQ(made.point.size(), 8u);
    EXPECT_EQ(made.edge.size(), 12u);
  }
}

TEST(BodyForm, CapsuleAgainstALattice) {
  Collider capsule;
  capsule.shape = Shape::Capsule;
  capsule.a = {-0.2f, 0.1f, 0};
  capsule.b = {0.3f, 0.3f, 0.2f};
  capsule.radius = 0.15f;
  expectLike(formOf(capsule), byLattice(capsule, dvec3(-0.5), dvec3(0.6), 120), 2e-3, 0.6);
}

TEST(BodyForm, FieldAgainstTheBall) {
  const vec3 centre(0.1f, -0.2f, 0.3f);
  const float radius = 0.5f;
  auto field = sampleDistance([&](vec3 p) { return glm::length(p - centre) - radius; }, centre - 0.6f,
                              centre + 0.6f, 0.02f);
  ASSERT_TRUE(field.ok());
  const RigidForm made = formOf(of(*field));
  RigidForm ball;
  ball.volume = 4.0 / 3 * 3.14159265358979 * 0.125;
  ball.centre = dvec3(centre);
  ball.inertia = glm::dmat3(0.4 * ball.volume * 0.25);
  expectLike(made, ball, 2e-3, 0.5);
  EXPECT_GT(made.point.size(), 50u);
  for (const vec3 p : made.point) EXPECT_NEAR(glm::length(p - centre), radius, 0.005f);
}

}  // namespace
}  // namespace scree::grains
