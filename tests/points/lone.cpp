// Points with nothing around them: that they cover what they should, and do not blink as they move.
#include <algorithm>
#include <cstdio>
#include <set>

#include "tests/points/bed.h"

namespace scree::test {
namespace {

class LonePoints : public GlTest {};

// Seen from far: a pixel is 1 m everywhere.
struct LoneScene : PointScene {
  explicit LoneScene(ivec2 output) : PointScene(output) {
    look({0, 0, 5000}, {0, 0, 0}, static_cast<float>(2 * std::atan(0.5 * size.y / 5000)));
  }
  size_t covered() {
    render();
    const std::vector<uint32_t> all = ids();
    return static_cast<size_t>(std::count_if(all.begin(), all.end(), [](uint32_t id) { return id != 0; }));
  }
};

TEST_F(LonePoints, KeepTheirPixelsAsTheySlide) {
  for (const float radius : {0.3f, 0.57f, 0.6f, 0.75f, 0.9f}) {
    const double area = std::numbers::pi * static_cast<double>(radius * radius);
    double sum = 0;
    constexpr int kGrains = 24;
    for (uint16_t seed = 0; seed < kGrains; ++seed) {
      LoneScene scene({16, 16});
      const SwarmGrain grain{.radius = radius, .seed = seed};
      const Entity entity = scene.show(scene.addBall(), std::span(&grain, 1));
      std::set<size_t> counts;
      for (int step = 0; step <= 32; ++step) {
        const double along = step / 32.0;
        scene.world.find<Transform>(entity)->position = {along, 0.37 * along + 0.02 * seed, 0};
        counts.insert(scene.covered());
      }
      EXPECT_EQ(counts.size(), 1u) << "radius " << radius << ", seed " << seed << ": " << *counts.begin() << " to " << *counts.rbegin() << " pixels";
      EXPECT_LT(std::abs(static_cast<double>(*counts.begin()) - area), 1);
      EXPECT_GE(*counts.begin(), area >= 1 ? 1u : 0u);
      sum += static_cast<double>(*counts.begin());
    }
    std::printf("radius %.2f px: %.3f pixels of %.3f in the mean over %d grains\n", static_cast<double>(radius), sum / kGrains, area, kGrains);
  }
}

TEST_F(LonePoints, CoverTheirAreaInTheMean) {
  for (const float radius : {0.1f, 0.2f, 0.3f, 0.45f, 0.57f, 0.6f, 0.75f, 0.82f, 0.95f}) {
    LoneScene scene({512, 512});
    std::vector<SwarmGrain> grains;
    for (int y = -62; y < 62; ++y)
      for (int x = -62; x < 62; ++x) {
        const uint64_t k = grains.size();
        const vec2 aside(randomUnit(8, k, 0, 0), randomUnit(8, k, 0, 1));
        grains.push_back({.position = vec3(4.0f * static_cast<float>(x) + aside.x, 4.0f * static_cast<float>(y) + aside.y, 0),
                          .radius = radius,
                          .tint = vec3(randomUnit(8, k, 0, 2), randomUnit(8, k, 0, 3), 0.5f),
                          .seed = static_cast<uint16_t>(k)});
      }
    scene.show(scene.addBall(), grains);
    const double area = std::numbers::pi * static_cast<double>(radius * radius);
    const double mean = static_cast<double>(scene.covered()) / static_cast<double>(grains.size());
    std::printf("radius %.2f px: %.4f pixels of %.4f\n", static_cast<double>(radius), mean, area);
    // Three standard deviations of a share of the grains, and what rounds an area to steps.
    const double part = area - std::floor(area);
    EXPECT_NEAR(mean, area, 3 * std::sqrt(part * (1 - part) / static_cast<double>(grains.size())) + 1e-3) << radius;
  }
}

// Grains thinly strewn, so that many have others around them: neither gone nor too many; for denser ones see the README.
TEST_F(LonePoints, ThinCloudsAreThere) {
  for (const float radius : {0.15f, 0.3f, 0.6f})
    for (const double wanted : {0.02, 0.05, 0.15}) {
      LoneScene scene({128, 128});
      const double area = std::numbers::pi * static_cast<double>(radius * radius);
      // Discs at random leave exp(-area a pixel) open.
      const auto count = static_cast<size_t>(-std::log(1 - wanted) / area * 128 * 128);
      std::vector<SwarmGrain> grains(count);
      for (size_t k = 0; k < count; ++k)
        grains[k] = {.position = vec3(randomUnit(9, k, 0, 0), randomUnit(9, k, 0, 1), 0) * 128.0f - vec3(64, 64, 0),
                     .radius = radius, .tint = vec3(randomUnit(9, k, 0, 2)), .seed = static_cast<uint16_t>(k)};
      scene.show(scene.addBall(), grains);
      const double share = static_cast<double>(scene.covered()) / (128 * 128);
      std::printf("radius %.2f px, %zu points: %.3f of the picture, of %.3f\n", static_cast<double>(radius), count, share, wanted);
      EXPECT_GT(share / wanted, 0.9) << radius;
      EXPECT_LT(share / wanted, 1.1) << radius;
    }
}

// It is lit as the whole near side of a ball, whatever share of a pixel it covers.
TEST_F(LonePoints, KeepTheirLightAsTheySlide) {
  LoneScene scene({16, 16});
  scene.sun({0.4, 1, 0.6});
  const SwarmGrain grain{.radius = 0.57f, .tint = vec3(0.5f), .seed = 3};
  const Entity entity = scene.show(scene.addBall(), std::span(&grain, 1));
  double least = 1e30, most = 0;
  for (int step = 0; step <= 32; ++step) {
    scene.world.find<Transform>(entity)->position = {step / 32.0, step / 50.0, 0};
    scene.render();
    const std::vector<vec3> radiance = scene.radiance();
    const std::vector<uint32_t> ids = scene.ids();
    for (size_t k = 0; k < ids.size(); ++k) {
      if (ids[k] == 0) continue;
      least = std::min(least, luminanceOf(dvec3(radiance[k])));
      most = std::max(most, luminanceOf(dvec3(radiance[k])));
    }
  }
  EXPECT_GT(least, 0);
  EXPECT_LT(most / least, 1.002);  // radiance is kept in steps of 0.001 of it
}

}  // namespace
}  // namespace scree::test
