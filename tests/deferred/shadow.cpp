// The shadow map's filter, bias and fit without GL.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "engine/core/random.h"
#include "modules/deferred/shadow_fit.h"

namespace scree {
namespace {

using Sphere = ShadowCasters::Sphere;

double unit(uint64_t seed, uint64_t i, uint64_t draw) { return randomUnit(seed, i, 0, draw); }
dvec3 randomDirection(uint64_t seed, uint64_t i, uint64_t draw) {
  const double z = 2 * unit(seed, i, draw) - 1, phi = 6.283185307179586 * unit(seed, i, draw + 1);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(phi), z, r * std::sin(phi)};
}
// Texels along x and y, depth.
dvec3 mapCoordinates(const rules::ShadowViewBlock& view, dvec3 relative) {
  dvec3 result(0);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r)
      result[r] += double{view.shadow_from_relative[c][r]} * (c < 3 ? relative[c] : 1.0);
  return result;
}

// ---- filter

double bilinear(const std::vector<double>& texels, double p) {
  const int i = static_cast<int>(std::floor(p));
  const double f = p - i;
  return texels[static_cast<size_t>(i)] * (1 - f) + texels[static_cast<size_t>(i) + 1] * f;
}

// Two fetches an axis are three bilinear comparisons, one texel apart.
TEST(ShadowFilter, TwoFetchesAreThreeComparisons) {
  std::vector<double> texels(16);
  for (size_t i = 0; i < texels.size(); ++i) texels[i] = unit(1, i, 0) < 0.5 ? 0 : 1;
  for (uint64_t k = 0; k < 10'000; ++k) {
    const double p = 4 + 7 * unit(2, k, 0);
    const double expected = bilinear(texels, p - 1) + bilinear(texels, p) + bilinear(texels, p + 1);
    const double base = std::floor(p);
    const rules::ShadowTaps t = rules::shadowTaps(static_cast<float>(p - base));
    const double got = t.weight0 * bilinear(texels, base + t.position0) +
                       t.weight1 * bilinear(texels, base + t.position1);
    EXPECT_NEAR(got, expected, 1e-5);
    EXPECT_NEAR(t.weight0 + t.weight1, 3, 1e-6);
  }
}

// ---- bias

// Over every plane and every position in the texel grid, no texel that the filter reads is nearer to
// the sun than the moved receiver; and the bound is tight: three quarters of it is not enough.
TEST(ShadowBias, NormalOffsetFreesPlanesOfAcne) {
  int failures_with_less = 0;
  double largest = 0;
  for (uint64_t i = 0; i < 20'000; ++i) {
    rules::ShadowViewBlock view{};
    const double texel = std::exp2(6 * unit(3, i, 0) - 8);
    view.texel_m = static_cast<float>(texel);
    // The map's axes are the world's here: x, y across, z towards the sun.
    view.axis_x = vec4(1, 0, 0, 0);
    view.axis_y = vec4(0, 1, 0, 0);
    dvec3 n = randomDirection(3, i, 1);
    n.z = std::abs(n.z) + 0.02;
    n = glm::normalize(n);
    const double offset = rules::shadowNormalOffset(vec3(n), view);
    largest = std::max(largest, offset / texel);
    const auto plane = [&](double x, double y) { return -(n.x * x + n.y * y) / n.z; };
    // Receiver at a random place of the plane; heights in m, places in texels.
    const double px = unit(3, i, 3), py = unit(3, i, 4);
    const auto lit = [&](double distance) {
      const dvec3 moved(px * texel + n.x * distance, py * texel + n.y * distance,
                        plane(px * texel, py * texel) + n.z * distance);
      const double mx = moved.x / texel, my = moved.y / texel;
      const double bx = std::floor(mx), by = std::floor(my), fx = mx - bx, fy = my - by;
      const double wx[] = {1 - fx, 1, 1, fx}, wy[] = {1 - fy, 1, 1, fy};
      double shadowed = 0;
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
          if (plane((bx + x - 1) * texel, (by + y - 1) * texel) > moved.z) shadowed += wx[x] * wy[y] / 9;
      return shadowed == 0;
    };
    EXPECT_TRUE(lit(offset)) << n.x << " " << n.y << " " << n.z;
    failures_with_less += lit(0.5 * offset) ? 0 : 1;
  }
  EXPECT_GT(failures_with_less, 1000);
  std::printf("largest offset %.2f texels\n", largest);
  EXPECT_LT(largest, 3.0);
}

TEST(ShadowBias, FacingPlanesAreHardlyMoved) {
  rules::ShadowViewBlock view{};
  view.texel_m = 0.01f;
  view.axis_x = vec4(1, 0, 0, 0);
  view.axis_y = vec4(0, 1, 0, 0);
  EXPECT_LE(rules::shadowNormalOffset(vec3(0, 0, 1), view), 0.0011f);
}

// ---- fit

std::vector<Sphere> heap(uint64_t seed, dvec3 center, int count = 200) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < count; ++i)
    spheres.push_back({center + randomDirection(seed, static_cast<uint64_t>(i), 0) * (9 * unit(seed, static_cast<uint64_t>(i), 2)),
                       static_cast<float>(0.05 + 0.5 * unit(seed, static_cast<uint64_t>(i), 3))});
  return spheres;
}

TEST(ShadowFit, ContainsEveryCasterWithABorder) {
  for (uint64_t i = 0; i < 300; ++i) {
    const dvec3 center = randomDirection(5, i, 0) * std::pow(10.0, 6 * unit(5, i, 2));
    const dvec3 camera = center + randomDirection(5, i, 3) * 20.0;
    const dvec3 sun = randomDirection(5, i, 5);
    const auto spheres = heap(i, center);
    const auto view = fitShadowView(spheres, camera, vec3(sun), 512, 150);
    ASSERT_EQ(view.enabled, 1);
    double used = 0;
    for (const Sphere& s : spheres) {
      const dvec3 c = mapCoordinates(view, s.center - camera);
      const double rx = s.radius / view.texel_m, rz = s.radius / view.to_sun.w;
      EXPECT_GT(c.x - rx, 2.9);
      EXPECT_LT(c.x + rx, 512 - 2.9);
      EXPECT_GT(c.y - rx, 2.9);
      EXPECT_LT(c.y + rx, 512 - 2.9);
      EXPECT_GT(c.z - rz, 0);
      EXPECT_LT(c.z + rz, 1);
      used = std::max({used, c.x + rx, c.y + rx});
    }
    // Texels are not wasted: steps of 2^(1/8), rounding and border.
    EXPECT_GT(used, 0.85 * 512);
  }
}

TEST(ShadowFit, TexelsStayWhereTheyAreWhileCastersMove) {
  auto spheres = heap(9, dvec3(30, 2, -7));
  const vec3 sun(glm::normalize(vec3(0.3f, 0.8f, 0.2f)));
  const dvec3 fixed(31.234, 1.5, -6.1);
  const auto first = fitShadowView(spheres, dvec3(25, 5, 0), sun, 2048, 150);
  double last_phase_x = -1;
  int changes = 0;
  for (int step = 0; step < 200; ++step) {
    spheres[0].center += dvec3(0.003, 0.001, -0.002);
    const dvec3 camera(25 + 0.01 * step, 5, 0.02 * step);
    const auto view = fitShadowView(spheres, camera, sun, 2048, 150);
    changes += view.texel_m != first.texel_m;
    if (view.texel_m != first.texel_m) continue;
    // The fixed point keeps its place within its texel.
    const double x = mapCoordinates(view, fixed - camera).x;
    const double phase = x - std::floor(x);
    if (last_phase_x >= 0) {
      EXPECT_NEAR(phase, last_phase_x, 2e-3);
    }
    last_phase_x = phase;
  }
  EXPECT_LE(changes, 100);
  EXPECT_GE(last_phase_x, 0);
}

TEST(ShadowFit, ACasterOnItsWayOutwardsChangesItOnceInAWhile) {
  auto spheres = heap(10, dvec3(0));
  spheres.push_back({dvec3(9, 1, 4), 0.05f});
  const vec3 sun(glm::normalize(vec3(0.3f, 0.8f, 0.2f)));
  ShadowFit before;
  int changes = 0;
  double to_edge = 0;
  for (int step = 0; step < 400; ++step) {
    spheres.back().center += dvec3(0.02, 0.01, 0.01);
    const ShadowFit fit = fitShadow(spheres, dvec3(2, 3, 1), sun, 1024, 150);
    changes += fit != before;
    before = fit;
    const auto view = shadowViewBlock(fit, dvec3(0));
    const dvec3 c = mapCoordinates(view, spheres.back().center);
    to_edge = std::min({c.x, c.y, 1024 - c.x, 1024 - c.y});
    ASSERT_GT(to_edge, 2.9);
    ASSERT_GT(c.z, 0);
    ASSERT_LT(c.z, 1);
  }
  EXPECT_LT(to_edge, 40);  // it led the fit
  EXPECT_GT(changes, 1);
  EXPECT_LT(changes, 40);
}

TEST(ShadowFit, IsTheSameFarFromTheOrigin) {
  const vec3 sun(0, 1, 0);
  const auto a = fitShadowView(heap(3, dvec3(0)), dvec3(4, 3, 2), sun, 1024, 150);
  // A whole number of the steps in which the map moves.
  const double step = 1024.0 / kShadowSteps * fitShadow(heap(3, dvec3(0)), dvec3(4, 3, 2), sun, 1024, 150).texel;
  const double away = std::round(1048576 / step) * step;
  const dvec3 far(away, 0, away);
  const auto b = fitShadowView(heap(3, far), far + dvec3(4, 3, 2), sun, 1024, 150);
  EXPECT_EQ(a.texel_m, b.texel_m);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      EXPECT_FLOAT_EQ(a.shadow_from_relative[c][r], b.shadow_from_relative[c][r]);
  for (int r = 0; r < 2; ++r) EXPECT_NEAR(a.shadow_from_relative[3][r], b.shadow_from_relative[3][r], 0.01);
}

// Clip space, over the whole target, shows the used part at its texels.
TEST(ShadowFit, ClipSpaceIsTheMapInTexels) {
  const dvec3 camera(3, 2, 1);
  const auto view = fitShadowView(heap(4, dvec3(0)), camera, glm::normalize(vec3(1, 2, 3)), 1024, 150);
  EXPECT_EQ(view.size_px, vec2(1024));
  EXPECT_NEAR(view.axis_x.w * 2, view.texel_m * 1024, 1e-4);
  for (uint64_t i = 0; i < 100; ++i) {
    const vec4 point(vec3(randomDirection(6, i, 0) * 8.0), 1);
    const vec4 clip = view.clip_from_relative * point, texel = view.shadow_from_relative * point;
    EXPECT_NEAR((clip.x * 0.5f + 0.5f) * rules::kShadowMapSize, texel.x, 1e-2);
    EXPECT_NEAR((clip.y * 0.5f + 0.5f) * rules::kShadowMapSize, texel.y, 1e-2);
    EXPECT_EQ(clip.z, texel.z);
  }
}

TEST(ShadowFit, SideFollowsTheOutput) {
  const ShadowSettings automatic;
  EXPECT_EQ(shadowMapSide(automatic, 1), 64);
  EXPECT_EQ(shadowMapSide(automatic, 360), 1024);
  EXPECT_EQ(shadowMapSide(automatic, 720), 2048);
  EXPECT_EQ(shadowMapSide(automatic, 4320), 2048);
  EXPECT_EQ(shadowMapSide({.side_texels = 512}, 720), 512);
  EXPECT_EQ(shadowMapSide({.side_texels = 5000}, 720), 2048);
}

TEST(ShadowFit, HostileCastersAndSuns) {
  const float nan = std::nanf("");
  const auto none = fitShadowView({}, dvec3(0), vec3(0, 1, 0), 2048, 150);
  EXPECT_EQ(none.enabled, 0);
  const Sphere far_away[] = {{dvec3(1e7, 0, 0), 1.0f}};
  EXPECT_EQ(fitShadowView(far_away, dvec3(0), vec3(0, 1, 0), 2048, 150).enabled, 0);
  const Sphere broken[] = {{dvec3(0), nan}, {dvec3(0), 0.0f}, {dvec3(0), -1.0f}, {dvec3(nan), 1.0f}};
  EXPECT_EQ(fitShadowView(broken, dvec3(0), vec3(0, 1, 0), 2048, 150).enabled, 0);
  const Sphere mixed[] = {{dvec3(0), nan}, {dvec3(1, 2, 3), 1.0f}, {dvec3(nan), 1.0f}};
  for (const vec3 sun : {vec3(0, 1, 0), vec3(0, -1, 0), vec3(1, 0, 0), vec3(0, 0, 1)}) {
    const auto view = fitShadowView(mixed, dvec3(0), sun, 2048, 150);
    EXPECT_EQ(view.enabled, 1);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) EXPECT_TRUE(std::isfinite(view.clip_from_relative[c][r]));
  }
  // One huge caster does not take the map away from what is near.
  const Sphere huge[] = {{dvec3(0), 1e6f}, {dvec3(1, 2, 3), 1.0f}};
  EXPECT_LT(fitShadowView(huge, dvec3(0), vec3(0, 1, 0), 2048, 150).texel_m, 0.17f);
}

}  // namespace
}  // namespace scree
