// Drawn points: what they cover, their ids, how steady they are, and that no frame leaves something to the next.
#include <algorithm>
#include <cstdio>
#include <set>

#include "engine/core/hash.h"
#include "engine/gpu/counters.h"
#include "shaders/shared/gbuffer.h"
#include "tests/points/bed.h"
#include "tests/support/gpu_work.h"

namespace scree::test {
namespace {

class Points : public GlTest {};

// A bed that ends within the picture; a pixel in its middle is about 1 m.
struct HeapScene : PointScene {
  std::vector<SwarmGrain> grains;
  std::vector<Entity> entities;
  // Grain k is in swarm k % swarms.
  explicit HeapScene(float radius, ivec2 output = {48, 36}, size_t swarms = 1) : PointScene(output) {
    sun({0.4, 1, 0.6});
    lookFrom(0);
    grains = pouredBed(radius, {14, 20}, 6 * radius);
    const uint32_t ball = addBall();
    for (size_t k = 0; k < swarms; ++k) {
      std::vector<SwarmGrain> own;
      for (size_t at = k; at < grains.size(); at += swarms) own.push_back(grains[at]);
      entities.push_back(show(ball, own));
    }
  }
  void lookFrom(double aside) {
    const dvec3 at(aside, 0, 0);
    look(at + dvec3(0, 100, 170), at, static_cast<float>(2 * std::atan(0.5 * size.y / 197)));
  }
};

TEST_F(Points, CoverABedAndNothingBeside) {
  for (const float radius : {0.82f, 0.6f, 0.3f, 0.15f, 0.08f}) {
    HeapScene scene(radius);
    scene.render();
    const std::vector<uint32_t> ids = scene.ids();
    const SeenByRays seen(scene, scene.grains);
    const auto share = [&](int x, int y) {
      double hits = 0;
      for (int j = 0; j < SeenByRays::kRays; ++j)
        for (int i = 0; i < SeenByRays::kRays; ++i)
          hits += seen.hits[static_cast<size_t>((y * SeenByRays::kRays + j) * seen.rays.x + x * SeenByRays::kRays + i)].ball >= 0;
      return hits / (SeenByRays::kRays * SeenByRays::kRays);
    };
    int inside = 0, holes = 0, outside = 0, beside = 0;
    for (int y = 1; y + 1 < scene.size.y; ++y)
      for (int x = 1; x + 1 < scene.size.x; ++x) {
        double least = 1, most = 0;
        for (int k = 0; k < 9; ++k) {
          const double s = share(x + k % 3 - 1, y + k / 3 - 1);
          least = std::min(least, s), most = std::max(most, s);
        }
        const bool drawn = ids[scene.at(x, y)] != 0;
        inside += least > 0.95, holes += least > 0.95 && !drawn;
        outside += most == 0, beside += most == 0 && drawn;
      }
    std::printf("radius %.2f px: %d pixels within the bed, %d holes; %d beside it, %d drawn\n", static_cast<double>(radius), inside, holes, outside, beside);
    EXPECT_GT(inside, 200);
    EXPECT_GT(outside, 200);
    EXPECT_EQ(holes, 0);
    EXPECT_EQ(beside, 0);
  }
}

TEST_F(Points, IdsAreOfGrainsAround) {
  constexpr size_t kSwarms = 40;
  HeapScene scene(0.6f, {48, 36}, kSwarms);
  scene.render();
  const std::vector<uint32_t> ids = scene.ids();
  const Transform& eye = *scene.world.peek<Transform>(scene.camera);
  const auto isNear = [&](size_t swarm, int x, int y) {
    for (size_t k = swarm; k < scene.grains.size(); k += kSwarms) {
      const glm::dvec2 at = pixelOf(scene, eye, dvec3(scene.grains[k].position));
      if (std::abs(at.x - x - 0.5) < 1.51 && std::abs(at.y - y - 0.5) < 1.51) return true;
    }
    return false;
  };
  std::set<uint32_t> shown;
  for (int y = 0; y < scene.size.y; ++y)
    for (int x = 0; x < scene.size.x; ++x) {
      const uint32_t id = ids[scene.at(x, y)];
      if (id == 0) continue;
      shown.insert(id);
      const auto found = std::find_if(scene.entities.begin(), scene.entities.end(), [&](Entity e) { return e.index + 1 == id; });
      ASSERT_NE(found, scene.entities.end()) << id;
      EXPECT_TRUE(isNear(static_cast<size_t>(found - scene.entities.begin()), x, y)) << x << " " << y;
    }
  EXPECT_EQ(shown.size(), kSwarms);
}

// Runs of grains in the order of space, of which most are hidden as a whole; and in no order, where none is. All are drawn.
TEST_F(Points, HiddenRunsChangeNothing) {
  for (const float radius : {0.6f, 0.9f}) {
    std::vector<SwarmGrain> grains = cloud(60000, 9, 0.4f * radius, radius);
    const auto pictureOf = [&](bool in_order) {
      PointScene scene({64, 48});
      scene.sun({0.4, 1, 0.6});
      SwarmStore& store = scene.world.singleton<SwarmStore>();
      const uint32_t ball = scene.addBall();
      const uint32_t sorted = store.add("sorted", ball, grains);
      const float largest = store.swarm(sorted).largest_radius;
      const uint32_t given = store.add("given", ball, grains.size(), largest, [&](uint64_t first, std::span<rules::SwarmRecord> records) {
        for (size_t k = 0; k < records.size(); ++k) records[k] = packed(grains[first + k], largest);
      });
      scene.world.spawn(Transform{}, Swarm{in_order ? sorted : given});
      uint64_t hash = 0;
      for (const dvec3& from : {dvec3(0, 40, 120), dvec3(-100, -60, 10), dvec3(3, 2, 14), dvec3(0, 0, 4)}) {
        scene.look(from, {0, 0, 0}, static_cast<float>(2 * std::atan(24 / glm::length(from))));
        scene.render();
        const std::vector<float> radiance = scene.floats(kRadiance, 4);
        hash = hashBytes(radiance.data(), radiance.size() * sizeof(float), hash);
      }
      return hash;
    };
    EXPECT_EQ(pictureOf(true), pictureOf(false)) << radius;
  }
}

double deviation(const std::vector<double>& values) {
  double sum = 0, sum2 = 0;
  for (const double v : values) sum += v, sum2 += v * v;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(std::max(sum2 / n - sum * sum / n / n, 0.0));
}

TEST_F(Points, FlickerNoMoreThanManySamples) {
  for (const float radius : {0.5f, 0.25f}) {
    HeapScene scene(radius, {32, 24});
    const int steps = radius < 0.3f ? 6 : 16;  // many meshes
    std::vector<std::vector<double>> points(static_cast<size_t>(scene.size.x * scene.size.y)), samples = points;
    std::vector<int> covered(points.size());
    for (int step = 0; step < steps; ++step) {
      scene.lookFrom(static_cast<double>(step) / steps);
      scene.drawAs(rules::kPoint);
      scene.render();
      const std::vector<vec3> drawn = scene.radiance();
      const std::vector<uint32_t> ids = scene.ids();
      scene.drawAs(rules::kMesh);
      scene.render(16);
      const std::vector<vec3> truth = scene.radiance(kTruth);
      for (size_t k = 0; k < points.size(); ++k) {
        points[k].push_back(luminanceOf(dvec3(drawn[k])));
        samples[k].push_back(luminanceOf(dvec3(truth[k])));
        covered[k] += ids[k] != 0;
      }
    }
    double of_points = 0, of_samples = 0;
    int count = 0;
    for (size_t k = 0; k < points.size(); ++k) {
      if (covered[k] < steps) continue;
      of_points += deviation(points[k]), of_samples += deviation(samples[k]), ++count;
    }
    std::printf("radius %.2f px: deviation %.4f as points, %.4f by 16 samples a pixel, over %d pixels\n", static_cast<double>(radius),
                of_points / count, of_samples / count, count);
    EXPECT_GT(count, 100);
    EXPECT_LE(of_points, of_samples);
  }
}

uint64_t hashOf(PointScene& scene) {
  const std::vector<float> radiance = scene.floats(kRadiance, 4);
  const std::vector<uint32_t> ids = scene.ids();
  return hashCombine(hashBytes(radiance.data(), radiance.size() * sizeof(float)), hashBytes(ids.data(), ids.size() * sizeof(uint32_t)));
}

// Each of these frames could leave sums behind; the one after must be as if it had not been.
TEST_F(Points, FramesLeaveNothingBehind) {
  HeapScene scene(0.3f);
  const ivec2 size = scene.size;
  const auto again = [&] {
    scene.size = size;
    scene.lookFrom(0);
    scene.drawAs(rules::kPoint);
    scene.render();
    return hashOf(scene);
  };
  const uint64_t wanted = again();
  EXPECT_EQ(again(), wanted);
  for (const double aside : {-20.0, 20.0, 300.0}) {  // at the edge, beyond it
    scene.lookFrom(aside);
    scene.render();
    EXPECT_EQ(again(), wanted) << aside;
  }
  scene.render(16);
  EXPECT_EQ(again(), wanted) << "truth mode";
  scene.drawAs(rules::kMesh);
  scene.render();
  EXPECT_EQ(again(), wanted) << "no points";
  scene.drawAs(rules::kNotDrawn);
  scene.render();
  EXPECT_EQ(again(), wanted) << "by size";
}

TEST_F(Points, OtherSizesLeaveNothingBehind) {
  HeapScene scene(0.3f);
  const ivec2 size = scene.size;
  scene.render();
  const uint64_t wanted = hashOf(scene);
  for (const ivec2 other : {ivec2(17, 90), ivec2(5, 3), ivec2(200, 31)}) {
    scene.size = other;
    scene.render();
    scene.size = size;
    scene.render();
    EXPECT_EQ(hashOf(scene), wanted) << other.x;
  }
}

TEST_F(Points, AMillionAtOnePlaceKeepTheirColor) {
  for (const float radius : {0.05f, 0.1f, 0.2f, 0.7f}) {
    PointScene scene({16, 16});
    scene.uniformSky(vec3(1));
    scene.look({0, 0, 100}, {0, 0, 0}, static_cast<float>(2 * std::atan(0.08)));
    std::vector<SwarmGrain> grains(1000000);
    for (size_t k = 0; k < grains.size(); ++k) grains[k] = {.position = {0.5f, 0.5f, 0}, .radius = radius, .tint = k % 2 == 0 ? vec3(0.8f, 0.4f, 0.1f) : vec3(0.2f, 0.4f, 0.3f)};
    scene.show(scene.addBall(), grains);
    scene.render();
    const std::vector<float> albedo = scene.floats(kGbufferAlbedo, 4);
    const size_t at = scene.at(8, 8);
    ASSERT_NE(scene.ids()[at], 0u);
    const vec3 color = rules::albedoFromCode(vec3(albedo[4 * at], albedo[4 * at + 1], albedo[4 * at + 2]));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(color[k], vec3(0.5f, 0.4f, 0.2f)[k], 0.01f) << radius << " " << k;
    scene.render();
    EXPECT_EQ(scene.floats(kGbufferAlbedo, 4), albedo);
  }
}

TEST_F(Points, SwarmsOfTwoMaterialsMix) {
  PointScene scene({32, 32});
  scene.look({0, 0, 100}, {0, 0, 0}, static_cast<float>(2 * std::atan(0.16)));
  std::vector<SwarmGrain> grains;
  for (int y = -12; y < 12; ++y)
    for (int x = -12; x < 12; ++x)
      for (int k = 0; k < 2; ++k) grains.push_back({.position = vec3(static_cast<float>(x) + 0.5f * static_cast<float>(k), static_cast<float>(y), 0), .radius = 0.5f});
  scene.show(scene.addBall(vec3(1), 1, 1), grains);
  scene.show(scene.addBall(vec3(1), 1, 0), grains);
  scene.show(scene.addBall(), {});  // none
  scene.render();
  const std::vector<float> albedo = scene.floats(kGbufferAlbedo, 4);
  for (int y = 10; y < 22; ++y)
    for (int x = 10; x < 22; ++x) EXPECT_NEAR(rules::metallicSpreadFromCode(albedo[4 * scene.at(x, y) + 3]).metallic, 0.5f, 0.01f) << x << " " << y;
}

// At the default settings, what is near costs no work of points; neither does it once points have been drawn.
TEST_F(Points, NearGrainsNeedNoPointWork) {
  const std::vector<SwarmGrain> grains = cloud(200, 1, 0.05f, 0.1f);
  const auto lookFrom = [](SwarmScene& scene, double distance) {
    scene.look({0, 0, distance}, {0, 0, 0});
    for (int frame = 0; frame < 3; ++frame) scene.render();
    return workOf([&] { scene.render(); });
  };
  SwarmScene without({96, 64});
  without.show(without.addShape(), grains);
  const GpuWork near_without = lookFrom(without, 4), far_without = lookFrom(without, 300);
  PointScene with({96, 64});
  with.drawAs(rules::kNotDrawn);
  with.show(with.addShape(), grains);
  EXPECT_EQ(lookFrom(with, 4), near_without);
  const GpuWork far = lookFrom(with, 300);
  EXPECT_GT(far.fragments, far_without.fragments);
  EXPECT_GT(far.computed, far_without.computed);
  EXPECT_EQ(lookFrom(with, 4), near_without);
}

TEST_F(Points, NoneCostNothing) {
  PointScene scene({32, 32});
  scene.look({0, 0, 100}, {0, 0, 0});
  const Entity entity = scene.show(scene.addBall(), {});
  scene.render();
  for (const uint32_t id : scene.ids()) EXPECT_EQ(id, 0u);
  scene.world.destroy(entity);
  // A swarm too near for points, which then have no pass; farther away it has them.
  const auto runsPoints = [&] {
    scene.render();
    const std::vector<std::string> passes = scene.passes();
    return std::ranges::any_of(passes, [](const std::string& pass) { return pass.starts_with("points."); });
  };
  scene.world.singleton<LodSettings>().only = rules::kNotDrawn;
  const SwarmGrain ball{.radius = 9};
  const Entity near = scene.show(scene.addBall(), {&ball, 1});
  EXPECT_FALSE(runsPoints());
  scene.look({0, 0, 1e6}, {0, 0, 0});
  EXPECT_TRUE(runsPoints());
  scene.world.destroy(near);
  scene.render();
  for (const std::string& pass : scene.passes()) EXPECT_EQ(pass.find("points."), std::string::npos) << pass;
}

}  // namespace
}  // namespace scree::test
