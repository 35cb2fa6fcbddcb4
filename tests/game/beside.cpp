// The game's ticks beside its frame's passes: restarts, pauses and all, the course is that of ticks alone.
#include <array>
#include <functional>
#include <vector>

#include "engine/core/file.h"
#include "engine/platform/input.h"
#include "game/rules/game.h"
#include "game/rules/rules.h"
#include "tests/support/gl_fixture.h"

namespace scree::hourglass {
namespace {

class Beside : public test::GlTest {
 protected:
  static constexpr int kFrames = 60, kTicksAFrame = 3;

  // State hashes of all ticks of a bot's play, with presses between.
  static std::vector<uint64_t> play(bool drawing, bool beside) {
    Result<std::unique_ptr<App>> opened = openGame({}, contentRoot() / "levels" / "level1.glb");
    EXPECT_TRUE(opened.ok()) << opened.error();
    App& app = **opened;
    World& world = app.world();
    std::vector<uint64_t> hashes;
    const auto tick = [&] {
      const Controls& controls = world.singleton<const Controls>();
      const size_t n = hashes.size();
      std::array<int16_t, kMaxActions> values{};
      values[controls.move_y] = quantise(1);
      values[controls.restart] = quantise(n == 50 || n == 100 ? 1 : 0);
      values[controls.pause] = quantise(n == 70 || n == 80 ? 1 : 0);
      values[controls.inspect] = quantise(n == 85 || n == 130 ? 1 : 0);
      world.singleton<ActionState>().begin(values);
      app.tick();
      hashes.push_back(world.stateHash());
    };
    const auto ticks = [&] {
      for (int i = 0; i < kTicksAFrame; ++i) tick();
    };
    for (int frame = 0; frame < kFrames; ++frame) {
      if (!beside) ticks();
      if (drawing) app.render({160, 90}, 1, 1, 1, beside ? std::function<void()>(ticks) : nullptr);
    }
    return hashes;
  }
};

TEST_F(Beside, TheCourseIsThatOfTicksAlone) {
  const std::vector<uint64_t> alone = play(false, false);
  ASSERT_EQ(alone.size(), size_t{kFrames * kTicksAFrame});
  EXPECT_EQ(play(true, true), alone);
}

}  // namespace
}  // namespace scree::hourglass
