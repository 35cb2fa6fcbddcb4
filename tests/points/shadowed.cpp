// The sun's shadow on a bed of points, against meshes in a larger picture.
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class PointShadows : public GlTest {};

// Balls at the places of a turned lattice of dense packing, smaller than would touch, shaken, below y = 0.
std::vector<SwarmGrain> looseBed(float radius, double packing, glm::vec2 half, float depth) {
  const float touching = radius * static_cast<float>(std::cbrt(0.7405 / packing)), step = std::sqrt(2.0f) * touching;
  const quat turn = glm::normalize(quat(0.8f, 0.3f, 0.2f, 0.4f));
  const int across = static_cast<int>(1.5f * std::max(half.x, half.y) / step) + 1;
  std::vector<SwarmGrain> grains;
  uint64_t k = 0;
  for (int z = -across; z <= across; ++z)
    for (int y = -across; y <= across; ++y)
      for (int x = -across; x <= across; ++x) {
        if (((x + y + z) & 1) != 0) continue;
        ++k;
        const auto unit = [&](uint32_t at) { return randomUnit(3, k, 0, at) - 0.5f; };
        const vec3 p = turn * (vec3(x, y, z) * step) + vec3(unit(0), unit(1), unit(2)) * (0.3f * touching);
        if (std::abs(p.x) > half.x || std::abs(p.z) > half.y || p.y > -touching || p.y < -depth) continue;
        grains.push_back({.position = p, .radius = radius, .tint = vec3(0.4f), .seed = static_cast<uint16_t>(k)});
      }
  return grains;
}

double meanOf(const std::vector<vec3>& radiance) {
  double sum = 0;
  for (const vec3& r : radiance) sum += luminanceOf(dvec3(r)) / static_cast<double>(radiance.size());
  return sum;
}

TEST_F(PointShadows, OnABedAreThoseOnMeshes) {
  struct Case {
    double packing, elevation_deg;
  };
  for (const Case& bed : {Case{0.2, 50}, Case{0.35, 75}}) {
    PointScene scene({24, 18});
    const double e = bed.elevation_deg * std::numbers::pi / 180, distance = 200;
    scene.look(dvec3(0, std::sin(e), std::cos(e)) * distance, {0, 0, 0}, static_cast<float>(2 * std::atan(9 / distance)));
    constexpr float kRadius = 0.35f;
    const Entity heap = scene.show(scene.addBall(), looseBed(kRadius, bed.packing, {18, 20}, 5));
    scene.world.singleton<Sky>() = {vec3(0), vec3(0), vec3(0)};
    scene.sun({0.5, 1, 0.3});
    scene.world.singleton<ShadowSettings>().side_texels = rules::kShadowMapSize;  // for both sizes of the picture
    const auto seen = [&](bool shadows, uint32_t representation) {
      if (shadows) scene.world.add(heap, CastsShadow{});
      if (!shadows) scene.world.remove<CastsShadow>(heap);
      scene.drawAs(representation);
      const ivec2 size = scene.size;
      if (representation == rules::kMesh) scene.size = size * 8;
      scene.render();
      const double mean = meanOf(scene.radiance());
      scene.size = size;
      return mean;
    };
    const double mesh = seen(true, rules::kMesh) / seen(false, rules::kMesh), points = seen(true, rules::kPoint) / seen(false, rules::kPoint);
    std::printf("packing %.2f, from %.0f degrees: the sun reaches %.3f of what it would as meshes, %.3f as points\n", bed.packing, bed.elevation_deg, mesh, points);
    EXPECT_LT(mesh, 0.85) << "there is shadow";
    EXPECT_NEAR(points, mesh, 0.25) << "README.md has the figures of heaps";
  }
}

}  // namespace
}  // namespace scree::test
