// One swarm at several entities, entities that move and go, and what is kept of them on the GPU.
#include <cstdio>

#include <gtest/gtest.h>

#include "engine/gpu/counters.h"
#include "tests/support/gl_fixture.h"
#include "tests/swarms/bean_bed.h"

namespace scree::test {
namespace {

class Placements : public GlTest {};

// What three frames end up with.
std::vector<float> depthOf(BeanScene& scene) {
  for (int frame = 0; frame < 3; ++frame) scene.render();
  return scene.floats(kGbufferDepth, 1);
}

// The same swarm at two entities: one at the origin, the other at `second`, spawned in either order.
enum class Spawned { FirstAlone, SecondAlone, InOrder, Reversed };
std::vector<float> depthOfTwo(dvec3 second, Spawned spawned) {
  BeanScene scene({160, 100});
  scene.lookFrom(40, 0.9f);
  const uint32_t swarm = scene.world.singleton<SwarmStore>().add("bed", scene.bean, beanBed(12, 2, 0.3f));
  const auto spawn = [&](dvec3 at) { scene.world.spawn(Transform{.position = at}, Swarm{swarm}); };
  if (spawned == Spawned::Reversed || spawned == Spawned::SecondAlone) spawn(second);
  if (spawned != Spawned::SecondAlone) spawn(dvec3(0));
  if (spawned == Spawned::InOrder) spawn(second);
  return depthOf(scene);
}

TEST_F(Placements, AnotherEntityOutOfViewChangesNothing) {
  const std::vector<float> alone = depthOfTwo({1000, 0, 0}, Spawned::FirstAlone);
  EXPECT_GT(std::ranges::count_if(alone, [](float depth) { return depth > 0; }), 300);
  EXPECT_EQ(depthOfTwo({1000, 0, 0}, Spawned::InOrder), alone);
  EXPECT_EQ(depthOfTwo({1000, 0, 0}, Spawned::Reversed), alone);
}

TEST_F(Placements, TwoEntitiesShowTheNearerOfBoth) {
  const dvec3 second(6, 1, -5);
  const std::vector<float> one = depthOfTwo(second, Spawned::FirstAlone), other = depthOfTwo(second, Spawned::SecondAlone);
  const std::vector<float> both = depthOfTwo(second, Spawned::InOrder);
  ASSERT_EQ(both.size(), one.size());
  // Impostors compete by the depths of their discs, and then have that of their surfaces: where those cross, the other shows.
  size_t other_shown = 0;
  for (size_t p = 0; p < both.size(); ++p) other_shown += both[p] != std::max(one[p], other[p]);
  EXPECT_LT(other_shown, both.size() / 1000);
  EXPECT_NE(both, one);
  EXPECT_NE(both, other);
}

// A bean drawn as mesh and as impostor, moved between two ticks.
TEST_F(Placements, MoveBetweenTicksAndLeaveMotion) {
  for (const uint32_t only : {rules::kMesh, rules::kImpostor}) {
    for (const float alpha : {1.0f, 0.25f}) {
      BeanScene scene({160, 100});
      scene.settings().only = only;
      scene.look({0, 0, 8}, {0, 0, 0});
      const SwarmGrain bean{.position = {0, 0, 0}, .radius = 1};
      const Entity entity = scene.show(scene.bean, std::span(&bean, 1), {0.5, 0.1, 0});
      const PreviousTransform before{.position = {-0.3, -0.2, 0}};
      scene.world.add(entity, before);
      const Transform after = *scene.world.peek<Transform>(entity), eye = *scene.world.peek<Transform>(scene.camera);
      scene.render(1, alpha, 0.5f);
      const std::vector<float> motion = scene.floats(kGbufferMotion, 2);
      const glm::dvec2 now = pixelOf(scene, eye, interpolate(before, after, static_cast<double>(alpha)).position);
      const glm::dvec2 then = pixelOf(scene, eye, interpolate(before, after, static_cast<double>(alpha) - 0.5).position);
      const size_t at = scene.at(static_cast<int>(now.x), static_cast<int>(now.y));
      ASSERT_NE(scene.ids()[at], 0u) << "drawn as " << only << ", alpha " << alpha;
      // Its surface is nearer to the eye than its centre, by up to an eighth of the distance.
      EXPECT_NEAR(static_cast<double>(motion[2 * at]), now.x - then.x, 0.15 * std::abs(now.x - then.x)) << "drawn as " << only;
      EXPECT_NEAR(static_cast<double>(motion[2 * at + 1]), now.y - then.y, 0.15 * std::abs(now.y - then.y)) << "drawn as " << only;
    }
  }
}

TEST_F(Placements, LeaveNothingBehind) {
  BeanScene scene({160, 100});
  scene.lookFrom(40, 0.9f);
  scene.show(scene.bean, beanBed(12, 2, 0.3f));
  for (int frame = 0; frame < 3; ++frame) scene.render();
  const uint64_t before = gpu::counters().live_buffer_bytes;
  const Entity large = scene.show(scene.bean, beanBed(40, 6, 0.3f), {3, 0, 0});
  for (int frame = 0; frame < 3; ++frame) scene.render();
  EXPECT_GT(gpu::counters().live_buffer_bytes, before + 40u * 40 * 6 * 24);
  scene.world.destroy(large);
  for (int frame = 0; frame < 3; ++frame) scene.render();
  EXPECT_EQ(gpu::counters().live_buffer_bytes, before);
}

// With shadows: the sun's map is the largest that is kept.
TEST_F(Placements, NoneLeftTakesNoMemory) {
  BeanScene scene({320, 200});
  scene.settings().only = rules::kImpostor;
  scene.world.singleton<ShadowSettings>().side_texels = 1024;
  scene.lookFrom(40, 0.9f);
  scene.put(scene.mesh(sheetMesh()), scene.material(plainMaterial(vec3(0.5f), 0, 1)), {0, -8, 0}, vec3(20));
  const auto frames = [&] {
    for (int frame = 0; frame < 3; ++frame) scene.render();
    return gpu::counters().live_buffer_bytes;
  };
  const auto kept = [&] {
    const Entity bed = scene.show(scene.bean, beanBed(12, 2, 0.3f));
    scene.world.add(bed, CastsShadow{});
    const uint64_t shown = frames();
    EXPECT_EQ(scene.app.frame().hasContent(kShadowMap), false) << "the map is kept, not drawn anew";
    scene.world.remove<CastsShadow>(bed);
    const uint64_t without_shadow = frames();
    EXPECT_GT(shown, without_shadow + 4 * 1024 * 1024) << "the sun's map";
    scene.world.destroy(bed);
    return frames();
  };
  const uint64_t before = frames(), after = kept(), again = kept();
  EXPECT_EQ(again, after);
  // Streams of uniforms, and what belongs to the shape.
  EXPECT_LT(after, before + 100'000);
  scene.settings().only = rules::kPoint;
  const uint64_t after_points = kept();
  EXPECT_LT(after_points, before + 100'000);
  std::printf("%zu bytes more than before the first swarm, %zu after points\n", static_cast<size_t>(after - before),
              static_cast<size_t>(after_points - before));
}

}  // namespace
}  // namespace scree::test
