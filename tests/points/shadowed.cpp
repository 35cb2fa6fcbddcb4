// The sun's shadow on a bed of points, against meshes in a larger picture.
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class PointShadows : public GlTest {};

// Balls at random places where they do not overlap, below y = 0.
std::vector<SwarmGrain> randomBed(float radius, double packing, glm::vec2 half, float depth) {
  const float cell = 2 * radius;
  const glm::ivec3 cells(vec3(2 * half.x, depth, 2 * half.y) / cell + 3.0f);
  std::vector<std::vector<vec3>> places(static_cast<size_t>(cells.x) * static_cast<size_t>(cells.y) * static_cast<size_t>(cells.z));
  const auto at = [&](glm::ivec3 c) -> std::vector<vec3>& { return places[static_cast<size_t>((c.y * cells.z + c.z) * cells.x + c.x)]; };
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(static_cast<double>(radius), 3);
  const auto wanted = static_cast<size_t>(packing * 4 * static_cast<double>(half.x * half.y * depth) / ball);
  std::vector<SwarmGrain> grains;
  for (uint64_t attempt = 0; grains.size() < wanted && attempt < 60'000'000; ++attempt) {
    const auto unit = [&](uint32_t k) { return randomUnit(5, attempt, 0, k); };
    const vec3 p((2 * unit(0) - 1) * half.x, -radius - unit(1) * (depth - radius), (2 * unit(2) - 1) * half.y);
    const glm::ivec3 c = glm::ivec3((p + vec3(half.x, depth, half.y)) / cell) + 1;
    bool free = true;
    for (int k = 0; free && k < 27; ++k)
      for (const vec3& other : at(c + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1))) free = free && glm::dot(other - p, other - p) >= cell * cell;
    if (!free) continue;
    at(c).push_back(p);
    grains.push_back({.position = p, .radius = radius, .seed = static_cast<uint16_t>(grains.size())});
  }
  EXPECT_EQ(grains.size(), wanted);
  return grains;
}

double meanOf(const std::vector<vec3>& radiance) {
  double sum = 0;
  for (const vec3& r : radiance) sum += luminanceOf(dvec3(r)) / static_cast<double>(radiance.size());
  return sum;
}

// Share of the sun that reaches a bed, in the mean over six views, at two sizes of the shadow map's texels.
TEST_F(PointShadows, OnABedAreThoseOnMeshes) {
  constexpr double kPoured = 0.55;
  const dvec3 suns[] = {{0.5, 1, 0.3}, {-1, 0.5, 0.2}};
  const double elevations[] = {75, 45, 25};
  struct Case {
    double packing;
    float radius;
    int sides[2];
  };
  for (const Case& bed : {Case{0.2, 0.35f, {512, 192}}, Case{0.35, 0.35f, {2048, 192}}, Case{0.35, 0.15f, {2048, 512}}, Case{kPoured, 0.35f, {512, 192}}}) {
    const bool small = bed.radius < 0.3f;
    const glm::vec2 half = small ? glm::vec2(11, 13) : glm::vec2(18, 20);
    const ivec2 size = small ? ivec2(14, 10) : ivec2(24, 18);
    std::vector<SwarmGrain> grains = bed.packing == kPoured ? pouredBed(bed.radius, half, 8 * bed.radius) : randomBed(bed.radius, bed.packing, half, 14 * bed.radius);
    for (SwarmGrain& grain : grains) grain.tint = vec3(0.4f);
    double sums[2][2] = {}, texels[2] = {};  // by representation and map
    for (const int points : {0, 1}) {
      PointScene scene(points != 0 ? size : size * 8);
      scene.drawAs(points != 0 ? rules::kPoint : rules::kMesh);
      const Entity heap = scene.show(scene.addBall(), grains);
      scene.world.singleton<Sky>() = {vec3(0), vec3(0), vec3(0)};
      ShadowSettings& shadows = scene.world.singleton<ShadowSettings>();
      shadows.max_distance_m = 1000;
      for (const dvec3& to_sun : suns) {
        const Entity sun = scene.sun(to_sun);
        for (const double elevation : elevations) {
          const double e = elevation * std::numbers::pi / 180, distance = 200;
          scene.look(dvec3(0, std::sin(e), std::cos(e)) * distance, {0, 0, 0}, static_cast<float>(2 * std::atan(0.5 * size.y / distance)));
          scene.render();
          const double open = meanOf(scene.radiance());
          scene.world.add(heap, CastsShadow{});
          for (const int k : {0, 1}) {
            shadows.side_texels = bed.sides[k];
            scene.render();
            sums[points][k] += meanOf(scene.radiance()) / open / 6;
            texels[k] = static_cast<double>(bed.radius / scene.world.singleton<const ShadowView>().block.texel_m);
          }
          scene.world.remove<CastsShadow>(heap);
        }
        scene.world.destroy(sun);
      }
    }
    for (const int k : {0, 1}) {
      std::printf("packing %.2f, radius %.2f px and %.2f texels: the sun reaches %.3f of what it would as meshes, %.3f as points\n", bed.packing,
                  static_cast<double>(bed.radius), texels[k], sums[0][k], sums[1][k]);
      EXPECT_LT(sums[0][k], 0.85) << "there is shadow";
      EXPECT_NEAR(sums[1][k], sums[0][k], 0.1) << bed.packing << ", " << bed.radius << " px, " << texels[k] << " texels";
    }
  }
}

}  // namespace
}  // namespace scree::test
