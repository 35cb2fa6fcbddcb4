// The depth of casters that stand still is kept: it costs nothing, and shows what a new map would.
#include <functional>
#include <utility>

#include "engine/gpu/counters.h"
#include "engine/gpu/readback.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

class KeptShadows : public GlTest {};

struct Yard : Studio {
  Entity mover, tower, sun_light;
  Yard() : Studio({160, 120}) {
    put(mesh(sheetMesh()), 0, {0, 0, 0}, vec3(6));
    const uint32_t box = mesh(boxMesh());
    tower = put(box, 0, {-1.5, 1, 0}, vec3(0.4f, 1, 0.4f));
    put(box, 0, {1.5, 0.5, -1}, vec3(0.5f));
    mover = put(mesh(sphereMesh(12, 24)), 0, {0, 0.6, 1}, vec3(0.5f));
    sun_light = sun({0.4, 1, 0.3});
    look({0, 4, 7}, {0, 0, 0});
  }
  void place(Entity entity, dvec3 position, bool moving) {
    Transform& now = *world.find<Transform>(entity);
    PreviousTransform& before = *world.find<PreviousTransform>(entity);
    before = previousOf(now);
    now.position = position;
    if (!moving) before = previousOf(now);
  }
  uint64_t drawsOf(std::string_view pass) {
    for (const PassReport& r : app.frame().report())
      if (r.name == pass && r.on) return r.counters.draws;
    return 0;
  }
};

TEST_F(KeptShadows, AStillSceneRedrawsNoCaster) {
  Yard yard;
  yard.render();
  EXPECT_EQ(yard.drawsOf("deferred.shadow"), 3u);  // sheet, boxes, ball
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 5; ++i) {
    yard.look({0.1 * i, 4, 7}, {0, 0, 0});  // the camera may move
    yard.render();
    EXPECT_EQ(yard.drawsOf("deferred.shadow"), 0u) << i;
  }
  const gpu::Counters used = gpu::counters() - before;
  EXPECT_EQ(used.textures + used.framebuffers + used.programs, 0u);
  // Only what moves is drawn, beside the rest once.
  yard.place(yard.mover, {0.2, 0.6, 1}, true);
  yard.render();
  EXPECT_EQ(yard.drawsOf("deferred.shadow"), 3u);
  yard.place(yard.mover, {0.4, 0.6, 1}, true);
  yard.render();
  EXPECT_EQ(yard.drawsOf("deferred.shadow"), 1u);
  // Come to rest: once more all, then none.
  yard.place(yard.mover, {0.4, 0.6, 1}, false);
  yard.render();
  EXPECT_EQ(yard.drawsOf("deferred.shadow"), 3u);
  yard.render();
  EXPECT_EQ(yard.drawsOf("deferred.shadow"), 0u);
}

TEST_F(KeptShadows, ShowWhatANewMapShows) {
  Yard kept;
  kept.render();
  std::vector<std::function<void(Yard&)>> story;
  const auto then = [&](std::function<void(Yard&)> change) {
    story.push_back(std::move(change));
    story.back()(kept);
    kept.render();
    Yard fresh;
    for (const auto& step : story) step(fresh);
    fresh.render();
    EXPECT_EQ(kept.radiance(), fresh.radiance()) << "step " << story.size();
  };
  for (int i = 1; i < 6; ++i)
    then([i](Yard& y) { y.place(y.mover, {0.3 * i, 0.6 + 0.1 * i, 1 - 0.4 * i}, true); });
  then([](Yard& y) { y.look({2, 3, 6}, {0, 0.5, 0}); });
  then([](Yard& y) { y.place(y.mover, {1, 2, 0}, false); });
  then([](Yard& y) { y.look({-3, 3, 5}, {0, 0.5, 0}); });
  then([](Yard& y) { y.place(y.tower, {-0.5, 1, 0.5}, false); });
  then([](Yard& y) { y.world.find<Transform>(y.sun_light)->rotation = lookAlong({0.5, -1, 0.1}); });
  then([](Yard& y) { y.place(y.mover, {1.2, 2, 0}, true); });
  then([](Yard& y) { y.world.singleton<ShadowSettings>().side_texels = 128; });
  then([](Yard& y) { y.world.singleton<ShadowSettings>().side_texels = 512; });
  then([](Yard& y) { y.world.remove<CastsShadow>(y.tower); });
  then([](Yard& y) { y.world.destroy(y.mover); });
}

TEST_F(KeptShadows, MeshesThatAreGoneCastNothing) {
  Yard yard;
  yard.app.frame().keep(kShadowMap, true);
  yard.render();
  std::vector<Entity> meshes;
  yard.world.query<With<MeshInstance>>().each([&](Entity entity) { meshes.push_back(entity); });
  yard.world.destroyMany(meshes);
  // Something else still casts, so that the map is drawn and read.
  int runs = 0;
  yard.app.addSystem({.name = "test.caster", .phase = Phase::Prepare, .run = [&](World& world) {
                        world.singleton<ShadowCasters>().spheres.push_back({{0, 1, 0}, 1});
                        ++runs;
                      }});
  yard.render();
  ASSERT_EQ(runs, 1);
  const gpu::Texture& map = yard.app.frame().texture(kShadowMap);
  for (const float depth : gpu::readFloats(map, 1)) ASSERT_EQ(depth, 0);
}

TEST_F(KeptShadows, MotionIsLeftOutWhereNobodyReadsIt) {
  Yard yard;
  std::vector<float> shown;
  const auto redraws = [&](dvec3 to) {
    yard.place(yard.mover, to, true);
    yard.render();
    const std::vector<float> before = std::exchange(shown, yard.floats(kGbufferMotion, 2));
    return shown != before;
  };
  EXPECT_TRUE(redraws({0.5, 0.6, 1}));
  EXPECT_TRUE(redraws({0.6, 0.6, 1}));
  yard.app.frame().keep(kGbufferMotion, false);
  EXPECT_FALSE(redraws({0.7, 0.6, 1}));
  yard.app.frame().keep(kGbufferMotion, true);
  EXPECT_TRUE(redraws({0.8, 0.6, 1}));
}

}  // namespace
}  // namespace scree::test
