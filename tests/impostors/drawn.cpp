// Drawn impostors: against the mesh, with and without culling, in odd places.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "modules/impostors/impostors.h"
#include "tests/lod/swarm_scene.h"
#include "tests/support/gpu_work.h"

namespace scree::test {
namespace {

class ImpostorsDrawn : public GlTest {};

struct DrawnScene : SwarmScene {
  explicit DrawnScene(ivec2 output = {320, 200}, bool impostors = true) : SwarmScene(output) {
    if (impostors) addImpostors(app);
  }
  uint32_t addBean() {
    Result<uint32_t> shape = loadGrainShape(world, std::string(SCREE_SOURCE_DIR) + "/content/models/coffee_bean.glb",
                                            {.edge = 6, .texels = 64, .directions = 2},
                                            std::string(SCREE_BINARY_DIR) + "/bean_drawn.impostor");
    EXPECT_TRUE(shape.ok());
    return shape.ok() ? *shape : 0;
  }
  std::vector<uint32_t> ids() { return gpu::readUints(app.frame().texture(kGbufferId), 1); }
  // Which grain each pixel shows, + 1.
  std::vector<uint32_t> shown() { return gpu::readUints(app.frame().texture(kSwarmVisible), 1); }
  void only(uint32_t representation) { world.singleton<LodSettings>().only = representation; }
};

double covered(const std::vector<uint32_t>& ids) {
  return static_cast<double>(std::count_if(ids.begin(), ids.end(), [](uint32_t id) { return id != 0; }));
}

TEST_F(ImpostorsDrawn, CoverWhatTheMeshDoes) {
  for (const float radius_px : {2.0f, 5.0f, 12.0f, 40.0f, 160.0f}) {
    DrawnScene scene;
    const float distance = 0.5f * static_cast<float>(scene.size.y) / (std::tan(0.4f) * radius_px);
    scene.look({0, 0, distance}, {0, 0, 0});
    const uint32_t shape = scene.addBean();
    // Many apart from each other, as far as they fit.
    std::vector<SwarmGrain> grains;
    const int across = std::max(1, static_cast<int>(50 / radius_px));
    for (int j = -across; j <= across; ++j)
      for (int i = -across; i <= across; ++i) {
        SwarmGrain grain = cloud(1, 1, 1, 1, static_cast<uint64_t>(1000 + i + 200 * j)).front();
        grain.position = vec3(static_cast<float>(i), static_cast<float>(j), 0) * 2.1f;
        if (across == 1 && (i != 0 || j != 0)) continue;
        grains.push_back(grain);
      }
    scene.show(shape, grains);
    scene.only(rules::kImpostor);
    scene.render();
    const std::vector<uint32_t> impostors = scene.ids();
    scene.only(rules::kMesh);
    scene.render();
    const std::vector<uint32_t> meshes = scene.ids();
    double differing = 0;
    for (size_t k = 0; k < meshes.size(); ++k) differing += (meshes[k] != 0) != (impostors[k] != 0);
    // The mean outline of a bean, pixels.
    const double outline = 2 * std::numbers::pi * 0.75 * static_cast<double>(radius_px) * static_cast<double>(grains.size());
    std::printf("%.0f px: %.0f pixels as meshes, %.0f as impostors; outlines off by %.3f px\n", static_cast<double>(radius_px),
                covered(meshes), covered(impostors), differing / outline);
    EXPECT_GT(covered(meshes), 100);
    EXPECT_NEAR(covered(impostors) / covered(meshes), 1, 0.05) << radius_px;
    EXPECT_LT(differing / outline, std::max(0.25, 0.02 * static_cast<double>(radius_px))) << radius_px;
  }
}

TEST_F(ImpostorsDrawn, CullingChangesNoPixel) {
  DrawnScene scene({256, 160});
  scene.look({0, 0, 4}, {0, 0, 0});
  std::vector<SwarmGrain> grains = cloud(6000, 0.7f, 0.03f, 0.12f);
  scene.show(scene.addBean(), grains);
  scene.only(rules::kImpostor);
  size_t hidden = 0;
  for (uint64_t k = 0; k < 60; ++k) {
    const auto unit = [&](uint32_t at) { return static_cast<double>(randomUnit(4, k, 0, at)); };
    // From outside, from within, right at a grain, jumping about.
    dvec3 from(3 * unit(0) - 1.5, 3 * unit(1) - 1.5, 3 * unit(2) - 1.5);
    if (k % 4 == 1) from *= 0.3;
    if (k % 4 == 2) from = dvec3(grains[k].position) + dvec3(0, 0, static_cast<double>(grains[k].radius));
    scene.look(from, dvec3(unit(3), unit(4), unit(5)) - 0.5, static_cast<float>(0.2 + unit(6)), 0.01f);
    scene.world.singleton<LodSettings>().cull = false;
    scene.render();
    const std::vector<uint32_t> all = scene.shown();
    scene.world.singleton<LodSettings>().cull = true;
    for (int frame = 0; frame < 2; ++frame) {  // the first after the jump, and one that knows it
      scene.render();
      const std::vector<uint32_t> culled = scene.shown();
      size_t wrong = 0;
      for (size_t p = 0; p < all.size(); ++p) wrong += all[p] != culled[p];
      EXPECT_EQ(wrong, 0u) << "view " << k << ", frame " << frame;
    }
    rules::SwarmCommands commands{};
    gpu::readBuffer(*scene.drawn().part(0).commands, &commands, sizeof(commands));
    hidden += grains.size();
    for (const uint32_t r : {rules::kImpostor, rules::kSmallImpostor})
      hidden -= commands.count[r] + commands.count[r + rules::kFirst];
  }
  std::printf("%zu of %zu not drawn\n", hidden, 60 * grains.size());
  EXPECT_GT(hidden, 60 * grains.size() / 4) << "nothing was culled: the test shows nothing";
}

TEST_F(ImpostorsDrawn, DepthIsThatOfTheMesh) {
  DrawnScene scene;
  scene.look({0, 0, 6}, {0, 0, 0});
  scene.show(scene.addBean(), cloud(1, 0.01f, 1, 1, 7));
  scene.only(rules::kImpostor);
  scene.render();
  const std::vector<float> impostor = scene.floats(kGbufferDepth, 1);
  scene.only(rules::kMesh);
  scene.render();
  const std::vector<float> mesh = scene.floats(kGbufferDepth, 1);
  double sum = 0;
  std::vector<double> offs;
  for (size_t k = 0; k < mesh.size(); ++k) {
    if (!(mesh[k] > 0 && impostor[k] > 0)) continue;
    const double off = std::abs(0.1 / static_cast<double>(impostor[k]) - 0.1 / static_cast<double>(mesh[k]));
    sum += off;
    offs.push_back(off);
  }
  ASSERT_GT(offs.size(), 1000u);
  std::sort(offs.begin(), offs.end());
  const double mean = sum / static_cast<double>(offs.size()), p95 = offs[offs.size() * 95 / 100];
  std::printf("%zu pixels, depth off by %.4f on average, %.4f at the 95th percentile, in outer radii\n", offs.size(), mean, p95);
  EXPECT_LT(mean, 0.04);
  EXPECT_LT(p95, 0.1);
}

TEST_F(ImpostorsDrawn, OddPlacesAreFinite) {
  DrawnScene scene;
  const uint32_t shape = scene.addBean();
  scene.only(rules::kImpostor);
  // The eye in a grain, at its surface, at the near plane; a grain beside each edge of the picture; 300 px.
  std::vector<SwarmGrain> grains(8);
  const float half = 5 * std::tan(0.4f);
  const vec3 places[] = {{0, 0, 0}, {0, 0, -1}, {0, 0, -1.1f}, {-1.6f * half - 0.2f, 0, -5}, {1.6f * half + 0.2f, 0, -5},
                         {0, half + 0.2f, -5}, {0, -half - 0.2f, -5}, {0.5f, 0, -2.4f}};
  for (size_t k = 0; k < 8; ++k) grains[k].position = places[k];
  scene.show(shape, grains);
  scene.look({0, 0, 0}, {0, 0, -1});
  for (int frame = 0; frame < 2; ++frame) {
    scene.render();
    for (const float d : scene.floats(kGbufferDepth, 1)) ASSERT_TRUE(std::isfinite(d) && d >= 0 && d <= 1);
    for (const vec3& r : scene.radiance()) ASSERT_TRUE(std::isfinite(r.x + r.y + r.z));
  }
  EXPECT_GT(covered(scene.ids()), 2000);
}

// At the default settings, what is near costs no work of impostors; neither does it once impostors have been drawn.
TEST_F(ImpostorsDrawn, NearGrainsNeedNoImpostorWork) {
  const std::vector<SwarmGrain> grains = cloud(100, 1, 0.9f, 1);
  const auto lookFrom = [](SwarmScene& scene, double distance) {
    scene.look({0, 0, distance}, {0, 0, 0});
    for (int frame = 0; frame < 3; ++frame) scene.render();
    return workOf([&] { scene.render(); });
  };
  DrawnScene without({160, 120}, false), with({160, 120});
  without.show(without.addBean(), grains);
  with.show(with.addBean(), grains);
  const GpuWork near_without = lookFrom(without, 3), far_without = lookFrom(without, 60);
  EXPECT_EQ(lookFrom(with, 3), near_without);
  const GpuWork far = lookFrom(with, 60);
  EXPECT_GT(far.fragments, far_without.fragments);
  EXPECT_GT(far.vertices, far_without.vertices);
  EXPECT_EQ(lookFrom(with, 3), near_without);
}

// Nor a pass, where every grain of the swarm is too near.
TEST_F(ImpostorsDrawn, NearSwarmsRunNoImpostorPass) {
  DrawnScene scene;
  scene.show(scene.addBean(), cloud(10, 0.2f, 0.9f, 1));
  // Runs since the start.
  for (const auto& [distance, runs] : {std::pair{4.0, 0u}, {60.0, 1u}, {4.0, 1u}, {60.0, 2u}}) {
    scene.look({0, 0, distance}, {0, 0, 0});
    scene.render();
    for (const char* pass : {"impostors.visible", "impostors.visible_late", "impostors.resolve"})
      EXPECT_EQ(scene.app.frame().runCount(pass), runs) << pass << " from " << distance;
  }
}

TEST_F(ImpostorsDrawn, NearMeshesNeedNoImpostorWork) {
  DrawnScene scene;
  scene.look({0, 0, 4}, {0, 0, 0});
  scene.world.singleton<LodSettings>().tolerance_px = 0;  // nothing but the mesh is good enough
  scene.show(scene.addBean(), cloud(10, 1, 0.5f, 0.5f));
  scene.render();
  EXPECT_EQ(scene.app.frame().runCount("impostors.visible"), 0u);
  EXPECT_EQ(scene.app.frame().runCount("impostors.resolve"), 0u);
  EXPECT_EQ(scene.app.frame().runCount("lod.meshes"), 1u);
}

}  // namespace
}  // namespace scree::test
