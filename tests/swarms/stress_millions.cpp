// Twenty million grains: loaded, routed and drawn, counted against the rules on the CPU, within 32 bytes a grain on the GPU.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/gpu/counters.h"
#include "engine/gpu/gl.h"
#include "tests/swarms/bean_bed.h"

namespace scree::test {
namespace {

constexpr uint64_t kGrains = 20'000'000, kNear = 3000;
constexpr float kRadius = 0.01f, kFar = 30, kFov = 0.8f;

// In and a little around the view from the origin along -Z, dense to the far end; some of them near.
void fillCone(uint64_t first, std::span<rules::SwarmRecord> records) {
  const float reach = 1.1f * std::tan(0.5f * kFov);
  for (size_t k = 0; k < records.size(); ++k) {
    const uint64_t number = first + k;
    const auto unit = [&](uint64_t at) { return randomUnit(12, number, 0, at); };
    const float along = number < kNear ? 0.1f + 0.3f * unit(0) : kFar * std::cbrt(unit(0));
    const vec4 rotation(unit(3) - 0.5f, unit(4) - 0.5f, unit(5) - 0.5f, unit(6) - 0.5f);
    records[k] = {(2 * unit(1) - 1) * reach * along * 16 / 9, (2 * unit(2) - 1) * reach * along, -along, rules::packRotation(rotation),
                  rules::packGrainLook(vec3(unit(7)), 1), rules::packGrainSize(1, static_cast<uint32_t>(number & 0xffff))};
  }
}

class StressMillions : public GlTest {};

// Buffers of a scene with so few grains that they do not count.
uint64_t bytesOfAScene() {
  BeanScene scene({640, 360});
  const std::vector<SwarmGrain> few = cloud(64, 1, 0.01f, 0.02f);
  scene.show(scene.bean, few);
  scene.lookFrom(3, kFov);
  const uint64_t before = gpu::counters().live_buffer_bytes;
  scene.render();
  return gpu::counters().live_buffer_bytes - before;
}

TEST_F(StressMillions, AreLoadedRoutedAndDrawn) {
  const uint64_t fixed = bytesOfAScene();
  auto seconds = [start = std::chrono::steady_clock::now()]() mutable {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start, now)).count();
  };
  BeanScene scene({640, 360});
  SwarmStore& store = scene.world.singleton<SwarmStore>();
  const uint32_t swarm = store.add("grains", scene.bean, kGrains, kRadius, fillCone);
  ASSERT_EQ(store.swarm(swarm).count, kGrains);
  scene.world.spawn(Transform{}, Swarm{swarm});
  scene.look({0, 0, 0}, {0, 0, -1}, kFov, 0.02f);
  std::printf("made in %.1f s\n", seconds());
  const uint64_t before = gpu::counters().live_buffer_bytes;
  scene.render();
  size_t shown = 0;
  for (const vec3& r : scene.radiance()) ASSERT_TRUE(std::isfinite(r.x + r.y + r.z));
  for (const uint32_t id : scene.ids()) shown += id != 0;
  std::printf("first frame, with the upload: %.1f s; %zu pixels show grains\n", seconds(), shown);
  EXPECT_GT(shown, 640u * 360u * 9 / 10);
  const double bytes = static_cast<double>(gpu::counters().live_buffer_bytes - before - fixed) / static_cast<double>(kGrains);
  std::printf("%.3f bytes a grain on the GPU\n", bytes);
  EXPECT_LE(bytes, 32);
  EXPECT_GT(bytes, 24) << "no less than the records";

  // What is hidden is not drawn; without that, routes are those of the rules.
  scene.settings().cull = false;
  scene.render();
  glFinish();
  std::printf("second frame: %.1f s\n", seconds());
  const rules::ViewBlock& view = scene.world.singleton<const View>().block;
  std::array<uint64_t, rules::kFirst> expected{};
  uint64_t doubtful = 0, wrong = 0, compared = 0;
  for (size_t p = 0; p < scene.drawn().size(); ++p) {
    const lod::Part& part = static_cast<const lod::Part&>(scene.drawn().part(p));
    const rules::SwarmBlock block = *static_cast<const rules::SwarmBlock*>(part.early.data);
    const std::vector<uint32_t> words = gpu::readBuffer<uint32_t>(part.routes->representations, (part.count + 7) / 8);
    const std::vector<rules::SwarmRecord>& records = store.swarm(swarm).chunks[p];
    for (uint32_t k = 0; k < part.count; ++k) {
      const rules::SwarmRecord& record = records[k];
      const vec3 center = vec3(block.origin) + vec3(record.x, record.y, record.z);
      const float radius = rules::radiusOf(record.size, block.origin.w), distance = glm::length(center);
      bool outside = false, unsure = false;
      for (const vec4& plane : view.frustum_planes) {
        const float depth = glm::dot(vec3(plane), center) + plane.w;
        outside = outside || depth < -radius;
        unsure = unsure || std::abs(depth + radius) < 1e-5f * distance;
      }
      const float size = rules::sizePx(radius, distance, view.pixels_at_1m), own = rules::ownShare(record.look, record.size);
      const uint32_t route = outside ? rules::kNotDrawn : rules::representationOf(size, own, rules::kNotDrawn, block);
      // Grains drawn in the first frame keep what they were within the band; none moved.
      for (const float s : {0.99999f, 1.00001f})
        unsure = unsure || (!outside && rules::representationOf(size * s, own, rules::kNotDrawn, block) != route);
      ++expected[route];
      doubtful += unsure;
      wrong += !unsure && route != (words[k / 8] >> 4 * (k % 8) & 7);
    }
    compared += part.count;
  }
  EXPECT_EQ(compared, kGrains);
  EXPECT_EQ(wrong, 0u);
  EXPECT_LT(doubtful, kGrains / 5000);
  const auto drawn = scene.drawnAs();
  std::printf("compared in %.1f s; %llu doubtful by rounding\n", seconds(), static_cast<unsigned long long>(doubtful));
  for (uint32_t r = 0; r < rules::kFirst; ++r) {
    std::printf("%u: %llu, by the rules %llu\n", r, static_cast<unsigned long long>(drawn[r]), static_cast<unsigned long long>(expected[r]));
    EXPECT_NEAR(static_cast<double>(drawn[r]), static_cast<double>(expected[r]), static_cast<double>(doubtful)) << r;
  }
  for (const uint32_t r : {rules::kNotDrawn, rules::kPoint, rules::kSmallImpostor, rules::kImpostor, rules::kMesh}) {
    EXPECT_GT(drawn[r], 100u) << r;
  }
}

}  // namespace
}  // namespace scree::test
