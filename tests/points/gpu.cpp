// Drawn points against the same grains as meshes with many samples a pixel.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/gpu/counters.h"
#include "modules/points/points.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class Points : public GlTest {};

struct PointScene : SwarmScene {
  explicit PointScene(ivec2 output = {96, 64}) : SwarmScene(output) { addPoints(app); }
  uint32_t addBall() {
    GrainShape shape = ballShape();
    const MeshData mesh = sphereMesh(8, 12);
    setMeanLook(world.singleton<MaterialStore>(), shape, std::span(&mesh, 1));
    return world.singleton<SwarmStore>().addShape(shape);
  }
};

double meanLuminance(const std::vector<vec3>& radiance) {
  double sum = 0;
  for (const vec3& r : radiance) sum += static_cast<double>(r.x) * 0.2126 + static_cast<double>(r.y) * 0.7152 + static_cast<double>(r.z) * 0.0722;
  return sum / static_cast<double>(radiance.size());
}

// A jittered dense bed of balls of this radius, half a metre thick and wide.
std::vector<SwarmGrain> bed(float radius, vec3 half) {
  std::vector<SwarmGrain> grains;
  const float step = 2.1f * radius;
  uint64_t k = 0;
  for (float z = -half.z; z < half.z; z += step)
    for (float y = -half.y; y < half.y; y += step)
      for (float x = -half.x; x < half.x; x += step, ++k) {
        SwarmGrain grain;
        const auto unit = [&](uint32_t at) { return randomUnit(9, k, 0, at) - 0.5f; };
        grain.position = vec3(x, y, z) + vec3(unit(0), unit(1), unit(2)) * (0.4f * radius);
        grain.radius = radius;
        const float tint = 0.5f + 0.8f * unit(3);
        grain.tint = vec3(tint, 0.8f * tint, 0.6f * tint);
        grains.push_back(grain);
      }
  return grains;
}

TEST_F(Points, CoverABed) {
  PointScene scene;
  scene.sun({1, 2, 1.5});
  scene.look({0, 4, 10}, {0, 0, 0});
  scene.show(scene.addBall(), bed(0.05f, {10, 0.3f, 10}));
  scene.world.singleton<LodSettings>().only = rules::kPoint;
  scene.render();
  const std::vector<uint32_t> id = gpu::readUints(scene.app.frame().texture(kGbufferId), 1);
  const auto covered = std::count_if(id.begin(), id.end(), [](uint32_t v) { return v != 0; });
  EXPECT_GT(covered, static_cast<long>(id.size() / 2));
}

TEST_F(Points, MeanLuminanceIsThatOfManySamples) {
  for (const float radius_px : {0.5f, 0.3f}) {
    PointScene scene;
    scene.uniformSky(vec3(0.3f));
    scene.sun({1, 2, 1.5});
    const double distance = 10, tan_y = std::tan(0.4);
    const float pixel = static_cast<float>(2 * distance * tan_y / scene.size.y);
    const float radius = radius_px * pixel;
    scene.look({0, distance * 0.4, distance}, {0, 0, 0});
    const std::vector<SwarmGrain> grains = bed(radius, {static_cast<float>(distance), 10 * radius, static_cast<float>(distance)});
    std::printf("%.2f px: %zu grains\n", static_cast<double>(radius_px), grains.size());
    scene.show(scene.addBall(), grains);
    scene.world.singleton<LodSettings>().only = rules::kPoint;
    scene.render();
    const double points = meanLuminance(scene.radiance());
    scene.world.singleton<LodSettings>().only = rules::kMesh + 3;
    scene.render(16);
    const double truth = meanLuminance(scene.radiance(kTruth));
    std::printf("%.2f px: mean luminance %.4f as points, %.4f by 16 samples a pixel: %+.1f %%\n", static_cast<double>(radius_px), points, truth,
                100 * (points / truth - 1));
  }
}

}  // namespace
}  // namespace scree::test
