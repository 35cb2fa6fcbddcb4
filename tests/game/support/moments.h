// The moments of the committed win that have golden pictures, and a test that plays to them.
#pragma once

#include <fmt/format.h>

#include <array>
#include <memory>
#include <string>

#include "engine/core/file.h"
#include "engine/gpu/readback.h"
#include "engine/platform/replay.h"
#include "game/rules/game.h"
#include "modules/deferred/deferred.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/image_expect.h"

namespace scree::hourglass {

inline constexpr ivec2 kMomentSize{480, 270};
// Start, first push, grains falling, and on to the end: ticks of the replay.
inline constexpr std::array<uint64_t, 6> kMoments{1, 130, 260, 520, 900, 1320};

inline std::string momentName(uint64_t tick) { return fmt::format("game/moment_{:06}", tick); }

// Bounds for another machine: its rounding may move silhouettes of thousands of grains. Goldens that
// came from elsewhere once differed by one or two steps in a tenth of the textured pixels, 0.03 steps
// in the mean (a step of the 8-bit albedo is up to two of the picture); that the processor was the
// cause is likely, not proven. So the 99.9th percentile says no more than the largest difference
// here, and mean and bias are held the tighter.
inline images::GateBounds momentBounds() {
  images::GateBounds bounds = images::crossMachineBounds(kMomentSize.x * kMomentSize.y / 1000);
  bounds.max_p999 = bounds.max_difference;
  bounds.max_mean_difference = 0.1 / 255;
  bounds.max_bias = 0.05 / 255;
  return bounds;
}

class MomentTest : public test::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    Result<std::unique_ptr<App>> app = openGame({}, contentRoot() / "levels" / "level1.glb");
    ASSERT_TRUE(app.ok()) << app.error();
    app_ = std::move(*app);
    app_->frame().keep(kGbufferId, true);
    Result<Replay> replay =
        readReplay(std::filesystem::path(SCREE_SOURCE_DIR) / "tests/game/replays/level1_win.replay",
                   &app_->actions());
    ASSERT_TRUE(replay.ok()) << replay.error();
    player_ = std::make_unique<ReplayPlayer>(std::move(*replay), app_->actions());
  }

  void TearDown() override {
    app_.reset();
    GlTest::TearDown();
  }

  void playTo(uint64_t tick) {
    while (app_->tickIndex() < tick) {
      ASSERT_FALSE(player_->finished()) << "the replay ends at tick " << app_->tickIndex();
      player_->tick(app_->world().singleton<ActionState>());
      app_->tick();
    }
  }

  images::Image draw() {
    app_->render(kMomentSize);
    const Frame& frame = app_->frame();
    images::Image image = images::imageFromBytes(kMomentSize.x, kMomentSize.y, 4,
                                                 gpu::readBytes(frame.texture(Frame::kOutput), 4),
                                                 RowOrder::BottomUp);
    images::setIds(image, gpu::readUints(frame.texture(kGbufferId), 1), RowOrder::BottomUp);
    return image;
  }

  std::unique_ptr<App> app_;
  std::unique_ptr<ReplayPlayer> player_;
};

}  // namespace scree::hourglass
