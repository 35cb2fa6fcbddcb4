// Points that stand for others: which are drawn, by the rules; and that a camera that goes away sees no grain leave.
#include <cstdio>

#include "modules/lod/state.h"
#include "shaders/shared/points.h"
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class FewPoints : public GlTest {};

// Each adds to the four pixels around it, if it is drawn.
TEST_F(FewPoints, AreThoseOfTheRules) {
  PointScene scene({192, 128});
  constexpr double kAway = 100;
  scene.look({0, 0, kAway}, {0, 0, 0}, static_cast<float>(2 * std::atan(64 / kAway)));  // a pixel is 1 m
  std::vector<SwarmGrain> grains;
  for (int y = -60; y < 60; y += 3)
    for (int x = -90; x < 90; x += 3)
      grains.push_back({.position = vec3(static_cast<float>(x) + 0.8f, static_cast<float>(y) + 0.8f, 0), .radius = 0.03f + 0.001f * static_cast<float>(grains.size() % 120)});
  scene.show(scene.addBall(), grains);
  scene.world.singleton<LodSettings>().view = SwarmView::Overdraw;
  scene.render();
  const std::vector<uint32_t> counts = gpu::readUints(scene.app.frame().texture(kPointOverdraw), 1);
  const auto& part = static_cast<const lod::Part&>(scene.drawn().part(0));
  const rules::SwarmBlock block = *static_cast<const rules::SwarmBlock*>(part.early.data);
  const std::vector<rules::SwarmRecord>& records = scene.world.singleton<SwarmStore>().swarm(0).chunks[0];
  size_t drawn = 0, wrong = 0;
  for (uint32_t k = 0; k < records.size(); ++k) {
    const float radius = rules::radiusOf(records[k].size, block.origin.w);
    const float least_hidden = rules::leastHiddenRank(radius * block.albedo.a * scene.world.singleton<const View>().block.pixels_at_1m / static_cast<float>(kAway));
    const float rank = rules::rankOf(k % rules::kRunGrains, rules::ranksOfRun(k / rules::kRunGrains, block.rank_seed));
    if (std::abs(rank - least_hidden) < 1e-3f) continue;  // rounding decides
    const bool is_drawn = rank < least_hidden;
    drawn += is_drawn;
    const auto x = static_cast<size_t>(records[k].x + 96 - 0.5f), y = static_cast<size_t>(records[k].y + 64 - 0.5f);
    for (size_t at : {scene.at(static_cast<int>(x), static_cast<int>(y)), scene.at(static_cast<int>(x) + 1, static_cast<int>(y) + 1)}) wrong += counts[at] != (is_drawn ? 1u : 0u);
  }
  std::printf("%zu of %zu are drawn\n", drawn, records.size());
  EXPECT_GT(drawn, records.size() / 10);
  EXPECT_LT(drawn, records.size() / 2);
  EXPECT_EQ(wrong, 0u);
}

// Mean over the pixels of how rough the way of each one's luminance is while a camera goes away by a hundredth a step,
// relative to the mean.
double roughness(PointScene& scene, double nearest, int steps) {
  std::vector<std::vector<double>> ways;
  for (int step = 0; step < steps; ++step) {
    const double distance = nearest * std::pow(1.01, step);
    const dvec3 from(0, distance * 0.5, distance * 0.866);
    scene.look(from, {0, 0, 0}, 0.12f);
    scene.render();
    std::vector<double> all;
    for (const vec3& r : scene.radiance()) all.push_back(luminanceOf(dvec3(r)));
    ways.push_back(all);
  }
  double rough = 0, mean = 0;
  for (size_t k = 0; k < ways[0].size(); ++k)
    for (size_t step = 1; step + 1 < ways.size(); ++step) {
      rough += std::abs(ways[step + 1][k] - 2 * ways[step][k] + ways[step - 1][k]);
      mean += ways[step][k];
    }
  return rough / mean;
}

TEST_F(FewPoints, ComeAndGoUnseen) {
  std::array<double, 2> rough{};
  // All of these are drawn; then a third.
  for (const size_t few : {0, 1}) {
    PointScene scene({32, 24});
    scene.sun({0.4, 1, 0.6});
    const float radius = few == 1 ? 0.105f : 0.26f;  // at 200 m a pixel is 1 m
    const Entity bed = scene.show(scene.addBall(vec3(1), 1, 0), pouredBed(radius, {20, 32}, 8 * radius));
    scene.world.add(bed, CastsShadow{});
    rough[few] = roughness(scene, 190, 16);
    std::printf("radius %.3f px: roughness %.4f\n", static_cast<double>(radius), rough[few]);
  }
  EXPECT_LT(rough[1], 1.25 * rough[0]);
}

}  // namespace
}  // namespace scree::test
