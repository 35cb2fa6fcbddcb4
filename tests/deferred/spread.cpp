// Surfaces with many normals under a pixel: the rules that shade them, against the mean over all of their normals.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <vector>

#include "engine/core/random.h"
#include "modules/deferred/lobe_table.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/spread.h"

namespace scree::test {
namespace {

TEST(Spread, CodesOfMetallicAndSpreadComeBack) {
  const int most = 127 + rules::kSpreadSteps * 5;
  ASSERT_LE(most, 255);
  for (int stored = 0; stored <= most; ++stored) {
    const rules::MetallicSpread s = rules::metallicSpreadFromCode(static_cast<float>(stored) / 255);
    const float again = rules::metallicSpreadCode(s.metallic, rules::spreadFromCode(s.spread));
    EXPECT_NEAR(again * 255, stored, 1e-3);
  }
  for (uint64_t k = 0; k < 10'000; ++k) {
    const float metallic = randomUnit(1, k, 0, 0), spread = rules::kMostSpread * randomUnit(1, k, 0, 1);
    const rules::MetallicSpread flat = rules::metallicSpreadFromCode(rules::metallicSpreadCode(metallic, 0));
    EXPECT_EQ(flat.spread, 0);
    EXPECT_NEAR(flat.metallic, metallic, 0.501 / 127);
    const rules::MetallicSpread s = rules::metallicSpreadFromCode(rules::metallicSpreadCode(metallic, spread));
    EXPECT_LE(std::abs(rules::spreadFromCode(s.spread) - spread), 0.016f);
    EXPECT_NEAR(s.metallic, metallic, s.spread > 0 ? 0.501 / 4 : 0.501 / 127);
  }
  for (const float wild : {-1.0f, 2.0f, 1e30f}) {
    const float code = rules::metallicSpreadCode(wild, wild);
    EXPECT_TRUE(code >= 0 && code * 255 <= static_cast<float>(most) + 1e-3f) << wild;
  }
}

// ---- Shapes, as their normals seen from +Z, each with the same area in the picture ---------------

using Normals = std::vector<vec3>;

// The part of a ball whose picture is the disc of this radius around (x, 0); of an ellipsoid, as high as `height` balls.
Normals partOfABall(double x, double radius, double height = 1) {
  Normals normals;
  constexpr int kSide = 44;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; j < kSide; ++j) {
      const double u = (2 * i + 1.0) / kSide - 1, v = (2 * j + 1.0) / kSide - 1;
      const double px = x + radius * u, py = radius * v, left = 1 - px * px - py * py;
      if (u * u + v * v >= 1 || left <= 0) continue;
      normals.push_back(glm::normalize(vec3(px * height, py * height, std::sqrt(left))));
    }
  return normals;
}

struct Shape {
  const char* name;
  Normals normals;
};
std::vector<Shape> shapes() {
  return {{"middle of a ball", partOfABall(0, 0.3)},
          {"half as wide as a ball", partOfABall(0, 0.5)},
          {"beside its middle", partOfABall(0.5, 0.3)},
          {"at the edge of a ball", partOfABall(0.8, 0.3)},
          {"half of a ball", partOfABall(1, 1)},
          {"a ball", partOfABall(0, 1)},
          {"a lentil", partOfABall(0, 1, 0.4)},
          {"a rod from its end", partOfABall(0, 1, 2)}};
}

struct Mean {
  vec3 direction;
  float spread;
};
Mean meanOf(const Normals& normals) {
  dvec3 sum(0);
  for (const vec3& n : normals) sum += dvec3(n);
  const double length = glm::length(sum);
  return {vec3(sum / length), static_cast<float>(1 - length / static_cast<double>(normals.size()))};
}

template <class F>
double meanOver(const Normals& normals, const F& f) {
  double sum = 0;
  for (const vec3& n : normals) sum += static_cast<double>(f(n));
  return sum / static_cast<double>(normals.size());
}

vec3 randomDirection(uint64_t k) {
  const float z = 2 * randomUnit(2, k, 0, 0) - 1, turn = 2 * std::numbers::pi_v<float> * randomUnit(2, k, 0, 1);
  const float across = std::sqrt(1 - z * z);
  return {across * std::cos(turn), across * std::sin(turn), z};
}

TEST(Spread, BeamsAndMomentsAreThoseOfTheNormals) {
  for (const Shape& shape : shapes()) {
    const Mean mean = meanOf(shape.normals);
    double worst_beam = 0, worst_square = 0, flat_beam = 0;
    for (uint64_t k = 0; k < 200; ++k) {
      const vec3 d = randomDirection(k);
      const float c = glm::dot(mean.direction, d);
      const double beam = meanOver(shape.normals, [&](const vec3& n) { return std::max(glm::dot(n, d), 0.0f); });
      const double square = meanOver(shape.normals, [&](const vec3& n) { return glm::dot(n, d) * glm::dot(n, d); });
      const vec2 moments = rules::spreadMoments(c, mean.spread);
      EXPECT_NEAR(moments.x, meanOver(shape.normals, [&](const vec3& n) { return glm::dot(n, d); }), 1e-4);
      worst_square = std::max(worst_square, std::abs(static_cast<double>(moments.y) - square));
      worst_beam = std::max(worst_beam, std::abs(static_cast<double>(rules::spreadTowards(c, mean.spread)) - beam));
      flat_beam = std::max(flat_beam, std::abs(static_cast<double>(std::max(c, 0.0f)) - beam));
    }
    std::printf("%-24s spread %.3f: worst of n.l %.3f (one normal %.3f), of (n.d)^2 %.3f\n", shape.name,
                static_cast<double>(mean.spread), worst_beam, flat_beam, worst_square);
    EXPECT_LT(worst_beam, 0.05);
    EXPECT_LT(worst_beam, 0.25 * flat_beam);
    EXPECT_LT(worst_square, 0.085);
  }
}

// ---- Lobes ---------------------------------------------------------------------------------------

// Reflection of a lamp by a patch of bumps, mean over the lamp's directions of |filtered - true| /
// peak, where true is the mean over the patch's normals and filtered one normal with one roughness.
double filterError(float spread, float alpha2, bool widened) {
  constexpr int kNormals = 4000;
  std::vector<vec3> normals;
  vec3 mean(0);
  for (uint64_t k = 0; k < kNormals; ++k) {
    // Gaussian slopes by the sum of twelve uniform numbers.
    float slope[2] = {-6, -6};
    for (uint64_t d = 0; d < 24; ++d) slope[d % 2] += randomUnit(11, k, 0, d);
    normals.push_back(glm::normalize(vec3(slope[0] * spread, slope[1] * spread, 1)));
    mean += normals.back() / static_cast<float>(kNormals);
  }
  const float length = glm::length(mean);
  const float filtered = std::sqrt(widened ? rules::spreadAlpha2(alpha2, 1 - length) : alpha2);
  const auto lobe = [](vec3 n, vec3 l, float alpha) {
    const vec3 v(0, 0, 1), h = glm::normalize(v + l);
    const float n_l = dot(n, l);
    return n_l > 0 ? rules::ggxDistributionVisibility(std::min(std::max(dot(n, h), 0.0f), 1.0f),
                                                      std::max(n.z, 1e-3f), n_l, alpha) *
                         n_l
                   : 0;
  };
  double error = 0, peak = 0;
  for (int i = 0; i <= 40; ++i) {
    const float angle = static_cast<float>(i) * 0.025f;
    const vec3 l(std::sin(angle), 0, std::cos(angle));
    double truth = 0;
    for (const vec3& n : normals) truth += lobe(n, l, std::sqrt(alpha2)) / kNormals;
    error += std::abs(lobe(mean / length, l, filtered) - truth) / 41;
    peak = std::max(peak, truth);
  }
  return error / peak;
}

TEST(SpreadLobe, WidenedLobesAreNearerToTheMeanOfTheBumpsThanLobesAsTheyWere) {
  for (float spread : {0.05f, 0.1f, 0.2f, 0.3f}) {
    for (float roughness : {0.2f, 0.35f, 0.5f}) {
      const float alpha2 = roughness * roughness * roughness * roughness;
      const double kept = filterError(spread, alpha2, false),
                   widened = filterError(spread, alpha2, true);
      // Where the bumps are finer than the lobe, both are near.
      EXPECT_LT(widened, std::max(0.5 * kept, 0.02)) << spread << " " << roughness;
    }
  }
}

TEST(SpreadLobe, InvertsTheMeanLengthOfGaussianSlopes) {
  for (double a : {0.002, 0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 0.95}) {
    // exp(x^2) erfc(x) by the continued fraction, as erfc alone vanishes.
    const double x = 1 / std::sqrt(a);
    double fraction = x;
    for (int k = 200; k > 0; --k) fraction = x + 0.5 * k / fraction;
    const double length =
        std::sqrt(std::numbers::pi) * x / (fraction * std::sqrt(std::numbers::pi));
    EXPECT_NEAR(rules::spreadAlpha2(0, static_cast<float>(1 - length)), a, 0.035 * a) << a;
  }
}

TEST(SpreadLobe, EndsAreExactAndItGrowsBetweenThem) {
  EXPECT_EQ(rules::spreadAlpha2(0.01f, 0), 0.01f);
  EXPECT_EQ(rules::spreadAlpha2(0.01f, 1), 1);
  EXPECT_EQ(rules::spreadAlpha2(0.01f, -1), 0.01f);
  float before = 0;
  for (int i = 0; i <= 1000; ++i) {
    const float now = rules::spreadAlpha2(0.0f, static_cast<float>(i) * 1e-3f);
    EXPECT_GE(now, before);
    before = now;
  }
}

// ---- Light --------------------------------------------------------------------------------------

const rules::SkyPolynomial kSky = rules::skyPolynomial({0.18f, 0.32f, 0.65f}, {0.60f, 0.68f, 0.75f}, {0.16f, 0.14f, 0.12f});

struct Material {
  vec3 albedo;
  float metallic, roughness;
};
struct Lights {
  vec3 to_sun;
  bool sun, sky;
};

constexpr float kSun = 3;

float luminance(vec3 c) { return glm::dot(c, vec3(0.2126f, 0.7152f, 0.0722f)); }

vec2 heightOf(vec3 n) { return {n.y, n.y * n.y}; }

float shadeOne(std::span<const vec4> table, const Material& m, const Lights& lights, vec3 n, vec3 v, float roughness) {
  const float n_v = glm::clamp(glm::dot(n, v), 1e-4f, 1.0f);
  const rules::LobeTerms lobe = sampleLobeTable(table, n_v, roughness);
  const rules::Reflectance r = rules::reflectance(m.albedo, m.metallic, lobe.a, lobe.b);
  vec3 sum(0);
  if (lights.sky) sum += rules::reflectSky(kSky, r, lobe, n, v, n_v, roughness, heightOf(n));
  if (lights.sun)
    sum += kSun * rules::reflectBeam(r, n, v, lights.to_sun, glm::dot(n, lights.to_sun), n_v, rules::alphaFromRoughness(roughness));
  return luminance(sum);
}

// As deferred/light.frag does.
float shadeSpread(std::span<const vec4> tables, const Material& m, const Lights& lights, const Mean& mean, vec3 v) {
  const float n_v = glm::clamp(glm::dot(mean.direction, v), 1e-4f, 1.0f);
  const int code = rules::spreadCode(mean.spread);
  const rules::SpreadLook look = rules::spreadLook(mean.direction, lights.to_sun, m.roughness, rules::spreadFromCode(code));
  const size_t texels = tables.size() / (rules::kSpreadSteps + 1);
  const rules::LobeTerms lobe = sampleLobeTable(tables.subspan(static_cast<size_t>(code) * texels, texels), n_v, m.roughness);
  const rules::Reflectance r = rules::reflectance(m.albedo, m.metallic, lobe.a, lobe.b);
  vec3 sum(0);
  if (lights.sky) sum += rules::reflectSky(kSky, r, lobe, mean.direction, v, n_v, look.roughness, look.height);
  if (lights.sun) sum += kSun * rules::reflectSpreadBeam(r, mean.direction, v, lights.to_sun, n_v, look);
  return luminance(sum);
}

// What a user would do instead: one normal, and a lobe as wide as both.
float shadeWidened(std::span<const vec4> table, const Material& m, const Lights& lights, const Mean& mean, vec3 v) {
  const float alpha = rules::alphaFromRoughness(m.roughness);
  return shadeOne(table, m, lights, mean.direction, v, std::sqrt(std::sqrt(rules::spreadAlpha2(alpha * alpha, mean.spread))));
}

struct Off {
  double mean = 0, each = 0;  // of the sum over all directions, and over each of them; shares of the truth
};

// A shape and what shades it, from many sides in the light of many suns.
template <class Shaded>
Off offOf(const Shape& shape, std::span<const vec4> table, const Material& m, bool sun, bool sky, const Shaded& shaded) {
  constexpr uint64_t kDirections = 200;
  double truth = 0, sum = 0, off = 0;
  for (uint64_t k = 0; k < kDirections; ++k) {
    const vec3 v = randomDirection(100 + k), side = randomDirection(1500 + k);
    const Lights lights{glm::normalize(side.y < 0.1f ? vec3(side.x, 0.1f - side.y, side.z) : side), sun, sky};
    const vec3 up = std::abs(v.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0), x = glm::normalize(glm::cross(up, v)), y = glm::cross(v, x);
    Normals turned;
    for (const vec3& n : shape.normals) turned.push_back(x * n.x + y * n.y + v * n.z);
    const double exact = meanOver(turned, [&](const vec3& n) { return shadeOne(table, m, lights, n, v, m.roughness); });
    const auto got = static_cast<double>(shaded(m, lights, meanOf(turned), v));
    truth += exact, sum += got, off += std::abs(got - exact);
  }
  return {sum / truth - 1, off / truth};
}

TEST(Spread, LightIsTheMeanOverTheNormals) {
  const std::vector<vec4> table = makeLobeTable(), tables = makeSpreadLobeTables(table);
  const Material materials[] = {{vec3(0.06f), 0, 0.45f}, {vec3(0.06f), 0, 0.3f}, {vec3(0.4f), 0, 0.45f}, {vec3(0.4f), 0, 0.9f}, {vec3(0.7f), 1, 0.4f}};
  std::printf("%% off the mean over the normals: all directions (each) [one normal and a wider lobe]; albedo, roughness:\n%24s", "");
  for (const Material& m : materials)
    std::printf("  %12.2f, %4.2f%s  ", static_cast<double>(m.albedo.x), static_cast<double>(m.roughness), m.metallic > 0 ? " metal" : "      ");
  for (const Shape& shape : shapes()) {
    std::printf("\n%-24s", shape.name);
    for (const Material& m : materials) {
      const auto spread = [&](auto&&... of) { return shadeSpread(tables, of...); };
      const auto widened = [&](auto&&... of) { return shadeWidened(table, of...); };
      const Off sky = offOf(shape, table, m, false, true, spread), both = offOf(shape, table, m, true, true, spread);
      const Off sky_widened = offOf(shape, table, m, false, true, widened), both_widened = offOf(shape, table, m, true, true, widened);
      std::printf("  %+5.1f (%4.1f) [%+5.1f (%4.1f)]", 100 * both.mean, 100 * both.each, 100 * both_widened.mean, 100 * both_widened.each);
      EXPECT_LT(std::abs(sky.mean), 0.1) << shape.name;
      EXPECT_LT(sky.each, std::max(0.5 * sky_widened.each, 0.015)) << shape.name;
      EXPECT_LT(std::abs(both.mean), 0.13) << shape.name;
      EXPECT_LT(std::abs(both.mean), std::max(0.45 * std::abs(both_widened.mean), 0.03)) << shape.name;
      EXPECT_LT(both.each, both_widened.each + 0.02) << shape.name;
    }
  }
  std::printf("\n");
}

TEST(SpreadLobe, AlbedoOfABallIsTheMeanOverItsNearSide) {
  const std::vector<vec4> table = makeLobeTable();
  for (float roughness = 0.05f; roughness <= 1; roughness += 0.05f) {
    double a = 0, b = 0;
    constexpr int kRings = 400;  // of the same area in the picture
    for (int k = 0; k < kRings; ++k) {
      const rules::LobeTerms t = sampleLobeTable(table, std::sqrt((static_cast<float>(k) + 0.5f) / kRings), roughness);
      a += static_cast<double>(t.a) / kRings, b += static_cast<double>(t.b) / kRings;
    }
    const vec2 got = rules::ballAlbedo(roughness);
    EXPECT_NEAR(static_cast<double>(got.x), a, 0.007) << roughness;
    EXPECT_NEAR(static_cast<double>(got.y), b, 0.0015) << roughness;
  }
}

// A surface of one normal is shaded as if there were no spread in the frame, to the last bits.
TEST(Spread, NoSpreadIsOneNormal) {
  const std::vector<vec4> table = makeLobeTable(), tables = makeSpreadLobeTables(table);
  for (uint64_t k = 0; k < 2000; ++k) {
    const Material m{vec3(randomUnit(3, k, 0, 0)), randomUnit(3, k, 0, 1), 0.045f + 0.955f * randomUnit(3, k, 0, 2)};
    const Lights lights{randomDirection(9000 + k), true, true};
    const vec3 n = randomDirection(3000 + k), v = randomDirection(6000 + k);
    const float one = shadeOne(table, m, lights, n, v, m.roughness);
    EXPECT_NEAR(shadeSpread(tables, m, lights, {n, 0}, v), one, 1e-4f * one + 1e-6f) << k;
  }
}

TEST(Spread, LightIsFiniteAtEverySpread) {
  const std::vector<vec4> tables = makeSpreadLobeTables(makeLobeTable());
  for (const vec4& t : tables)
    ASSERT_TRUE(t.x >= 0 && t.y >= 0 && t.x + t.y <= 1.001f && std::isfinite(t.z) && std::isfinite(t.w)) << t.x << " " << t.y;
  for (uint64_t k = 0; k < 100'000; ++k) {
    const Material m{vec3(1), k % 2 ? 1.0f : 0.0f, k % 3 ? 0.045f : randomUnit(4, k, 0, 0)};
    const vec3 v = randomDirection(3 * k), n = k % 5 ? randomDirection(3 * k + 1) : v * (k % 2 ? 1.0f : -1.0f);
    const Lights lights{k % 7 ? randomDirection(3 * k + 2) : -v, true, true};
    const float light = shadeSpread(tables, m, lights, {n, rules::kMostSpread * randomUnit(4, k, 0, 1)}, v);
    ASSERT_TRUE(std::isfinite(light) && light >= 0) << k;
  }
}

}  // namespace
}  // namespace scree::test
