// Truth mode converges: to closed forms on a checker plane and in a furnace, to 4,096 samples on a
// lit sphere.
#include <cmath>

#include "engine/gpu/counters.h"
#include "shaders/shared/jitter.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

class Truth : public GlTest {};

// Root mean square over the pixels' largest channel difference.
double rmse(const std::vector<vec3>& a, const std::vector<vec3>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const vec3 d = glm::abs(a[i] - b[i]);
    const double largest = std::max({d.x, d.y, d.z});
    sum += largest * largest;
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// Of log error over log samples, least squares.
double slope(const std::vector<int>& samples, const std::vector<double>& errors) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const double x = std::log(samples[i]), y = std::log(errors[i]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double n = static_cast<double>(samples.size());
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void printCurve(const char* what, const std::vector<int>& samples, const std::vector<double>& errors) {
  std::printf("%s:", what);
  for (size_t i = 0; i < samples.size(); ++i) std::printf("  %d: %.5f", samples[i], errors[i]);
  std::printf("  slope %.2f\n", slope(samples, errors));
}

TEST_F(Truth, JitterStaysInThePixelAndFillsItEvenly) {
  EXPECT_EQ(rules::jitterOffset(0), vec2(0));
  for (const uint32_t count : {16u, 64u, 256u, 4096u}) {
    glm::dvec2 mean(0);
    std::vector<int> cells(16, 0);
    for (uint32_t i = 0; i < count; ++i) {
      const vec2 p = rules::jitterOffset(i);
      ASSERT_TRUE(p.x >= -0.5f && p.x < 0.5f && p.y >= -0.5f && p.y < 0.5f);
      mean += glm::dvec2(p) / static_cast<double>(count);
      ++cells[static_cast<size_t>((p.x + 0.5f) * 4) + 4 * static_cast<size_t>((p.y + 0.5f) * 4)];
    }
    EXPECT_LT(glm::length(mean), 1.8 / count + 1e-3) << count;
    // Of random points a cell of 256 would hold 256 +- 48 (three standard deviations).
    for (const int c : cells) EXPECT_NEAR(c, count / 16.0, 3.5 + 0.02 * count / 16.0) << count;
  }
}

// A checker of glowing and dark tiles seen straight from above: a pixel's square maps to a square of
// the plane, and the share of light in it is known.
TEST_F(Truth, CheckerPlaneConvergesToTheBoxFilter) {
  Studio s({64, 48});
  const uint32_t tile = s.mesh(sheetMesh());
  MaterialData glowing = plainMaterial(vec3(0), 1, 1);
  glowing.emissive = vec3(1);
  const uint32_t light = s.material(glowing), dark = s.material(plainMaterial(vec3(0), 1, 1));
  s.uniformSky(vec3(0));
  constexpr double kTile = 0.371;  // incommensurable with the pixels
  constexpr int kReach = 12;
  for (int j = -kReach; j < kReach; ++j)
    for (int i = -kReach; i < kReach; ++i)
      s.put(tile, (i + j) % 2 == 0 ? light : dark, {(i + 0.5) * kTile, 0, (j + 0.5) * kTile},
            vec3(static_cast<float>(kTile / 2)));
  const double height = 5;
  const Transform eye{{0.05, height, 0.03}, glm::angleAxis(-std::numbers::pi_v<float> / 2, vec3(1, 0, 0)), vec3(1)};
  s.look({0, 0, 0}, {0, 0, -1}, 0.6f);
  *s.world.find<Transform>(s.camera) = eye;
  *s.world.find<PreviousTransform>(s.camera) = previousOf(eye);

  // Integral of the sign of a square wave: light where cells' parities agree.
  const double metres = 2 * height * std::tan(0.3) / s.size.y;
  const auto wave = [&](double x) {  // integral from 0 to x of +1 on even tiles, -1 on odd ones
    const double cell = std::floor(x / kTile), rest = x - cell * kTile;
    const bool odd = std::fmod(std::abs(cell), 2) > 0.5;
    return odd ? kTile - rest : rest;
  };
  std::vector<vec3> expected(static_cast<size_t>(s.size.x * s.size.y));
  for (int y = 0; y < s.size.y; ++y)
    for (int x = 0; x < s.size.x; ++x) {
      const double x0 = eye.position.x + (x - s.size.x / 2.0) * metres, z0 = eye.position.z - (y + 1 - s.size.y / 2.0) * metres;
      const double mean_x = (wave(x0 + metres) - wave(x0)) / metres, mean_z = (wave(z0 + metres) - wave(z0)) / metres;
      expected[s.at(x, y)] = vec3(static_cast<float>(0.5 + 0.5 * mean_x * mean_z));
    }

  std::vector<int> samples = {2, 8, 32, 128, 512};
  std::vector<double> errors;
  for (const int n : samples) {
    s.render(n);
    errors.push_back(rmse(s.radiance(kTruth), expected));
  }
  s.render(1);
  const double single = rmse(s.radiance(), expected);
  printCurve("checker", samples, errors);
  std::printf("checker, 1 sample: %.4f\n", single);
  EXPECT_GT(single, 0.05);
  for (size_t i = 0; i < samples.size(); ++i) EXPECT_LT(errors[i], 1.2 * single * std::pow(samples[i], -0.6));
  EXPECT_LT(slope(samples, errors), -0.65);
  EXPECT_LT(errors.back(), 0.004);
}

TEST_F(Truth, LitSphereConverges) {
  Studio s({48, 36});
  s.put(s.mesh(sphereMesh()), s.material(plainMaterial(vec3(0.9f, 0.6f, 0.3f), 0, 0.4f)), {0, 1, 0});
  s.put(s.mesh(sheetMesh()), s.material(plainMaterial(vec3(0.5f), 0, 0.9f)), {0, 0, 0}, vec3(4));
  s.sun({1, 1.5, 1});
  s.look({0, 2, 5}, {0, 0.7, 0});
  s.render(4096);
  const auto reference = s.radiance(kTruth);
  std::vector<int> samples = {2, 8, 32, 128};
  std::vector<double> errors;
  for (const int n : samples) {
    s.render(n);
    errors.push_back(rmse(s.radiance(kTruth), reference));
  }
  s.render(1);
  const double single = rmse(s.radiance(), reference);
  printCurve("sphere", samples, errors);
  std::printf("sphere, 1 sample: %.4f\n", single);
  EXPECT_LT(slope(samples, errors), -0.6);
  EXPECT_LT(errors.back(), 0.1 * single);
}

// A white surface under a uniform sky is invisible, whatever its roughness and metalness.
TEST_F(Truth, WhiteFurnace) {
  double worst = 0;
  for (const float roughness : {0.0f, 0.1f, 0.3f, 0.6f, 1.0f})
    for (const float metallic : {0.0f, 0.4f, 1.0f}) {
      Studio s({48, 36});
      s.put(s.mesh(sphereMesh()), s.material(plainMaterial(vec3(1), metallic, roughness)), {0, 0, 0});
      s.uniformSky(vec3(1));
      s.look({0, 0.5, 3.5}, {0, 0, 0});
      for (const int n : {1, 4}) {
        s.render(n);
        const auto seen = s.radiance(n == 1 ? kRadiance : kTruth);
        int covered = 0;
        const auto ids = s.ids();
        for (size_t i = 0; i < seen.size(); ++i) {
          covered += ids[i] != 0;
          for (int k = 0; k < 3; ++k) {
            worst = std::max<double>(worst, std::abs(seen[i][k] - 1));
            EXPECT_NEAR(seen[i][k], 1, 1e-3) << "roughness " << roughness << " metallic " << metallic;
          }
        }
        EXPECT_GT(covered, 300);
      }
    }
  std::printf("furnace: largest deviation %.2e\n", worst);
}

// A grey one is not, and gets darker with its albedo: the furnace does not pass by doing nothing.
TEST_F(Truth, GreyFurnaceAbsorbs) {
  Studio s({48, 36});
  const Entity ball = s.put(s.mesh(sphereMesh()), 0, {0, 0, 0});
  s.uniformSky(vec3(1));
  s.look({0, 0, 3.5}, {0, 0, 0});
  double last = 1;
  for (const float albedo : {0.8f, 0.4f, 0.1f}) {
    s.world.find<MeshInstance>(ball)->material = s.material(plainMaterial(vec3(albedo), 0, 0.6f));
    s.render();
    const double center = s.radiance()[s.at(24, 18)].x;
    EXPECT_LT(center, last - 0.1);
    EXPECT_GT(center, albedo);  // a dielectric adds its reflection
    EXPECT_LT(center, albedo + 0.1);
    last = center;
  }
}

TEST_F(Truth, MeanIsThatOfItsSamples) {
  Studio s({32, 24});
  s.put(s.mesh(sphereMesh(12, 24)), 0, {0, 0, 0});
  s.sun({1, 1, 1});
  s.look({0, 0.5, 3.5}, {0, 0, 0});
  // Samples rendered one by one, summed in double.
  constexpr int kSamples = 16;
  std::vector<glm::dvec3> sum(32 * 24, glm::dvec3(0));
  FrameInput& input = s.world.singleton<FrameInput>();
  for (int k = 0; k < kSamples; ++k) {
    input = {.size = s.size, .sample = k, .sample_count = kSamples, .jitter_px = rules::jitterOffset(static_cast<uint32_t>(k))};
    s.app.schedule().run(Phase::Prepare, s.world);
    s.app.frame().run(input);
    const auto one = s.radiance();
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += glm::dvec3(one[i]) / double{kSamples};
  }
  const auto mean = s.radiance(kTruth);
  for (size_t i = 0; i < sum.size(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[i][k], sum[i][k], 2e-6 * (1 + sum[i][k]));
  // Again: the first sample starts a new mean.
  s.render(kSamples);
  EXPECT_EQ(s.radiance(kTruth), mean);
  s.render(1);
  s.render(kSamples);
  EXPECT_EQ(s.radiance(kTruth), mean);
}

TEST_F(Truth, IsWhatIsShownAndCostsNothingWhenOff) {
  Studio s({32, 24});
  s.put(s.mesh(sphereMesh(12, 24)), 0, {0, 0, 0});
  s.look({0, 0.5, 3.5}, {0, 0, 0});
  s.render(1);
  EXPECT_FALSE(s.app.frame().hasTexture(kTruth));
  EXPECT_EQ(s.app.frame().runCount("deferred.accumulate"), 0u);
  const auto aliased = s.image();
  s.render(32);
  EXPECT_EQ(s.app.frame().runCount("deferred.accumulate"), 32u);
  const auto smooth = s.image();
  EXPECT_NE(aliased.rgb, smooth.rgb);
  s.render(1);
  EXPECT_EQ(s.image().rgb, aliased.rgb);
}

}  // namespace
}  // namespace scree::test
