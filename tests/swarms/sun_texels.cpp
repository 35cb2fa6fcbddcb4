// Discs about as small as a texel of the sun's map: which texels they cover, against a search in double precision.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class SunTexels : public GlTest {};

const dvec3 kToSun = glm::normalize(dvec3(0.4, 1, 0.25));
constexpr int kSide = 64;  // texels

// A layer of grains across the light, 4 m wide.
struct Layer : SwarmScene {
  std::vector<SwarmGrain> grains;
  std::vector<dvec3> texels;    // where the map has them: x, y in texels, z its depth
  std::vector<double> radii;    // texels
  std::vector<float> depth;     // of the map, kSide x kSide; 0: open

  // `across` x `across` grains at shaken places, `radius(k)` texels each.
  template <class Radius>
  Layer(int across, const Radius& radius) : SwarmScene({64, 48}) {
    world.singleton<ShadowSettings>().side_texels = kSide;
    app.frame().keep(kShadowMap, true);
    sun(kToSun);
    look({0, 0, 8}, {0, 0, 0});
    const dvec3 u = glm::normalize(glm::cross(dvec3(0, 0, 1), kToSun)), v = glm::cross(kToSun, u);
    for (int k = 0; k < across * across; ++k) {
      const auto shaken = [&](int cell, uint32_t at) {
        return 4 * ((cell + 0.5 + 0.2 * (randomUnit(5, static_cast<uint64_t>(k), 0, at) - 0.5)) / across - 0.5);
      };
      const double along = randomUnit(5, static_cast<uint64_t>(k), 0, 2) - 0.5;
      const dvec3 position = shaken(k % across, 0) * u + shaken(k / across, 1) * v + along * kToSun;
      grains.push_back({.position = vec3(position), .radius = 0.01f});
    }
    world.add(show(addShape(), grains), CastsShadow{});
    render();
    const double guess = static_cast<double>(world.singleton<const ShadowView>().block.texel_m);
    for (size_t k = 0; k < grains.size(); ++k) grains[k].radius = static_cast<float>(radius(k) * guess);
    world.singleton<SwarmStore>().replace(0, grains);
    render();
    const rules::ShadowViewBlock& map = world.singleton<const ShadowView>().block;
    const dvec3 eye = world.singleton<const View>().position;
    for (const SwarmGrain& grain : grains) {
      texels.push_back(dvec3(glm::dmat4(map.shadow_from_relative) * glm::dvec4(dvec3(grain.position) - eye, 1)));
      radii.push_back(static_cast<double>(grain.radius) / static_cast<double>(map.texel_m));
    }
    const std::vector<float> whole = floats(kShadowMap, 1);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) depth.push_back(whole[static_cast<size_t>(y * rules::kShadowMapSize + x)]);
  }
  static size_t texel(int x, int y) { return static_cast<size_t>(y * kSide + x); }
};

// Far apart: those with middles in the disc, and the one that its middle is in.
TEST_F(SunTexels, AreThoseThatADiscCovers) {
  const Layer layer(16, [](size_t k) { return 0.1 + 0.65 * static_cast<double>(k) / 255; });
  enum : uint8_t { kOpen, kCovered, kEither };
  std::vector<uint8_t> expected(kSide * kSide, kOpen);
  std::vector<double> depth(kSide * kSide);
  size_t without_middle = 0;
  for (size_t k = 0; k < layer.grains.size(); ++k) {
    const dvec3 p = layer.texels[k];
    // In which of two texels its middle is may be told otherwise.
    const double from_edge = std::min({p.x - std::floor(p.x), std::ceil(p.x) - p.x, p.y - std::floor(p.y), std::ceil(p.y) - p.y});
    bool middle = false;
    for (int y = static_cast<int>(p.y) - 1; y <= static_cast<int>(p.y) + 1; ++y)
      for (int x = static_cast<int>(p.x) - 1; x <= static_cast<int>(p.x) + 1; ++x) {
        const double within = layer.radii[k] - std::hypot(x + 0.5 - p.x, y + 0.5 - p.y);
        middle |= within > 0;
        const bool own = x == std::floor(p.x) && y == std::floor(p.y);
        const bool in_doubt = from_edge < 1e-3 || (!own && std::abs(within) < 1e-3);
        if (!own && within < 0 && !in_doubt) continue;
        expected[Layer::texel(x, y)] = in_doubt ? kEither : kCovered;
        depth[Layer::texel(x, y)] = p.z;
      }
    without_middle += !middle;
  }
  size_t covered = 0;
  for (size_t t = 0; t < expected.size(); ++t) {
    if (expected[t] == kEither) continue;
    covered += expected[t];
    EXPECT_EQ(layer.depth[t] > 0, expected[t] == kCovered) << t % kSide << ", " << t / kSide;
    if (expected[t] != kCovered) continue;
    EXPECT_NEAR(static_cast<double>(layer.depth[t]), depth[t], 2.0 / 65535);
  }
  std::printf("%zu discs, %zu of them without a texel's middle, cover %zu texels\n", layer.grains.size(), without_middle,
              covered);
  EXPECT_GT(without_middle, 20u);
}

TEST_F(SunTexels, OfADenseLayerAreAllClosed) {
  for (const double radius : {0.1, 0.3, 0.45, 0.55, 0.6, 0.7}) {
    const Layer layer(160, [radius](size_t) { return radius; });
    std::vector<double> nearest(kSide * kSide);
    for (const dvec3& p : layer.texels) {
      // Nearer than this to an edge it may count as beyond.
      const glm::dvec2 in(p.x - std::floor(p.x), p.y - std::floor(p.y));
      if (std::min({in.x, in.y, 1 - in.x, 1 - in.y}) < 1e-3) continue;
      double& most = nearest[Layer::texel(static_cast<int>(p.x), static_cast<int>(p.y))];
      most = std::max(most, p.z);
    }
    size_t covered = 0, open = 0;
    for (size_t t = 0; t < nearest.size(); ++t) {
      if (nearest[t] == 0) continue;
      ++covered;
      open += layer.depth[t] == 0;
      EXPECT_GT(static_cast<double>(layer.depth[t]), nearest[t] - 2.0 / 65535) << "a nearer disc is missing";
    }
    std::printf("radius %.2f texels: %zu of %zu texels with grains are open\n", layer.radii[0], open, covered);
    EXPECT_GT(covered, 1000u);
    EXPECT_EQ(open, 0u);
  }
}

}  // namespace
}  // namespace scree::test
