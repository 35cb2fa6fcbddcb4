// The ellipsoid that a grain lies in, as programs draw and hide it, against double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/gtc/quaternion.hpp>

#include "shaders/shared/ellipsoid.h"
#include "shaders/shared/swarm.h"
#include "tests/support/exact_sphere.h"

namespace scree::test {
namespace {

using namespace rules;

// Half-axes from `thinnest` to 1, turned, its middle up to 0.3 off the grain's; it may reach out of the unit ball.
Ellipsoid randomEllipsoid(Random& random, float thinnest = 0.05f) {
  const quat turn(lookingAlong(random.direction(), random.between(-3, 3)));
  Ellipsoid e;
  vec4* axes[] = {&e.axis_a, &e.axis_b, &e.axis_c};
  float longest = 0;
  for (int k = 0; k < 3; ++k) {
    const float length = std::exp(random.between(std::log(thinnest), 0));
    vec3 unit(0);
    unit[k] = length;
    *axes[k] = vec4(turn * unit, 1 / (length * length));
    longest = std::max(longest, length);
  }
  const vec3 center = vec3(random.direction()) * random.between(0, 0.3f);
  e.center = vec4(center, glm::length(center) + longest);
  return e;
}

dvec3 surfacePoint(const Ellipsoid& e, const dvec3& on_ball) {
  return dvec3(vec3(e.center)) + dvec3(vec3(e.axis_a)) * on_ball.x + dvec3(vec3(e.axis_b)) * on_ball.y +
         dvec3(vec3(e.axis_c)) * on_ball.z;
}

// How far a ray passes the ellipsoid by, where that is the unit ball; below 1: it meets it.
double missOf(const Ellipsoid& e, const dvec3& eye, const dvec3& direction) {
  const auto toBallExactly = [&](const dvec3& v) {
    const auto along = [&](const vec4& axis) { return glm::dot(dvec3(vec3(axis)), v) / glm::dot(dvec3(vec3(axis)), dvec3(vec3(axis))); };
    return dvec3(along(e.axis_a), along(e.axis_b), along(e.axis_c));
  };
  const dvec3 o = toBallExactly(eye - dvec3(vec3(e.center))), d = glm::normalize(toBallExactly(direction));
  return glm::length(glm::cross(o, d));
}

TEST(Ellipsoid, TriangleHoldsEveryRayThatMeetsItAndKnowsThem) {
  Random random(1);
  double worst_edge = 0;
  for (int k = 0; k < 3000; ++k) {
    const Ellipsoid e = randomEllipsoid(random);
    const float distance = kLeastEllipsoidEye * std::exp(random.between(0.001f, 8));
    const vec3 eye = vec3(random.direction()) * distance;
    EllipsoidCorner corner[3];
    for (uint c = 0; c < 3; ++c) {
      corner[c] = ellipsoidCorner(e, eye, discCorner(c));
      // In the plane of the outer sphere's disc.
      ASSERT_NEAR(glm::dot(dvec3(corner[c].point), dvec3(eye)), 1, 2e-6 * (1 + (double)distance));
    }
    const dvec3 a(corner[0].point), b(corner[1].point), c(corner[2].point), n = glm::cross(b - a, c - a);
    for (int j = 0; j < 40; ++j) {
      const dvec3 p = surfacePoint(e, random.direction()), ray = p - dvec3(eye);
      const dvec3 at = dvec3(eye) + ray * (glm::dot(a - dvec3(eye), n) / glm::dot(ray, n));
      const dvec3 w = dvec3(glm::dot(glm::cross(c - b, at - b), n), glm::dot(glm::cross(a - c, at - c), n), glm::dot(glm::cross(b - a, at - a), n)) / glm::dot(n, n);
      ASSERT_GT(std::min({w.x, w.y, w.z}), -1e-5) << "from " << distance;
    }
    // Anywhere in the triangle the interpolated test is that of the ray.
    for (int j = 0; j < 40; ++j) {
      double u = (double)random.unit(), v = (double)random.unit();
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const dvec3 at = a * (1 - u - v) + b * u + c * v;
      const dvec3 on_disc = dvec3(corner[0].on_disc) * (1 - u - v) + dvec3(corner[1].on_disc) * u + dvec3(corner[2].on_disc) * v;
      const double miss = missOf(e, dvec3(eye), at - dvec3(eye)), drawn = std::hypot(on_disc.x, on_disc.y) / on_disc.z;
      // The disc's own edge is where rays touch: elsewhere the two measures differ, but not in sign.
      const double off = std::abs(miss - 1);
      if (off > 1e-4 * (1 + (double)distance * 1e-3)) {
        ASSERT_EQ(miss > 1, drawn > 1) << miss << " " << drawn;
      }
      if (off < 1e-2) worst_edge = std::max(worst_edge, std::abs(drawn - 1));
      if (off > 1e-3 && distance < 100) {
        ASSERT_EQ(missesEllipsoid(e, vec3(at), vec3(at) - eye), miss > 1) << miss;
      }
    }
  }
  std::printf("rays that pass by 0.99 to 1.01: at most %.3f off on the disc\n", worst_edge);
  EXPECT_LT(worst_edge, 0.05);
}

struct Seen {
  dvec2 low{1e30}, high{-1e30};
  double nearest = 1e30, nearest_in_ball = 1e30;
};
// By points all over its surface.
Seen seenOf(const ExactView& exact, const Ellipsoid& e, const dvec3& center, double radius, const glm::dquat& rotation) {
  Seen seen;
  constexpr int kPoints = 3000;
  for (int k = 0; k < kPoints; ++k) {
    // Fibonacci's spiral.
    const double z = 1 - (2 * k + 1.0) / kPoints, angle = k * 2.399963229728653, side = std::sqrt(1 - z * z);
    const dvec3 local = surfacePoint(e, {side * std::cos(angle), side * std::sin(angle), z}), p = center + rotation * local * radius;
    const double w = glm::dot(exact.forward, p);
    const dvec2 px = exact.center + exact.scale * dvec2(glm::dot(exact.right, p), glm::dot(exact.up, p)) / w;
    seen.low = glm::min(seen.low, px), seen.high = glm::max(seen.high, px);
    seen.nearest = std::min(seen.nearest, w);
    if (glm::length(local) <= 1) seen.nearest_in_ball = std::min(seen.nearest_in_ball, w);
  }
  return seen;
}

TEST(EllipsoidBounds, HoldIt) {
  Random random(2);
  int known = 0;
  constexpr int kViews = 1500;
  double loose_px = 0, loose_share = 0;
  for (int k = 0; k < kViews; ++k) {
    const ivec2 size(64 + (int)random.between(0, 1800), 64 + (int)random.between(0, 1000));
    const View view = randomView(random, size, random.between(0.3f, 1.6f), 0.01f);
    const ExactView exact(view);
    const OcclusionView v = occlusionView(view.block.clip_from_relative, view.block.size_px, view.block.near_m);
    const Ellipsoid e = randomEllipsoid(random);
    const float far = std::exp(random.between(-1, 8)), radius = far / (2 * std::exp(random.between(0, 9)));
    const vec3 center = exact.somewhere(random, far, 1.1);
    const quat turn(lookingAlong(random.direction(), random.between(-3, 3)));
    const vec4 rotation(turn.x, turn.y, turn.z, turn.w);
    const Seen seen = seenOf(exact, e, dvec3(center), (double)radius, glm::dquat(turn));
    for (const uint drawn : {kAsSolid, kAsTriangle}) {
      const bool disc = drawn == kAsTriangle;
      const SphereBounds b = ellipsoidBounds(v, center, radius, rotation, e, disc ? kReachCenters : kReachTouched, drawn);
      known += b.known;
      if (!b.known) continue;
      ASSERT_TRUE(std::isfinite(b.depth) && b.depth > 0);
      if (!disc) {
        ASSERT_GE((double)b.depth, (double)view.block.near_m / seen.nearest_in_ball);
      }
      for (int axis = 0; axis < 2; ++axis) {
        const double side = size[axis], half = disc ? 0.5 : 0;
        const double first = std::max(0.0, disc ? std::ceil(seen.low[axis] - half) : std::floor(seen.low[axis]));
        const double last = std::min(side - 1, std::floor(seen.high[axis] - half));
        if (first > last) continue;
        ASSERT_LE(b.first_px[axis], first) << k << " axis " << axis << " disc " << disc;
        ASSERT_GE(b.last_px[axis], last) << k << " axis " << axis << " disc " << disc;
        // Nearer the sphere counts; for triangles as long as their corners may come near the eye's plane.
        if (glm::dot(exact.forward, dvec3(center)) < (disc ? 30 : 9) * (double)radius) continue;
        const double extent = seen.high[axis] - seen.low[axis];
        const double loose = std::max(first - b.first_px[axis], b.last_px[axis] - last);
        // Beyond the two pixels of rounding.
        if (extent < 8) loose_px = std::max(loose_px, loose);
        loose_share = std::max(loose_share, (loose - 2) / std::max(extent, 8.0));
      }
    }
  }
  std::printf("%d of %d known; small ones too wide by %.0f px, others by %.4f of their extent\n", known, 2 * kViews, loose_px, loose_share);
  EXPECT_GT(known, kViews);
  EXPECT_LE(loose_px, 2);
  EXPECT_LT(loose_share, 0.02);
}

// What small impostors draw is not what is seen: the bounds must hold the former. From as near as 3 outer radii, in any
// picture and field of view: they may be unknown, never wrong.
TEST(EllipsoidBounds, HoldTheParallelImage) {
  Random random(5);
  int known = 0, small = 0, small_known = 0;
  float largest = 0;
  for (int k = 0; k < 400000; ++k) {
    const ivec2 size(1 + (int)random.between(0, 1800), 1 + (int)random.between(0, 1000));
    const View view = randomView(random, size, random.between(0.1f, 2.9f), 0.001f);
    const ExactView exact(view);
    const ViewBlock& block = view.block;
    const OcclusionView v = occlusionView(block.clip_from_relative, block.size_px, block.near_m);
    const Ellipsoid e = randomEllipsoid(random, k % 4 < 2 ? 0.05f : 0.9f);
    const float far = std::exp(random.between(-1, 8)), radius = far / (3 * std::exp(random.between(0, k % 2 == 0 ? 2.0f : 10.0f)));
    const vec3 center = exact.somewhere(random, far, 1.05);
    const quat turn(lookingAlong(random.direction(), random.between(-3, 3)));
    const vec4 rotation(turn.x, turn.y, turn.z, turn.w);
    const float stretch = 1 + (float)glm::dot(exact.tangent, exact.tangent);
    const bool is_small = sizePx(radius, glm::length(center), block.pixels_at_1m) <
                          std::min(kSmallPx, mostParallelPx(block.pixels_at_1m, stretch));
    const SphereBounds b = ellipsoidBounds(v, center, radius, rotation, e, kReachCenters, kAsImage);
    small += is_small, known += b.known, small_known += is_small && b.known;
    if (!b.known) continue;
    const ParallelImage image = parallelImage(block.clip_from_relative, block.size_px, center, radius, rotation, e);
    if (is_small) largest = std::max({largest, image.reach_px.x, image.reach_px.y});
    ASSERT_GE(b.depth, block.near_m / (float)glm::dot(exact.forward, dvec3(center)));
    for (int axis = 0; axis < 2; ++axis) {
      const double first = std::max(0.0, std::ceil((double)(image.ellipse_px[axis] - image.reach_px[axis]) - 0.5));
      const double last = std::min((double)size[axis] - 1, std::floor((double)(image.ellipse_px[axis] + image.reach_px[axis]) - 0.5));
      if (first > last) continue;
      ASSERT_LE(b.first_px[axis], first) << k << ": D / r " << glm::length(center) / radius;
      ASSERT_GE(b.last_px[axis], last) << k << ": D / r " << glm::length(center) / radius;
    }
  }
  std::printf("%d known; of %d that are small %d; these reach up to %.1f px\n", known, small, small_known, (double)largest);
  EXPECT_LT(largest, 60) << "points may not be as large";
  EXPECT_GT(small, 50000);
  EXPECT_GT(small_known, small * 99 / 100);
}

// The image is the place's own, to first order: that of points near the centre.
TEST(ParallelImage, MapsPlacesToPixelsAndBack) {
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const View view = randomView(random, {1280, 720}, random.between(0.3f, 1.6f), 0.01f);
    const ExactView exact(view);
    const vec3 center = exact.somewhere(random, 100, 0.9);
    const quat turn(lookingAlong(random.direction(), random.between(-3, 3)));
    const ParallelImage image = parallelImage(view.block.clip_from_relative, view.block.size_px, center, 0.1f, vec4(turn.x, turn.y, turn.z, turn.w), unitBall());
    const auto pixelOf = [&](const dvec3& p) { return exact.center + exact.scale * dvec2(glm::dot(exact.right, p), glm::dot(exact.up, p)) / glm::dot(exact.forward, p); };
    ASSERT_LT(glm::length(pixelOf(dvec3(center)) - dvec2(image.middle_px)), 1e-3);
    // A step of (1, 0) and (0, 1) pixels, and one of the unit ball's silhouette.
    const dvec3 along[2] = {dvec3(image.along_x), dvec3(image.along_y)};
    for (int axis = 0; axis < 2; ++axis) {
      const dvec2 moved = pixelOf(dvec3(center) + glm::dquat(turn) * along[axis] * (0.1 * 0.01)) - pixelOf(dvec3(center));
      dvec2 want(0);
      want[axis] = 0.01;
      ASSERT_LT(glm::length(moved - want), 1e-4);
      ASSERT_LT(std::abs(glm::dot(dvec3(center), glm::dquat(turn) * along[axis])) / glm::length(dvec3(center)) / glm::length(along[axis]), 1e-4);
    }
    const Seen seen = seenOf(exact, unitBall(), dvec3(center), 0.1, glm::dquat(turn));
    for (int axis = 0; axis < 2; ++axis)
      ASSERT_NEAR((seen.high[axis] - seen.low[axis]) / 2, (double)image.reach_px[axis], 0.01 * (double)image.reach_px[axis]);
    // Its edge is where the form is 1.
    const float x = image.reach_px.x, y = -0.5f * image.inside.y * x / image.inside.z;
    ASSERT_NEAR(image.inside.x * x * x + image.inside.y * x * y + image.inside.z * y * y, 1, 1e-3f);
  }
}

TEST(EllipsoidBounds, OfTheUnitBallAreThoseOfTheSphere) {
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const View view = randomView(random, {1280, 720}, 0.8f, 0.01f);
    const ExactView exact(view);
    const OcclusionView v = occlusionView(view.block.clip_from_relative, view.block.size_px, view.block.near_m);
    const float far = std::exp(random.between(0, 6));
    const vec3 center = exact.somewhere(random, far, 0.9);
    const float radius = far / (20 * std::exp(random.between(0, 6)));
    const SphereBounds sphere = sphereBounds(v, center, radius, kReachTouched, false);
    const SphereBounds ellipsoid = ellipsoidBounds(v, center, radius, vec4(0, 0, 0, 1), unitBall(), kReachTouched, kAsSolid);
    ASSERT_EQ(sphere.known, ellipsoid.known);
    for (int axis = 0; axis < 2; ++axis) {
      ASSERT_LE(std::abs(sphere.first_px[axis] - ellipsoid.first_px[axis]), 1);
      ASSERT_LE(std::abs(sphere.last_px[axis] - ellipsoid.last_px[axis]), 1);
    }
    ASSERT_NEAR(ellipsoid.depth / sphere.depth, 1, 1e-3);
  }
}

TEST(EllipsoidBounds, AreUnknownWhereNothingCanBeTold) {
  const View view = viewOf(dvec3(0), {0, 0, -1}, {640, 360}, 0.8f, 0.01f);
  const OcclusionView v = occlusionView(view.block.clip_from_relative, view.block.size_px, view.block.near_m);
  Random random(4);
  const Ellipsoid e = randomEllipsoid(random);
  const float nan = std::nanf("");
  for (const uint drawn : {kAsSolid, kAsTriangle, kAsImage}) {
    const auto known = [&](vec3 center, float radius) { return ellipsoidBounds(v, center, radius, vec4(0, 0, 0, 1), e, 0, drawn).known; };
    EXPECT_TRUE(known({0, 0, -50}, 1));
    EXPECT_FALSE(known({0, 0, -0.5f}, 1));
    EXPECT_FALSE(known({0, 0, 5}, 1));
    EXPECT_FALSE(known({nan, 0, -50}, 1));
    EXPECT_FALSE(known({0, 0, -50}, nan));
  }
}

}  // namespace
}  // namespace scree::test
