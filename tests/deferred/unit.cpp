// Rules of the G-buffer and the display without GL: octahedral normals, motion, tone curve, sRGB.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "engine/core/random.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/octahedral.h"
#include "shaders/shared/tonemap.h"

namespace scree {
namespace {

using glm::dvec2;
using glm::dvec4;
// rad; stated in shared/octahedral.h.
const double kOct24MaxError = rules::kOct24MaxErrorRad;

using rules::octDecode;
using rules::octEncode;
using rules::octPack24;
using rules::octUnpack24;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

// What an 8-bit unorm target does to three channels.
vec3 throughUnorm8(vec3 v) {
  for (int i = 0; i < 3; ++i) v[i] = std::nearbyint(glm::clamp(v[i], 0.0f, 1.0f) * 255.0f) / 255.0f;
  return v;
}
vec3 throughGbuffer(vec3 n) { return octDecode(octUnpack24(throughUnorm8(octPack24(octEncode(n))))); }

double angle(dvec3 a, dvec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// Uniform on the sphere.
vec3 randomDirection(uint64_t seed, uint64_t i) {
  const double z = 2.0 * randomUnit(seed, i, 0, 0) - 1, phi = 6.283185307179586 * randomUnit(seed, i, 0, 1);
  const double r = std::sqrt(1 - z * z);
  return vec3(dvec3(r * std::cos(phi), r * std::sin(phi), z));
}

TEST(Octahedral, AMillionNormalsSurviveTwelveBits) {
  constexpr uint64_t kSeed = 11;
  double worst = 0, sum = 0, worst_length = 0;
  constexpr int kCount = 1'000'000;
  for (int i = 0; i < kCount; ++i) {
    const vec3 n = randomDirection(kSeed, static_cast<uint64_t>(i));
    const vec3 back = throughGbuffer(n);
    const double error = angle(n, back);
    worst = std::max(worst, error);
    sum += error;
    worst_length = std::max(worst_length, std::abs(1.0 - glm::length(dvec3(back))));
  }
  std::printf("seed %d: worst %.3e rad, mean %.3e rad\n", static_cast<int>(kSeed), worst, sum / kCount);
  EXPECT_LT(worst, kOct24MaxError);
  EXPECT_GT(worst, 0.9 * kOct24MaxError);  // a finer result would mean that the 12 bits are not used
  EXPECT_LT(sum / kCount, 3.7e-4);
  EXPECT_LT(worst_length, 2e-7);
}

TEST(Octahedral, EncodeAndDecodeInvertWithoutQuantisation) {
  double worst = 0;
  for (uint64_t i = 0; i < 200'000; ++i) {
    const vec3 n = randomDirection(3, i);
    worst = std::max(worst, angle(n, octDecode(octEncode(n * 37.5f))));
  }
  EXPECT_LT(worst, 5e-7);
}

TEST(Octahedral, AxesAreExact) {
  for (const vec3 axis : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0),
                          vec3(0, 0, 1), vec3(0, 0, -1), vec3(-0.0f, -0.0f, -1)}) {
    EXPECT_EQ(throughGbuffer(axis), axis) << axis.x << axis.y << axis.z;
    EXPECT_EQ(octDecode(octEncode(axis)), axis);
  }
}

TEST(Octahedral, WhatHasNoDirectionBecomesPlusZ) {
  const float denormal = std::numeric_limits<float>::denorm_min();
  for (const vec3 n : {vec3(0), vec3(-0.0f), vec3(kNan), vec3(0, kNan, 1), vec3(kInf, 0, 0),
                       vec3(-kInf, kInf, 0), vec3(denormal), vec3(3e38f, 3e38f, 0)})
    EXPECT_EQ(throughGbuffer(n), vec3(0, 0, 1));
}

// The equator, where the square folds, and the meridians where signs change, one ulp to each side.
TEST(Octahedral, FoldsHaveNoSeam) {
  const float tiny[] = {0.0f, -0.0f, 1e-38f, -1e-38f, 1e-7f, -1e-7f};
  for (int i = 0; i < 3600; ++i) {
    const double phi = i * 6.283185307179586 / 3600;
    const auto c = static_cast<float>(std::cos(phi)), s = static_cast<float>(std::sin(phi));
    for (const float t : tiny)
      for (const vec3 n : {vec3(c, s, t), vec3(t, c, s), vec3(c, t, s)})
        EXPECT_LT(angle(n, throughGbuffer(n)), kOct24MaxError) << n.x << " " << n.y << " " << n.z;
  }
  // Across each fold, neighbours stay neighbours.
  for (int i = 0; i < 3600; ++i) {
    const double phi = i * 6.283185307179586 / 3600;
    const vec3 a(dvec3(std::cos(phi), std::sin(phi), 1e-6)), b(dvec3(std::cos(phi), std::sin(phi), -1e-6));
    EXPECT_LT(angle(octDecode(octEncode(a)), octDecode(octEncode(b))), 3e-6);
  }
}

TEST(Octahedral, EveryTwelveBitCodeIsAFixedPoint) {
  for (int code = 0; code < 4095; ++code) {
    const float p = (code - rules::kOct12Steps) / rules::kOct12Steps;
    for (const vec2 point : {vec2(p, 0.25f), vec2(-0.375f, p)}) {
      const vec2 back = octUnpack24(throughUnorm8(octPack24(point)));
      EXPECT_NEAR(back.x, std::round(point.x * rules::kOct12Steps) / rules::kOct12Steps, 1e-7);
      EXPECT_NEAR(back.y, std::round(point.y * rules::kOct12Steps) / rules::kOct12Steps, 1e-7);
    }
  }
}

// ---- motion

constexpr vec2 kSize(640, 360);
constexpr float kNear = 0.1f;

// Pixel of a view-space point (looking along -Z), in double.
dvec2 projectPx(dvec3 p) {
  const double focal = 1.7;
  return {(p.x * focal / (-p.z * 640.0 / 360.0) + 1) * 320, (p.y * focal / -p.z + 1) * 180};
}
vec3 clipOf(dvec3 p) {
  const double focal = 1.7;
  return vec3(p.x * focal / (640.0 / 360.0), p.y * focal, -p.z);
}
vec2 motionBetween(dvec3 previous, dvec3 now) {
  return rules::motionPx(vec2(projectPx(now)), static_cast<float>(-now.z), clipOf(previous), kSize, kNear);
}

TEST(Motion, IsTheDifferenceOfTheProjections) {
  for (uint64_t i = 0; i < 10'000; ++i) {
    const auto r = [&](int d) { return 2.0 * randomUnit(5, i, 0, static_cast<uint64_t>(d)) - 1; };
    const dvec3 now(3 * r(0), 2 * r(1), -6 + 4 * r(2)), previous = now + dvec3(r(3), r(4), r(5)) * 0.3;
    const dvec2 expected = projectPx(now) - projectPx(previous);
    const vec2 motion = motionBetween(previous, now);
    EXPECT_NEAR(motion.x, expected.x, 1e-3);
    EXPECT_NEAR(motion.y, expected.y, 1e-3);
  }
}

TEST(Motion, SignsAreRightAndUp) {
  EXPECT_GT(motionBetween({0, 0, -5}, {0.1, 0, -5}).x, 5);
  EXPECT_GT(motionBetween({0, 0, -5}, {0, 0.1, -5}).y, 5);
  EXPECT_LT(glm::length(motionBetween({0.3, 0.2, -5}, {0.3, 0.2, -5})), 1e-4f);
}

TEST(Motion, FromBehindTheCameraPointsAlongTheWay) {
  // A point that flew over the camera's right shoulder into view moves inwards from the right.
  for (const double z : {-0.1, -0.05, 0.0, 1e-9, 0.05, 1.0, 50.0, 1e6}) {
    const vec2 motion = motionBetween({1, 0.5, z}, {0.2, 0.1, -2});
    EXPECT_TRUE(std::isfinite(motion.x) && std::isfinite(motion.y)) << z;
    EXPECT_LT(motion.x, 0) << z;
    EXPECT_LT(motion.y, 0) << z;
    EXPECT_LE(glm::length(motion), rules::kMaxMotionPx * 1.0001f) << z;
  }
  // Continuous where the point crosses the near plane.
  const vec2 before = motionBetween({0.01, 0, -0.1000001}, {0.01, 0, -2});
  const vec2 behind = motionBetween({0.01, 0, -0.0999999}, {0.01, 0, -2});
  EXPECT_LT(glm::length(before - behind), 0.01f);
}

TEST(Motion, HostileInputIsFiniteAndBounded) {
  const float values[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e30f, -1e30f, 1e-30f, kInf, -kInf, kNan};
  for (const float x : values)
    for (const float y : values)
      for (const float w : values)
        for (const float now_w : {0.1f, 2.0f, 1e30f, kInf}) {
          const vec2 m = rules::motionPx(vec2(320, 180), now_w, vec3(x, y, w), kSize, kNear);
          EXPECT_TRUE(glm::dot(m, m) <= 1.001f * rules::kMaxMotionPx * rules::kMaxMotionPx)
              << x << " " << y << " " << w << " " << now_w << " -> " << m.x << " " << m.y;
        }
}

// ---- display

double srgbReference(double x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

TEST(Srgb, IsWithinAHundredthOfAStepOfTheStandard) {
  for (int i = 0; i <= 100'000; ++i) {
    const auto x = static_cast<float>(i) / 100'000;
    EXPECT_NEAR(rules::srgbFromLinear(x), srgbReference(x), 3.6e-5);
  }
  for (int i = 0; i < 256; ++i) {
    const float encoded = static_cast<float>(i) / 255;
    EXPECT_NEAR(rules::srgbFromLinear(rules::linearFromSrgb(encoded)), encoded, 3.6e-5);
  }
  EXPECT_EQ(rules::srgbFromLinear(0.0f), 0);
  EXPECT_FLOAT_EQ(rules::srgbFromLinear(1.0f), 1);
}

// The curve as published, in double.
dvec3 neutralReference(dvec3 c) {
  const double start = 0.8 - 0.04, x = std::min({c.x, c.y, c.z});
  c -= x < 0.08 ? x - 6.25 * x * x : 0.04;
  const double peak = std::max({c.x, c.y, c.z});
  if (peak < start) return c;
  const double d = 1 - start, new_peak = 1 - d * d / (peak + d - start);
  c *= new_peak / peak;
  const double g = 1 - 1 / (0.15 * (peak - new_peak) + 1);
  return c * (1 - g) + dvec3(new_peak) * g;
}

TEST(ToneMap, FollowsThePublishedCurve) {
  for (uint64_t i = 0; i < 200'000; ++i) {
    vec3 c;
    for (int k = 0; k < 3; ++k) c[k] = std::exp(20 * randomUnit(9, i, 0, static_cast<uint64_t>(k)) - 10);
    const dvec3 expected = neutralReference(c);
    const vec3 got = rules::toneMap(c);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(got[k], expected[k], 3e-6) << c.x << " " << c.y << " " << c.z;
      EXPECT_TRUE(got[k] >= 0 && got[k] <= 1.0f);
    }
  }
}

TEST(ToneMap, IsMonotonousAndKeepsBlack) {
  EXPECT_EQ(rules::toneMap(vec3(0)), vec3(0));
  float last = -1;
  for (int i = 0; i < 4000; ++i) {
    const float y = rules::toneMap(vec3(static_cast<float>(i) * 0.002f)).x;
    EXPECT_GE(y, last);
    last = y;
  }
  const vec3 brightest = rules::toneMap(vec3(rules::kMaxRadiance));
  EXPECT_TRUE(brightest.x > 0.99f && brightest.x <= 1.0f);
}

}  // namespace
}  // namespace scree
