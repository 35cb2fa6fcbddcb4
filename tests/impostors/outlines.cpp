// What the router predicts bounds what is measured: some hundred views, and the measures themselves.
#include "tests/impostors/outlines.h"

#include <numbers>

#include "engine/app/app.h"
#include "modules/impostors/look.h"
#include "modules/impostors/measure.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

struct Outlines : testing::Test {
  World world;
  std::vector<RoutedShape> shapes = routedShapes(world);
};

TEST_F(Outlines, PredictedErrorBoundsMeasuredError) {
  ASSERT_EQ(shapes.size(), 3u);
  for (const RoutedShape& routed : shapes) {
    const LodThresholds t = thresholdsOf(routed.shape, {}, 426);
    std::printf("%s: point < %.2f, small < %.2f, impostor %.2f to %.2f, mesh 1 2 3 < %.1f %.1f %.1f px; outlines full", routed.name.c_str(),
                t.point_px, t.small_px, t.impostor_from_px, t.impostor_px, t.mesh_px[1], t.mesh_px[2], t.mesh_px[3]);
    for (const float x : routed.atlas.errors.outlines.full) std::printf(" %.4f", x);
    std::printf(" +%.3f, small", routed.atlas.errors.outlines.full_near);
    for (const float x : routed.atlas.errors.outlines.small) std::printf(" %.4f", x);
    std::printf(" +%.3f\n", routed.atlas.errors.outlines.small_near);
  }
  expectBounded(shapes, 0, 600);
}

// The masks themselves.

TEST(OutlineMasks, OfABallAreItsCircleInPerspective) {
  const GrainMesh mesh = grainOf(globe(60));
  Result<impostors::UnitGrain> ball = impostors::unitGrain(mesh);
  ASSERT_TRUE(ball.ok());
  for (const float nearness : {0.0f, 0.1f, 0.5f, 0.8f}) {
    const impostors::OutlineView view = impostors::outlineView(glm::normalize(vec3(1, -2, 3)), nearness);
    const impostors::OutlineMask mask = impostors::meshOutline(*ball, view, 80);
    const double area = static_cast<double>(std::ranges::count(mask.covered, 1)) / (80.0 * 80.0);
    const double circle = std::numbers::pi / (1 - static_cast<double>(nearness * nearness));
    EXPECT_NEAR(area / circle, 1, 0.006) << nearness;
  }
}

TEST_F(Outlines, FromAfarAreThoseOfTheTable) {
  const ImpostorAtlas& atlas = shapes.front().atlas;
  for (int k = 0; k < 10; ++k) {
    const impostors::Scene scene = impostors::randomScene(900 + k, 60);
    const auto expected = impostors::impostorMask(atlas, ImpostorScheme::Proxy, scene, 1);
    const int level = rules::impostorLevel(atlas.texels, 60, rules::kImpostorShapeBias);
    const impostors::OutlineMask mask = impostors::impostorOutline(atlas, {scene.axis, scene.right, scene.up, 0}, level, false, 30);
    size_t differing = 0;
    const int margin = (scene.side_px - mask.side) / 2;
    for (int y = 0; y < mask.side; ++y)
      for (int x = 0; x < mask.side; ++x)
        differing += mask.covered[static_cast<size_t>(y * mask.side + x)] !=
                     expected[static_cast<size_t>((y + margin) * scene.side_px + x + margin)];
    EXPECT_LE(differing, 2u) << "rounding alone";
  }
}

// What programs draw, pixel by pixel, up to a nearness of 0.3.
class OutlinesDrawn : public GlTest {};

TEST_F(OutlinesDrawn, AreTheMasks) {
  struct Case {
    float size_px, nearness;
    uint32_t only;
  };
  size_t differing = 0, pixels = 0;
  for (const Case& c : {Case{3, 0.01f, rules::kImpostor}, Case{3, 0.3f, rules::kImpostor}, Case{10, 0.02f, rules::kImpostor}, Case{10, 0.3f, rules::kImpostor},
                        Case{50, 0.05f, rules::kImpostor}, Case{50, 0.3f, rules::kImpostor}, Case{50, 0.3f, rules::kMesh}, Case{10, 0.1f, rules::kMesh}}) {
    SwarmScene scene({160, 128});
    addImpostors(scene.app);
    const std::vector<RoutedShape> shapes = routedShapes(scene.world);
    for (uint32_t k = 0; k < 3; ++k) {
      // Handles are given in the order of the shapes.
      SwarmGrain grain = cloud(1, 1, 1, 1, 40 + k).front();
      grain.position = vec3(0);
      const Entity entity = scene.show(k, std::span(&grain, 1));
      const float distance = 1 / c.nearness, fov = 2 * std::atan(0.5f * static_cast<float>(scene.size.y) * c.nearness / c.size_px);
      scene.look({0, 0, static_cast<double>(distance)}, {0, 0, 0}, fov, 0.01f);
      scene.world.singleton<LodSettings>().only = c.only;
      scene.render();
      const std::vector<uint32_t> ids = scene.ids();
      const vec4 q = rules::unpackRotation(rules::packRotation(vec4(grain.rotation.x, grain.rotation.y, grain.rotation.z, grain.rotation.w)));
      const quat back = glm::conjugate(quat(q.w, q.x, q.y, q.z));
      const impostors::OutlineView view{back * vec3(0, 0, 1), back * vec3(1, 0, 0), back * vec3(0, 1, 0), c.nearness};
      const int level = rules::impostorLevel(shapes[k].atlas.texels, 2 * c.size_px, rules::kImpostorShapeBias);
      const bool small = scene.drawn().mayBe(rules::kSmallImpostor);
      const impostors::OutlineMask mask = c.only == rules::kMesh ? impostors::meshOutline(shapes[k].levels.front(), view, c.size_px)
                                                                 : impostors::impostorOutline(shapes[k].atlas, view, level, small, c.size_px);
      const int left = (scene.size.x - mask.side) / 2, low = (scene.size.y - mask.side) / 2;
      size_t wrong = 0, covered = 0;
      for (int y = 0; y < scene.size.y; ++y)
        for (int x = 0; x < scene.size.x; ++x) {
          const int i = x - left, j = y - low;
          const bool expected = i >= 0 && j >= 0 && i < mask.side && j < mask.side && mask.covered[static_cast<size_t>(j * mask.side + i)] != 0;
          covered += expected;
          wrong += expected != (ids[scene.at(x, y)] == entity.index + 1);
        }
      EXPECT_GT(covered, 0u);
      EXPECT_LE(wrong, 2 + covered / 200) << shapes[k].name << " of " << c.size_px << " px at " << c.nearness << " as " << c.only;
      differing += wrong;
      pixels += covered;
      scene.world.destroy(entity);
    }
  }
  std::printf("%zu of %zu pixels differ\n", differing, pixels);
}

}  // namespace
}  // namespace scree::test
