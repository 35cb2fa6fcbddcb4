// The rules of occlusion against long double, closed forms and brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "engine/frame/frame.h"
#include "modules/scene/scene.h"
#include "shaders/shared/occlusion.h"
#include "shaders/shared/sphere.h"
#include "tests/support/exact_sphere.h"

namespace scree::test {
namespace {

using namespace rules;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// ---- Bounds of spheres ---------------------------------------------------------------------------

TEST(SlopeBounds, AreTheTangents) {
  Random random(1);
  double worst = 0;
  for (int k = 0; k < 100000; ++k) {
    const float w = std::exp(random.between(-5, 12)), r = w * std::min(0.999f, std::exp(random.between(-14, 0)));
    const float x = w * random.sign() * std::exp(random.between(-9, 5));
    const vec2 got = slopeBounds(x, w, r, (w - r) * (w + r));
    // Angles of the tangents to the circle: an independent form.
    const long double middle = std::atan2((long double)x, (long double)w);
    const long double half = std::asin((long double)r / std::hypot((long double)x, (long double)w));
    for (const auto& [value, angle] : {std::pair{got.x, middle - half}, {got.y, middle + half}}) {
      const long double want = std::tan(angle);
      // Near 0 the angle's own rounding counts.
      const long double error = std::abs(value - want) / (std::abs(want) + 1e-12L * (1 + want * want));
      worst = std::max(worst, (double)error);
    }
  }
  std::printf("slopes: relative error at most %.2f u\n", worst * 0x1p24);
  EXPECT_LT(worst, 16 * 0x1p-24);
}

// Every pixel whose centre (or, `touched`, any point) lies in the silhouette is within the bounds, and no
// point of what is drawn is nearer than they say. Returns by how much the bounds are too wide, pixels.
struct Checked {
  bool known = false;
  double excess_px = 0;
  double excess_depth = 0;  // (depth / exact depth - 1)
};
Checked checkBounds(const ExactView& exact, const View& view, vec3 center, float radius, bool disc) {
  const ViewBlock& block = view.block;
  const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
  const float reach = disc ? kReachCenters : kReachTouched;
  const SphereBounds b = sphereBounds(v, center, radius, reach, disc);
  Checked checked{b.known};
  if (!b.known) return checked;
  EXPECT_TRUE(std::isfinite(b.depth) && b.depth > 0);
  const ExactBounds want = exact.bounds(center, radius);
  const double nearest = disc ? want.disc_nearest : want.nearest;
  EXPECT_GE((double)b.depth, block.near_m / nearest) << "depth of " << radius << " at " << glm::length(center);
  checked.excess_depth = b.depth * nearest / block.near_m - 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double side = block.size_px[axis], half = disc ? 0.5 : 0;
    // Pixels p with low <= p + 0.5 <= high, or any part in between; on the screen.
    const double first = std::max(0.0, disc ? std::ceil(want.low[axis] - half) : std::floor(want.low[axis]));
    const double last = std::min(side - 1, disc ? std::floor(want.high[axis] - half) : std::floor(want.high[axis]));
    if (first > last) continue;
    EXPECT_LE(b.first_px[axis], first);
    EXPECT_GE(b.last_px[axis], last);
    checked.excess_px = std::max({checked.excess_px, first - b.first_px[axis], b.last_px[axis] - last});
    EXPECT_GE(b.first_px[axis], 0);
    EXPECT_LT(b.last_px[axis], side);
  }
  return checked;
}

TEST(SphereBoundsRule, HoldsEverySphereInEveryView) {
  Random random(2);
  int known = 0, total = 0;
  double px = 0, depth = 0;
  for (int k = 0; k < 4000; ++k) {
    const ivec2 size(1 + (int)random.between(0, 2000), 1 + (int)random.between(0, 1200));
    const float fov = k % 4 == 0 ? std::exp(random.between(-7, 1.1f)) : random.between(0.3f, 2.0f);
    const View view = randomView(random, size, fov, std::exp(random.between(-6, 0)));
    const ExactView exact(view);
    const bool usual = fov > 0.3f && exact.tangent.x < 2 && std::min(size.x, size.y) > 32;
    for (int j = 0; j < 50; ++j) {
      const float far = view.block.near_m * std::exp(random.between(0, 12));
      const float radius = far * std::exp(random.between(-14, -0.05f));
      const vec3 center = exact.somewhere(random, far, 1.3);
      for (const bool disc : {false, true}) {
        const Checked c = checkBounds(exact, view, center, radius, disc);
        known += c.known;
        ++total;
        if (!c.known || !usual || glm::length(center) / radius > 1e4f) continue;
        px = std::max(px, c.excess_px);
        if (disc) depth = std::max(depth, c.excess_depth * glm::length(center) / radius);
      }
    }
    if (HasFailure()) return;
  }
  std::printf("bounds: %d of %d known, at most %.0f px too wide, depth too near by %.3f radii\n", known, total,
              px, depth);
  EXPECT_GT(known, total / 2);
  EXPECT_LE(px, 1);
  // 64 u for the position and as many for the depth, both times 3 at the corner of the widest view, times 1e4.
  EXPECT_LT(depth, 0.25);
}

// The bounds must not be so safe that nothing is culled: at all distances from 1e2 to 1e6 radii.
TEST(SphereBoundsRule, AreTightAtAllDistances) {
  Random random(3);
  for (const float share : {1e2f, 1e3f, 1e4f, 1e5f, 1e6f}) {
    double depth = 0, px = 0;
    for (int k = 0; k < 2000; ++k) {
      const View view = randomView(random, {1280, 720}, 0.8f, 0.01f);
      const ExactView exact(view);
      const float radius = std::exp(random.between(-5, 3)), far = radius * share;
      if (far < 0.1f) continue;
      const Checked c = checkBounds(exact, view, exact.somewhere(random, far, 0.9), radius, true);
      EXPECT_TRUE(c.known);
      depth = std::max(depth, c.excess_depth * share);
      px = std::max(px, c.excess_px);
    }
    std::printf("  D / r = %.0e: depth too near by %.4f radii\n", (double)share, depth);
    // Errors of 64 u of the distance for the position, and as many for the depth, times the corner's 1.3.
    EXPECT_LT(depth, 0.002 + 1.2e-5 * (double)share);
    EXPECT_LE(px, 1);
  }
}

TEST(SphereBoundsRule, NearPlaneAndEyeAreNeverHidden) {
  Random random(4);
  for (int k = 0; k < 20000; ++k) {
    const View view = randomView(random, {320, 200}, random.between(0.2f, 2.2f), std::exp(random.between(-6, 1)));
    const ViewBlock& block = view.block;
    const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
    const ExactView exact(view);
    const float radius = block.near_m * std::exp(random.between(-8, 8));
    const auto known = [&](vec3 c, float r) {
      return sphereBounds(v, c, r, 0, true).known || sphereBounds(v, c, r, 0.5f, false).known;
    };
    // Touches the near plane, give or take a unit in the last place of each coordinate.
    const dvec3 aside = exact.aside(random) * (double)random.between(0, 2) * (double)radius;
    const vec3 touching(aside + exact.forward * ((double)block.near_m + (double)radius));
    for (int axis = 0; axis < 3; ++axis)
      for (const float way : {-kInf, kInf}) {
        vec3 c = touching;
        c[axis] = std::nextafter(c[axis], way);
        EXPECT_FALSE(known(c, radius));
        EXPECT_FALSE(known(c, std::nextafter(radius, way)));
      }
    EXPECT_FALSE(known(touching, radius));
    // The eye in the sphere, on it, or within rounding of it.
    const vec3 direction(exact.somewhere(random, 1, 0.9));
    EXPECT_FALSE(known(direction * radius * random.between(0, 1), radius));
    for (const float f : {0.9999999f, 1.0f, 1.0000001f, 1.000001f}) EXPECT_FALSE(known(direction * radius * f, radius));
    EXPECT_FALSE(known(vec3(0), radius));
  }
}

// Where the rasteriser's own errors are not bounded well, nothing is said.
TEST(SphereBoundsRule, ClosestAndMostSlantedDiscsAreNeverHidden) {
  const View view = viewOf({0, 0, 0}, {0, 0, -1}, {320, 200}, 2.8f, 1e-4f);
  const ViewBlock& block = view.block;
  const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
  EXPECT_FALSE(sphereBounds(v, {0, 0, -1.003f}, 1, 0, true).known);
  EXPECT_FALSE(sphereBounds(v, {0, 0, -1.003f}, 1, 0, false).known);
  EXPECT_TRUE(sphereBounds(v, {0, 0, -1.005f}, 1, 0, true).known);
  // The corners of the triangle around this one are behind the eye, though the disc is not.
  EXPECT_FALSE(sphereBounds(v, {3, 0, -1.2f}, 1, 0, true).known);
  EXPECT_TRUE(sphereBounds(v, {3, 0, -1.2f}, 1, 0, false).known);
  EXPECT_TRUE(sphereBounds(v, {3, 0, -1.2f}, 0.2f, 0, true).known);
}

TEST(SphereBoundsRule, NonsenseIsNeverHidden) {
  const View view = viewOf({0, 0, 0}, {0, 0, -1}, {320, 200}, 0.9f, 0.1f);
  const ViewBlock& block = view.block;
  const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
  ASSERT_TRUE(sphereBounds(v, {0, 0, -5}, 1, 0, true).known);
  for (const bool disc : {false, true}) {
    for (const float bad : {kNan, kInf, -kInf, 3e38f, 1e20f}) {
      EXPECT_FALSE(sphereBounds(v, {bad, 0, -5}, 1, 0, disc).known);
      EXPECT_FALSE(sphereBounds(v, {0, bad, -5}, 1, 0, disc).known);
      EXPECT_FALSE(sphereBounds(v, {0, 0, bad}, 1, 0, disc).known);
      EXPECT_FALSE(sphereBounds(v, {0, 0, -5}, bad, 0, disc).known);
    }
    EXPECT_FALSE(sphereBounds(v, {0, 0, -5}, -1, 0, disc).known);
    // A point has bounds.
    const SphereBounds point = sphereBounds(v, {0, 0, -5}, 0, kReachTouched, disc);
    EXPECT_TRUE(point.known);
    EXPECT_TRUE(glm::all(glm::lessThanEqual(point.first_px, point.last_px)));
  }
}

TEST(SphereBoundsRule, WhatIsBesideTheScreenDoesNotCount) {
  const View view = viewOf({0, 0, 0}, {0, 0, -1}, {320, 200}, 0.9f, 0.1f);
  const ViewBlock& block = view.block;
  const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
  const float edge = 10 * block.tan_half_fov_x;  // at a distance of 10
  const SphereBounds half_in = sphereBounds(v, {edge, 0, -10}, 1, 0, true);
  EXPECT_EQ(half_in.last_px.x, 319);
  EXPECT_GT(half_in.first_px.x, 290);
  const SphereBounds out = sphereBounds(v, {edge + 2, 0, -10}, 1, 0, true);
  ASSERT_TRUE(out.known);
  EXPECT_LT(out.last_px.x, out.first_px.x);
  // A sphere smaller than a pixel and between their centres meets none of these, but touches one.
  const float pixel = 10 / block.pixels_at_1m;
  EXPECT_LT(sphereBounds(v, {0, 0, -10}, 0.1f * pixel, kReachCenters, true).last_px.x,
            sphereBounds(v, {0, 0, -10}, 0.1f * pixel, kReachCenters, true).first_px.x);
  const SphereBounds touched = sphereBounds(v, {0.5f * pixel, 0.5f * pixel, -10}, 0.1f * pixel, kReachTouched, true);
  EXPECT_EQ(touched.first_px, ivec2(160, 100));
  EXPECT_EQ(touched.last_px, ivec2(160, 100));
}

// ---- Pyramid -------------------------------------------------------------------------------------

TEST(PyramidFootprintRule, CoversInFourTexelsAndNoFinerLevelDoes) {
  for (int first = 0; first <= 40; ++first)
    for (int last = first; last <= 300; ++last)
      for (const auto& [a, b] : {std::pair{ivec2(first, 7), ivec2(last, 7)}, {ivec2(2, first), ivec2(3, last)}}) {
        const PyramidFootprint f = pyramidFootprint(a, b);
        ASSERT_GE(f.level, 0);
        for (int axis = 0; axis < 2; ++axis) {
          const int shift = kPyramidShift + f.level;
          EXPECT_LE(f.first[axis] << shift, a[axis]);
          EXPECT_GT((f.last[axis] + 1) << shift, b[axis]);
          EXPECT_LE(f.last[axis] - f.first[axis], 1);
        }
        if (f.level == 0) continue;
        const int finer = kPyramidShift + f.level - 1;
        EXPECT_GT(glm::max((b.x >> finer) - (a.x >> finer), (b.y >> finer) - (a.y >> finer)), 1);
      }
}

TEST(PyramidTexelsRule, NothingIsDroppedAndLevelsHalve) {
  for (int px = 1; px <= 5000; ++px) {
    const int side = pyramidSide(px);
    EXPECT_EQ(side & (side - 1), 0);
    int level = 0;
    for (;; ++level) {
      const int texels = pyramidTexels(ivec2(px, 1), level).x;
      ASSERT_GE(texels << (kPyramidShift + level), px);
      ASSERT_LT((texels - 1) << (kPyramidShift + level), px);
      ASSERT_LE(texels, std::max(1, side >> level));
      if (texels == 1) break;
    }
    EXPECT_EQ(side >> level, 1) << "the last level has one texel";
  }
}

// ---- One candidate -------------------------------------------------------------------------------

// By angles, so that nothing is shared with the rule but the geometry. The eye at the origin.
struct ExactRoom {
  long double angle;   // of the second's circle to the edge of the first's, inwards
  long double behind;  // m, beyond the tangents' ends
  bool certain;        // more than long double's rounding away from 0
  bool hides() const { return angle > 0 && behind > 0; }
};
ExactRoom exactRoom(dvec3 g0, double r0, dvec3 g1, double r1) {
  using Real = long double;
  const auto dot = [](dvec3 a, dvec3 b) { return (Real)a.x * b.x + (Real)a.y * b.y + (Real)a.z * b.z; };
  const Real d0 = std::sqrt(dot(g0, g0)), d1 = std::sqrt(dot(g1, g1));
  if (d0 <= r0 || d1 <= r1) return {-1, -1, true};
  const Real x = (Real)g0.y * g1.z - (Real)g0.z * g1.y, y = (Real)g0.z * g1.x - (Real)g0.x * g1.z,
             z = (Real)g0.x * g1.y - (Real)g0.y * g1.x;
  const Real between = std::atan2(std::sqrt(x * x + y * y + z * z), dot(g0, g1));
  ExactRoom room{std::asin(r0 / d0) - std::asin(r1 / d1) - between, d1 - r1 - std::sqrt((d0 - r0) * (d0 + r0)), true};
  room.certain = std::abs(room.angle) > 1e-16L && std::abs(room.behind) > 1e-16L * d1;
  return room;
}

// Two grains of like size near each other, and any two; half of them within a few rounding steps of the
// cone's side.
TEST(SphereHidesSphere, NeverWronglyAndAlwaysWhereThePositionsTell) {
  Random random(5);
  for (const float share : {3.0f, 1e1f, 1e2f, 1e3f, 2e3f, 4e3f, 1e4f, 1e5f, 1e6f})
    for (const bool alike : {true, false}) {
      int wrong = 0, hidden = 0, found = 0, clear = 0, missed = 0;
      for (int k = 0; k < 100000; ++k) {
        const float r0 = std::exp(random.between(-5, 2));
        const float d0 = r0 * share * std::exp(random.between(-0.5f, 0.5f));
        const dvec3 axis = random.direction();
        const vec3 g0(axis * (double)d0);
        const float r1 = r0 * (alike ? random.between(0.5f, 1) : std::exp(random.between(-3, 3)));
        const double alpha = std::asin(std::min(1.0, (double)r0 / d0));
        const double d1 = std::max((double)d0, (double)r1 * d0 / r0) + (double)r0 * std::exp(random.between(0, alike ? 4 : 8));
        const double room = alpha - std::asin(std::min(1.0, r1 / d1));
        const double off = k % 2 ? room * random.between(0, 1.2f)
                                 : room + random.between(-1, 1) * std::exp(random.between(-22, -8)) * alpha;
        const dvec3 side = glm::normalize(glm::cross(axis, random.direction()));
        const vec3 g1((axis * std::cos(off) + side * std::sin(off)) * d1);
        const ExactRoom exact = exactRoom(g0, r0, g1, r1);
        const bool got = sphereHidesSphere(g0, r0, g1, r1);
        wrong += got && exact.certain && !exact.hides();
        // Twice the error that the rule allows itself, as a length across the cone.
        const double error = 64 * 0x1p-24 * (std::abs((double)r0 - r1) + 1.2 * glm::length(dvec3(g1 - g0)));
        const bool tells = exact.hides() && exact.angle * glm::length(dvec3(g1)) > error &&
                           exact.behind > 64 * 0x1p-24 * d1;
        clear += tells;
        missed += tells && !got;
        hidden += k % 2 && exact.hides();  // by chance, not by a rounding step
        found += k % 2 && exact.hides() && got;
      }
      std::printf("one candidate, %s, D / r = %.0e: %d wrong, %d of %d found (%.2f %%)\n", alike ? "alike" : "mixed",
                  (double)share, wrong, found, hidden, 100.0 * found / std::max(hidden, 1));
      EXPECT_EQ(wrong, 0);
      EXPECT_EQ(missed, 0);
      EXPECT_GT(clear, 10000);
      EXPECT_GE(found, hidden * (!alike ? 0.0 : share <= 1e4f ? 0.99 : share <= 1e5f ? 0.97 : 0.6));
    }
}

TEST(SphereHidesSphere, EyeInsideInFrontAndNonsense) {
  EXPECT_TRUE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, -8}, 1));
  EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, -2}, 0.1f)) << "in front of it, in its cone";
  EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, 8}, 0.1f)) << "behind the eye";
  EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, -8}, 2)) << "wider than the cone";
  Random random(6);
  for (int k = 0; k < 10000; ++k) {
    const vec3 direction(random.direction());
    const float r = std::exp(random.between(-5, 5));
    const vec3 back(random.direction() * (double)(r * std::exp(random.between(0, 5))));
    for (const float f : {0.0f, 0.5f, 0.9999999f, 1.0f, 1.0000001f})
      EXPECT_FALSE(sphereHidesSphere(direction * (r * f), r, back, 0.01f * r));
    EXPECT_FALSE(sphereHidesSphere(direction * r, 0.5f * r, back, glm::length(back)));
  }
  for (const float bad : {kNan, kInf, -kInf, 3e38f}) {
    EXPECT_FALSE(sphereHidesSphere({0, 0, bad}, 1, {0, 0, -8}, 1));
    EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, bad, {0, 0, -8}, 1));
    EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, bad, -8}, 1));
    EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, -8}, bad));
  }
  EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 0, {0, 0, -8}, 0));
  EXPECT_FALSE(sphereHidesSphere({0, 0, -5}, 1, {0, 0, -8}, -1));
}

// What it says is hidden is hidden: no ray to a point of the second sphere misses the first.
TEST(SphereHidesSphere, NoRayGetsBy) {
  Random random(7);
  int hidden = 0;
  for (int k = 0; k < 20000; ++k) {
    const dvec3 axis = random.direction();
    const vec3 g0(axis * 5.0), g1(axis * (double)random.between(2, 15) + random.direction() * 0.8);
    const float r0 = random.between(0.2f, 2), r1 = random.between(0.05f, 1.5f);
    if (!sphereHidesSphere(g0, r0, g1, r1)) continue;
    ++hidden;
    for (int j = 0; j < 50; ++j) {
      const dvec3 p = dvec3(g1) + random.direction() * (double)r1;
      const double reach = glm::length(p), along = glm::dot(dvec3(g0), p) / reach;
      const double off2 = glm::dot(dvec3(g0), dvec3(g0)) - along * along;
      ASSERT_LT(off2, (double)r0 * r0 * (1 + 1e-12));
      ASSERT_LT(along - std::sqrt(std::max(0.0, (double)r0 * r0 - off2)), reach);
    }
  }
  EXPECT_GT(hidden, 1000);
}

}  // namespace
}  // namespace scree::test
