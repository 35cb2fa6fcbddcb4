// Points beside others: on a floor, of other sizes, of other roughness; and beside nothing.
#include <cstdio>

#include "shaders/shared/octahedral.h"
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class PointsBeside : public GlTest {};

// One layer, strewn so that its balls do not overlap; one pixel is about 1 m.
std::vector<SwarmGrain> layer(float radius, glm::vec2 half) {
  std::vector<SwarmGrain> grains;
  const float step = 2.2f * radius;
  for (float z = -half.y; z < half.y; z += step)
    for (float x = -half.x; x < half.x; x += step) {
      const auto k = static_cast<uint64_t>(grains.size());
      const vec2 aside(randomUnit(4, k, 0, 0) - 0.5f, randomUnit(4, k, 0, 1) - 0.5f);
      grains.push_back({.position = vec3(x + 0.2f * radius * aside.x, radius, z + 0.2f * radius * aside.y),
                        .radius = radius,
                        .tint = vec3(0.5f),
                        .seed = static_cast<uint16_t>(k)});
    }
  return grains;
}

TEST_F(PointsBeside, ALayerOnAFloorIsSeenAsIfThereWereNone) {
  for (const float radius : {0.6f, 0.3f, 0.15f, 0.08f})
    for (const double elevation_deg : {88.0, 60.0, 30.0}) {
      PointScene scene({48, 36});
      const double e = elevation_deg * std::numbers::pi / 180, distance = 200;
      scene.look(dvec3(0, std::sin(e), std::cos(e)) * distance, {0, 0, 0}, static_cast<float>(2 * std::atan(18 / distance)));
      scene.sun({0.4, 1, 0.6});
      const Entity swarm = scene.show(scene.addBall(), layer(radius, {16, 12}));
      scene.world.add(swarm, CastsShadow{});
      const auto shown = [&] {
        scene.render();
        std::vector<uint32_t> ids = scene.ids();
        for (uint32_t& id : ids) id = id == swarm.index + 1;
        return ids;
      };
      const std::vector<uint32_t> without = shown();
      scene.put(scene.mesh(sheetMesh()), scene.material(plainMaterial(vec3(0.2f), 0, 1)), {0, 0, 0}, vec3(100, 1, 100));
      const std::vector<uint32_t> with = shown();
      int inside = 0, lost_inside = 0, at_edge = 0, lost_at_edge = 0;
      for (int y = 1; y + 1 < scene.size.y; ++y)
        for (int x = 1; x + 1 < scene.size.x; ++x) {
          if (without[scene.at(x, y)] == 0) continue;
          uint32_t around = 0;
          for (int k = 0; k < 9; ++k) around += without[scene.at(x + k % 3 - 1, y + k / 3 - 1)];
          const bool lost = with[scene.at(x, y)] == 0;
          (around == 9 ? inside : at_edge) += 1;
          (around == 9 ? lost_inside : lost_at_edge) += lost;
        }
      std::printf("radius %.2f px, from %.0f degrees: of %d pixels inside the layer %d are lost, of %d at its edge %d\n", static_cast<double>(radius),
                  elevation_deg, inside, lost_inside, at_edge, lost_at_edge);
      EXPECT_GT(inside, 200);
      EXPECT_EQ(lost_inside, 0) << radius << " px, from " << elevation_deg << " degrees";
      // There a pixel's grains may lie behind the floor in its middle.
      EXPECT_LE(lost_at_edge, at_edge / 6) << radius << " px, from " << elevation_deg << " degrees";
    }
}

std::vector<float> pictureOf(PointScene& scene) {
  std::vector<float> all = scene.floats(kRadiance, 4);
  for (const std::string_view target : {kGbufferAlbedo, kGbufferNormal, kGbufferDepth}) {
    const std::vector<float> values = scene.floats(target, target == kGbufferDepth ? 1 : 4);
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

TEST_F(PointsBeside, ABoulderThatIsNoPointHereChangesNoPixel) {
  constexpr float kRadius = 0.3f;
  const std::vector<SwarmGrain> bed = pouredBed(kRadius, {20, 20}, 6 * kRadius);
  struct Case {
    const char* name;
    vec3 place;
    float radius;
    bool hidden;
  };
  PointScene scene({32, 24});
  scene.look({0, 100, 170}, {0, 0, 0}, static_cast<float>(2 * std::atan(12.0 / 197)));
  scene.sun({0.4, 1, 0.6});
  scene.drawAs(rules::kNotDrawn);  // by size
  const uint32_t ball = scene.addBall();
  GrainShape leaning = scene.world.singleton<SwarmStore>().shape(ball);
  leaning.facing = 0.7f;
  leaning.roughness = 0.3f;
  const uint32_t other = scene.world.singleton<SwarmStore>().addShape(leaning);
  scene.show(ball, bed);
  scene.render();
  const std::vector<float> wanted = pictureOf(scene);
  // Out of view: as a point, as a mesh; and in it, a mesh behind the bed.
  for (const Case& boulder : {Case{"point", {500, 0, 0}, 0.6f, true}, Case{"mesh", {500, 0, 0}, 50, true}, Case{"mesh", {0, -80, 0}, 20, true}})
    for (const uint32_t shape : {ball, other}) {
      if (shape == other && boulder.radius < 1) continue;  // facing is the mean over what may be points: README.md
      const SwarmGrain grain{.position = boulder.place, .radius = boulder.radius};
      const Entity entity = scene.show(shape, std::span(&grain, 1));
      scene.render();
      EXPECT_EQ(pictureOf(scene), wanted) << boulder.name << " at " << boulder.place.x << ", shape " << shape;
      scene.world.destroy(entity);
    }
  scene.render();
  EXPECT_EQ(pictureOf(scene), wanted);
}

// Of a picture so small that a surface may change by more than its distance from pixel to pixel.
TEST_F(PointsBeside, AnEmptyPixelBendsNoNormal) {
  const auto normalsOf = [](float end) {
    PointScene scene({16, 16});
    scene.look({0, 10, 0}, {0, 0, 0}, 0.5f * std::numbers::pi_v<float>);
    std::vector<SwarmGrain> grains;
    for (float z = -12; z < 12; z += 0.5f)
      for (float x = -12; x < end; x += 0.5f) grains.push_back({.position = {x + 0.25f, 0, z + 0.25f}, .radius = 0.4f, .seed = static_cast<uint16_t>(grains.size())});
    scene.show(scene.addBall(), grains);
    scene.render();
    const std::vector<float> codes = scene.floats(kGbufferNormal, 4);
    std::vector<vec3> normals;
    for (int y = 4; y < 12; ++y)
      for (int x = 5; x < 8; ++x) {
        const size_t at = 4 * scene.at(x, y);
        EXPECT_NE(scene.ids()[scene.at(x, y)], 0u);
        normals.push_back(rules::octDecode(rules::octUnpack24(vec3(codes[at], codes[at + 1], codes[at + 2]))));
      }
    return normals;
  };
  const std::vector<vec3> whole = normalsOf(12), half = normalsOf(0);
  for (size_t k = 0; k < whole.size(); ++k) EXPECT_GT(glm::dot(whole[k], half[k]), 0.99f) << k;
}

// What the G-buffer holds in the middle of a bed of points.
float roughnessOf(const std::vector<SwarmGrain>& bed, float of_shape) {
  PointScene scene({32, 24});
  scene.look({0, 100, 170}, {0, 0, 0}, static_cast<float>(2 * std::atan(12.0 / 197)));
  scene.show(scene.addBall(vec3(1), of_shape), bed);
  scene.render();
  const std::vector<float> normal = scene.floats(kGbufferNormal, 4);
  double sum = 0;
  int count = 0;
  for (int y = 8; y < 16; ++y)
    for (int x = 8; x < 24; ++x, ++count) {
      EXPECT_NE(scene.ids()[scene.at(x, y)], 0u);
      sum += static_cast<double>(normal[4 * scene.at(x, y) + 3]);
    }
  return static_cast<float>(sum / count);
}

TEST_F(PointsBeside, AGrainsOwnRoughnessCounts) {
  std::vector<SwarmGrain> bed = pouredBed(0.3f, {20, 20}, 2);
  for (SwarmGrain& grain : bed) grain.roughness = 1.0f / 3;
  EXPECT_NEAR(roughnessOf(bed, 0.9f), 0.3f, 0.003f) << "one factor for all";
  for (size_t k = 0; k < bed.size(); ++k) bed[k].roughness = k % 2 == 0 ? 0.2f : 0.8f;
  EXPECT_NEAR(roughnessOf(bed, 0.9f), 0.45f, 0.01f) << "the mean of two";
}

}  // namespace
}  // namespace scree::test
