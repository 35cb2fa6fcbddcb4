// A scene pays only for what it contains: passes and counters of scenes without meshes or grains.
#include <algorithm>
#include <fstream>

#include "engine/core/file.h"
#include "engine/gpu/counters.h"
#include "game/rules/game.h"
#include "game/rules/rules.h"
#include "modules/deferred/deferred.h"
#include "modules/overlay/overlay.h"
#include "modules/scene/scene.h"
#include "tests/game/support/program.h"
#include "tests/support/gl_fixture.h"

namespace scree::hourglass {
namespace {

class Skip : public test::GlTest {
 protected:
  std::vector<std::string> passesThatRan(App& app) {
    std::vector<std::string> names;
    for (const PassReport& pass : app.frame().report())
      if (pass.on) names.push_back(pass.name);
    return names;
  }
};

constexpr ivec2 kSize{160, 90};

TEST_F(Skip, AnEmptySceneRunsClearSkyAndPresent) {
  const auto path = scratchFolder("skip") / "empty.gltf";
  std::ofstream(path) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                            "nodes": [{"name": "nothing"}]})";
  Result<std::unique_ptr<App>> opened = openGame({}, path);
  ASSERT_TRUE(opened.ok()) << opened.error();
  App& app = **opened;
  const gpu::Counters before = gpu::counters();
  app.tick();
  app.render(kSize);
  const gpu::Counters first = gpu::counters() - before;
  EXPECT_EQ(passesThatRan(app), (std::vector<std::string>{"deferred.clear", "deferred.sky", "deferred.present"}));
  EXPECT_EQ(first.draws, 2u);  // sky and present: one full-screen triangle each
  EXPECT_EQ(first.dispatches, 0u);
  EXPECT_EQ(first.programs, 2u);

  const gpu::Counters steady_before = gpu::counters();
  for (int i = 0; i < 5; ++i) {
    app.tick();
    app.render(kSize);
  }
  const gpu::Counters steady = gpu::counters() - steady_before;
  EXPECT_EQ(steady.draws, 10u);
  EXPECT_EQ(steady.programs + steady.buffers + steady.textures + steady.framebuffers + steady.readbacks, 0u);
}

TEST_F(Skip, ALevelWithoutGrainsCompilesNoGrainProgram) {
  const auto level = contentRoot() / "levels" / "empty_room.glb";
  // The same scene in an app that has never heard of grains. The first render also makes what the
  // process makes once; the second app's is what counts.
  gpu::Counters without;
  for (int i = 0; i < 2; ++i) {
    App plain({});
    addScene(plain);
    addDeferred(plain);
    ASSERT_TRUE(loadScene(plain, level).ok());
    plain.tick();
    const gpu::Counters before = gpu::counters();
    plain.render(kSize);
    without = gpu::counters() - before;
  }

  Result<std::unique_ptr<App>> opened = openGame({}, level);
  ASSERT_TRUE(opened.ok()) << opened.error();
  App& app = **opened;
  app.tick();
  const gpu::Counters before = gpu::counters();
  app.render(kSize);
  const gpu::Counters with_grains = gpu::counters() - before;
  const auto ran = passesThatRan(app);
  EXPECT_TRUE(std::none_of(ran.begin(), ran.end(),
                           [](const std::string& name) { return name.rfind("grains.", 0) == 0; }));
  EXPECT_NE(std::find(ran.begin(), ran.end(), "deferred.opaque"), ran.end());
  for (const SystemReport& system : app.schedule().report())
    if (system.name.rfind("grains.", 0) == 0) {
      EXPECT_FALSE(system.on) << system.name;
    }

  EXPECT_EQ(with_grains.programs, without.programs);
  EXPECT_EQ(with_grains.draws, without.draws);
  EXPECT_EQ(with_grains.buffers, without.buffers);
  EXPECT_EQ(with_grains.buffer_bytes, without.buffer_bytes);
  EXPECT_EQ(with_grains.texture_bytes, without.texture_bytes);
}

}  // namespace
}  // namespace scree::hourglass
