// The shadow map is drawn in frames in which some shadow is another than before, and in no other: after every kind of
// change, of all that casts, the picture is that of a new world in the same state.
#include <functional>

#include "engine/gpu/counters.h"
#include "modules/grains/grains.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class ShadowsKept : public GlTest {};

constexpr std::array<std::string_view, 3> kCasting = {"deferred.shadow", "lod.shadow", "grains.shadow"};

// Meshes, two swarms and grains over a ground that casts nothing, in the light of a sun.
struct Yard : SwarmScene {
  Entity box, ball, lamp;
  std::vector<Entity> swarms, grains;
  uint32_t box_mesh = 0, ball_mesh = 0, rough_mesh = 0, pebble = 0, plain = 0;
  float alpha = 1;
  int samples = 1;

  Yard() : SwarmScene({160, 120}) {
    addGrains(app);
    world.singleton<LodSettings>().band = 0;  // what frames showed before is of no account
    uniformSky(vec3(0.2f));
    plain = material(plainMaterial(vec3(0.8f), 0, 1));
    world.remove<CastsShadow>(put(mesh(sheetMesh()), plain, {0, 0, 0}, vec3(30)));
    box_mesh = mesh(boxMesh());
    ball_mesh = mesh(sphereMesh(12, 24));
    rough_mesh = mesh(sphereMesh(4, 8));
    box = put(box_mesh, plain, {-2, 1, 0}, vec3(0.4f, 0.8f, 0.4f));
    ball = put(ball_mesh, plain, {0, 1.2, 1.5}, vec3(0.5f));
    pebble = addShape();
    addSwarm(0, {2, 1, 0});
    addSwarm(1, {0, 1, -2});
    grainField(world).origin = {0, 1, 0};
    grainField(world).placed = true;
    for (int k = 0; k < 40; ++k) addGrain(k);
    lamp = sun({0.4, 1, 0.3});
    look({0, 6, 8}, {0, 0, 0});
  }
  static std::vector<SwarmGrain> pebbles(uint64_t seed) { return cloud(300, 0.6f, 0.05f, 0.1f, seed); }
  void addSwarm(uint64_t seed, dvec3 origin) {
    swarms.push_back(show(pebble, pebbles(seed), origin));
    world.add(swarms.back(), CastsShadow{});
  }
  void addGrain(int k) {
    GrainSpec spec;
    spec.grain = {vec3(0.2f * static_cast<float>(k % 8) - 0.7f, 0.1f, 0.2f * static_cast<float>(k / 8)), 0.08f};
    spawnGrains(world, std::span(&spec, 1));
    grains.clear();
    world.query<With<Grain>>().each([&](Entity e) { grains.push_back(e); });
  }
  // At alpha between where it was and `to`; or there already.
  void moveMesh(Entity entity, dvec3 to, bool still) {
    Transform& now = *world.find<Transform>(entity);
    *world.find<PreviousTransform>(entity) = previousOf(now);
    now.position = to;
    if (still) *world.find<PreviousTransform>(entity) = previousOf(now);
  }
  void moveGrain(size_t index, vec3 by, bool still) {
    Grain& grain = *world.find<Grain>(grains[index]);
    world.find<GrainPrevious>(grains[index])->position = still ? grain.position + by : grain.position;
    grain.position += by;
  }
  void draw() { render(samples, alpha); }
  size_t passesOn() {
    size_t on = 0;
    for (const PassReport& r : app.frame().report())
      on += r.on && std::find(kCasting.begin(), kCasting.end(), r.name) != kCasting.end();
    return on;
  }
  std::array<uint64_t, 3> runs() {
    std::array<uint64_t, 3> counts{};
    for (size_t k = 0; k < 3; ++k) counts[k] = app.frame().runCount(kCasting[k]);
    return counts;
  }
};

// A world that goes through changes and draws each, beside new ones that draw only once.
struct Story {
  using Step = std::function<void(Yard&)>;
  Yard kept;
  std::vector<Step> steps;

  Story() { kept.draw(); }
  // `drawn`: how many of the three passes run after it, once.
  void then(const char* what, size_t drawn, Step step) {
    steps.push_back(std::move(step));
    steps.back()(kept);
    const std::array<uint64_t, 3> before = kept.runs();
    kept.draw();
    const std::array<uint64_t, 3> after = kept.runs();
    size_t ran = 0, runs = 0;
    for (size_t k = 0; k < 3; ++k) {
      ran += after[k] > before[k];
      runs += after[k] - before[k];
    }
    EXPECT_EQ(ran, drawn) << what;
    EXPECT_EQ(runs, drawn) << what << ": more often than once";
    Yard fresh;
    for (const Step& each : steps) each(fresh);
    fresh.draw();
    const std::vector<vec3> wanted = fresh.radiance();
    EXPECT_TRUE(kept.radiance() == wanted) << what;
    kept.draw();
    EXPECT_EQ(kept.passesOn(), 0u) << what << ": and nothing after it";
    EXPECT_TRUE(kept.radiance() == wanted) << what << ": kept";
  }
};

TEST_F(ShadowsKept, AStillSceneDrawsNone) {
  Yard yard;
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 3u);
  const std::vector<vec3> first = yard.radiance();
  const auto before = yard.runs();
  for (int frame = 0; frame < 3; ++frame) {
    yard.draw();
    EXPECT_TRUE(yard.radiance() == first) << frame;
    for (const PassReport& r : yard.app.frame().report())
      if (std::find(kCasting.begin(), kCasting.end(), r.name) != kCasting.end()) {
        EXPECT_FALSE(r.on) << r.name;
        EXPECT_NE(r.why.find("a shadow that has changed"), std::string::npos) << r.why;
      }
  }
  EXPECT_EQ(yard.runs(), before);
}

TEST_F(ShadowsKept, Meshes) {
  Story story;
  story.then("moved", 3, [](Yard& y) { y.moveMesh(y.box, {-2, 1, 0.5}, true); });
  story.then("turned", 3, [](Yard& y) {
    y.world.find<Transform>(y.box)->rotation = glm::angleAxis(0.7f, vec3(0, 1, 0));
    y.moveMesh(y.box, {-2, 1, 0.5}, true);
  });
  story.then("scaled, in the same sphere", 3, [](Yard& y) {
    y.world.find<Transform>(y.box)->scale = {0.8f, 0.4f, 0.4f};
    y.moveMesh(y.box, {-2, 1, 0.5}, true);
  });
  story.then("moving", 3, [](Yard& y) { y.alpha = 0.25f, y.moveMesh(y.ball, {0.5, 1.2, 1.2}, false); });
  story.then("further between two ticks", 3, [](Yard& y) { y.alpha = 0.75f; });
  story.then("comes to rest", 3, [](Yard& y) { y.moveMesh(y.ball, {0.5, 1.2, 1.2}, true); });
  story.then("another mesh", 3, [](Yard& y) { y.world.find<MeshInstance>(y.box)->mesh = y.ball_mesh; });
  story.then("a material that hides it", 3, [](Yard& y) {
    MaterialData hidden = plainMaterial(vec3(0.8f), 0, 1);
    hidden.alpha_mode = AlphaMode::Mask;
    hidden.base_color.w = 0.2f;
    y.world.find<MeshInstance>(y.box)->material = y.material(hidden);
  });
  story.then("and back", 3, [](Yard& y) { y.world.find<MeshInstance>(y.box)->material = y.plain; });
  story.then("casts no more", 3, [](Yard& y) { y.world.remove<CastsShadow>(y.box); });
  story.then("casts again", 3, [](Yard& y) { y.world.add(y.box, CastsShadow{}); });
  story.then("moves on", 3, [](Yard& y) { y.alpha = 0.5f, y.moveMesh(y.ball, {0.6, 1.3, 1.2}, false); });
  story.then("is gone while it moves", 3, [](Yard& y) { y.world.destroy(y.ball); });
  // As large, and its batch has the same number.
  story.then("another mesh instead of the only one", 3, [](Yard& y) { y.world.find<MeshInstance>(y.box)->mesh = y.rough_mesh; });
  story.then("one more", 3, [](Yard& y) { y.ball = y.put(y.box_mesh, y.plain, {0, 2, 1}, vec3(0.2f)); });
  story.then("none", 3, [](Yard& y) { y.world.destroyMany(std::array{y.ball, y.box}); });
}

TEST_F(ShadowsKept, Swarms) {
  Story story;
  // As old and about as large.
  story.then("another one", 3, [](Yard& y) { *y.world.find<Swarm>(y.swarms[0]) = Swarm{1}; });
  story.then("its own", 3, [](Yard& y) { *y.world.find<Swarm>(y.swarms[0]) = Swarm{0}; });
  story.then("moved", 3, [](Yard& y) { y.world.find<Transform>(y.swarms[0])->position.z += 0.4; });
  story.then("replaced", 3, [](Yard& y) { y.world.singleton<SwarmStore>().replace(0, Yard::pebbles(7)); });
  story.then("fewer", 3, [](Yard& y) {
    y.world.singleton<SwarmStore>().replace(1, cloud(40, 0.6f, 0.05f, 0.1f, 8));
  });
  story.then("casts no more", 3, [](Yard& y) { y.world.remove<CastsShadow>(y.swarms[0]); });
  story.then("casts again", 3, [](Yard& y) { y.world.add(y.swarms[0], CastsShadow{}); });
  story.then("moving", 3, [](Yard& y) {
    const Transform before = *y.world.find<Transform>(y.swarms[1]);
    y.world.add(y.swarms[1], previousOf(before));
    y.world.find<Transform>(y.swarms[1])->position.x += 0.6;
    y.alpha = 0.25f;
  });
  story.then("further between two ticks", 3, [](Yard& y) { y.alpha = 0.5f; });
  story.then("one more", 3, [](Yard& y) { y.addSwarm(9, {-1, 1, 2}); });
  story.then("one is gone", 3, [](Yard& y) { y.world.destroy(y.swarms[2]); });
  story.then("one is empty", 3, [](Yard& y) { y.world.singleton<SwarmStore>().replace(1, {}); });
  story.then("none, and the rest keeps its shadow", 2, [](Yard& y) {
    y.world.destroyMany(std::array{y.swarms[0], y.swarms[1]});
  });
  story.then("one again", 3, [](Yard& y) { y.addSwarm(3, {2, 1, 0}); });
}

TEST_F(ShadowsKept, Grains) {
  Story story;
  story.then("moved", 3, [](Yard& y) { y.moveGrain(3, {0, 0.1f, 0.3f}, true); });
  story.then("larger", 3, [](Yard& y) { y.world.find<Grain>(y.grains[5])->radius = 0.12f; });
  story.then("moving", 3, [](Yard& y) { y.alpha = 0.25f, y.moveGrain(8, {0, 0.2f, 0.4f}, false); });
  story.then("further between two ticks", 3, [](Yard& y) { y.alpha = 0.75f; });
  story.then("comes to rest", 3, [](Yard& y) { y.moveGrain(8, {0, 0, 0}, true); });
  story.then("one more", 3, [](Yard& y) { y.addGrain(60); });
  story.then("one is gone", 3, [](Yard& y) { y.world.destroy(y.grains[12]); });
  story.then("all elsewhere", 3, [](Yard& y) { grainField(y.world).origin = {0.5, 1, 0}; });
  story.then("seen from elsewhere: drawn relative to the camera", 3, [](Yard& y) { y.look({0.5, 6, 8}, {0, 0, 0}); });
  story.then("simulated", 3, [](Yard& y) { y.alpha = 0.5f, y.app.tick(); });
  story.then("none, and the rest keeps its shadow", 2, [](Yard& y) {
    std::vector<Entity> all;
    y.world.query<With<Grain>>().each([&](Entity e) { all.push_back(e); });
    y.world.destroyMany(all);
  });
  story.then("seen from elsewhere, without them", 0, [](Yard& y) { y.look({-0.5, 6, 8}, {0, 0, 0}); });
  story.then("some again", 3, [](Yard& y) { y.addGrain(4); });
}

TEST_F(ShadowsKept, SunAndSettings) {
  Story story;
  story.then("sun turned", 3, [](Yard& y) { y.world.find<Transform>(y.lamp)->rotation = lookAlong({0.5, -1, 0.1}); });
  story.then("sun brighter", 0, [](Yard& y) { y.world.find<Light>(y.lamp)->intensity = 4; });
  story.then("no sun", 0, [](Yard& y) { y.world.find<Light>(y.lamp)->intensity = 0; });
  // Without a sun there was no caster, and what is new has no older version.
  story.then("sun again", 3, [](Yard& y) { y.world.find<Light>(y.lamp)->intensity = 3; });
  story.then("small map", 3, [](Yard& y) { y.world.singleton<ShadowSettings>().side_texels = 128; });
  story.then("large map", 3, [](Yard& y) { y.world.singleton<ShadowSettings>().side_texels = 1024; });
  story.then("short reach", 3, [](Yard& y) { y.world.singleton<ShadowSettings>().max_distance_m = 7.5f; });
  story.then("long reach", 3, [](Yard& y) { y.world.singleton<ShadowSettings>().max_distance_m = 100; });
  story.then("one fetch", 0, [](Yard& y) { y.world.singleton<ShadowSettings>().single_fetch = true; });
  story.then("larger picture, a map by its height", 3, [](Yard& y) {
    y.world.singleton<ShadowSettings>().side_texels = 0;
    y.size = {256, 192};
  });
  story.then("smaller picture", 3, [](Yard& y) { y.size = {160, 120}; });
  story.then("wider picture: the same map", 0, [](Yard& y) { y.size = {200, 120}; });
  story.then("out of reach", 0, [](Yard& y) { y.world.singleton<ShadowSettings>().max_distance_m = 0.01f; });
  story.then("in reach again", 3, [](Yard& y) { y.world.singleton<ShadowSettings>().max_distance_m = 100; });
}

TEST_F(ShadowsKept, NoCasterAtAllAndBack) {
  Story story;
  const auto all = [](Yard& y, auto&& change) {
    std::vector<Entity> casters;
    y.world.query<With<CastsShadow>>().each([&](Entity e) { casters.push_back(e); });
    for (const Entity e : casters) change(e);
  };
  story.then("no grains", 2, [](Yard& y) { y.world.destroyMany(y.grains); });
  story.then("nothing casts", 0, [all](Yard& y) {
    all(y, [&](Entity e) { y.world.remove<CastsShadow>(e); });
  });
  story.then("a mesh does", 1, [](Yard& y) { y.world.add(y.box, CastsShadow{}); });
  story.then("a swarm instead", 2, [](Yard& y) {
    y.world.remove<CastsShadow>(y.box);
    y.world.add(y.swarms[0], CastsShadow{});
  });
  story.then("a mesh again", 1, [](Yard& y) {
    y.world.remove<CastsShadow>(y.swarms[0]);
    y.world.add(y.box, CastsShadow{});
  });
  story.then("nothing", 0, [](Yard& y) { y.world.remove<CastsShadow>(y.box); });
}

TEST_F(ShadowsKept, ManySamplesDrawItOnce) {
  Story story;
  story.then("four", 0, [](Yard& y) { y.samples = 4; });
  story.then("of a mesh that moved", 3, [](Yard& y) { y.moveMesh(y.box, {-2, 1, 0.5}, true); });
  story.then("of all that moves", 3, [](Yard& y) {
    y.alpha = 0.5f;
    y.moveMesh(y.ball, {0.5, 1.2, 1.2}, false);
    y.moveGrain(8, {0, 0.2f, 0.4f}, false);
    y.world.find<Transform>(y.swarms[0])->position.z += 0.4;
  });
  story.then("one", 0, [](Yard& y) { y.samples = 1; });
}

// The mean of many samples too.
TEST_F(ShadowsKept, TruthIsThatOfANewWorld) {
  Yard kept, fresh;
  kept.draw();
  for (Yard* yard : {&kept, &fresh}) {
    yard->samples = 8;
    yard->moveMesh(yard->box, {-2, 1, 0.5}, true);
    yard->draw();
  }
  EXPECT_TRUE(kept.radiance(kTruth) == fresh.radiance(kTruth));
}

TEST_F(ShadowsKept, WhoeverDoesNotTellIsDrawnInEachFrame) {
  Yard yard;
  int spheres = 1, runs = 0;
  yard.app.addSystem({.name = "test.caster", .phase = Phase::Prepare, .run = [&](World& world) {
                        for (int k = 0; k < spheres; ++k)
                          world.singleton<ShadowCasters>().spheres.push_back({{0, 1, 0}, 0.1f});
                      }});
  yard.app.addPass({.name = "test.shadow",
                    .stage = Stage::Geometry,
                    .needs = [&] { return spheres > 0 && shadowsWanted(yard.world); },
                    .uses = shadowUses(),
                    .run = [&](PassContext& context) {
                      ++runs;
                      if (runs == 3) context.framebuffer->clearDepth(1);  // all is in shadow
                    }});
  yard.draw();
  yard.draw();
  EXPECT_EQ(runs, 2);
  const std::vector<vec3> before = yard.radiance();
  yard.draw();
  EXPECT_EQ(runs, 3);
  EXPECT_FALSE(yard.radiance() == before);
  // Gone: what it left is not taken for the rest, which is as it was.
  spheres = 0;
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 3u);
  EXPECT_TRUE(yard.radiance() == before);
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 0u);
}

TEST_F(ShadowsKept, ReloadedProgramsDrawItAnew) {
  Yard yard;
  yard.draw();
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 0u);
  ++gpu::counters().reloads;
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 3u);
  EXPECT_GT(yard.app.frame().runCount("lod.shadow"), 1u);
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 0u);
}

// The decision alone, as --print-frame asks for it, is not taken for a map that was drawn.
TEST_F(ShadowsKept, DecidingIsNotDrawing) {
  Yard yard;
  yard.draw();
  yard.draw();
  yard.moveMesh(yard.box, {-2, 1, 0.5}, true);
  yard.size = {0, 0};  // a minimised window: no pass runs
  yard.draw();
  yard.size = {160, 120};
  yard.draw();
  EXPECT_EQ(yard.passesOn(), 3u);
}

// A heap that sleeps casts the shadow that it has.
TEST_F(ShadowsKept, GrainsAtRest) {
  Yard yard;
  const Transform at{dvec3(0, 0, 0), quat(1, 0, 0, 0), vec3(1)};
  yard.world.spawn(at, PlaneCollider{});
  yard.draw();
  int tick = 0;
  const auto kept = [&] {
    yard.app.tick();
    yard.draw();
    return yard.passesOn() == 0;
  };
  while (!kept() && tick < 2000) ++tick;
  std::printf("kept after %d ticks\n", tick);
  ASSERT_LT(tick, 2000);
  EXPECT_GT(tick, 10);
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(kept()) << k;
}

}  // namespace
}  // namespace scree::test
