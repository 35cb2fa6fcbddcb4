// The frame and the ticks beside it.
#include "engine/app/app.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <chrono>
#include <filesystem>
#include <future>
#include <stdexcept>
#include <thread>

#include "engine/app/capture.h"
#include "engine/assets/image.h"
#include "tests/support/gl_fixture.h"

namespace scree::test {
namespace {

class AppGpu : public GlTest {
 protected:
  AppGpu() : app_([] {
    AppOptions options;
    options.threads = 2;
    return options;
  }()) {}

  // A pass that is always on.
  void addPass(std::function<void()> run) {
    app_.addPass({.name = "test.draw",
                  .stage = Stage::Present,
                  .uses = {{std::string(Frame::kOutput), Access::Color}},
                  .run = [run](PassContext&) { run(); }});
  }
  App app_;
};

constexpr std::chrono::seconds kLong(60);

TEST_F(AppGpu, MeanwhileRunsOnAnotherThreadWhileThePassesDraw) {
  std::promise<void> from_pass, from_ticks;
  std::future<void> pass_was_here = from_pass.get_future(), ticks_were_here = from_ticks.get_future();
  bool met = false;
  std::thread::id ticking;
  addPass([&] {
    from_pass.set_value();
    met = ticks_were_here.wait_for(kLong) == std::future_status::ready;
  });
  bool met_too = false;
  app_.render({8, 8}, 1, 1, 1, [&] {
    from_ticks.set_value();
    met_too = pass_was_here.wait_for(kLong) == std::future_status::ready;
    ticking = std::this_thread::get_id();
  });
  EXPECT_TRUE(met);
  EXPECT_TRUE(met_too);
  EXPECT_NE(ticking, std::this_thread::get_id());
}

TEST_F(AppGpu, MeanwhileHasEndedWhenRenderReturns) {
  addPass([] {});
  bool done = false;
  app_.render({8, 8}, 1, 1, 1, [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    done = true;
  });
  EXPECT_TRUE(done);
}

// The last sample's passes are the last to read what Prepare made.
TEST_F(AppGpu, OnlyTheLastSampleDrawsBesideTheTicks) {
  int prepared = 0, prepared_at_tick = 0, calls = 0;
  app_.addSystem({.name = "test.prepare", .phase = Phase::Prepare, .run = [&](World&) { ++prepared; }});
  addPass([] {});
  app_.render({8, 8}, 1, 1, 5, [&] {
    ++calls;
    prepared_at_tick = prepared;
  });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(prepared_at_tick, 5);
}

// Ticks run whether or not anybody can see a picture.
TEST_F(AppGpu, MeanwhileRunsForAnOutputOfNoSize) {
  addPass([] { FAIL() << "a pass ran"; });
  bool done = false;
  app_.render({0, 0}, 1, 1, 1, [&] { done = true; });
  EXPECT_TRUE(done);
}

// Which passes are on is decided before the ticks go on.
TEST_F(AppGpu, NeedsAreAskedBeforeTheTicksGoOn) {
  std::promise<void> from_ticks;
  std::future<void> ticking = from_ticks.get_future();
  bool asked_too_late = false;
  app_.addPass({.name = "test.draw",
                .stage = Stage::Present,
                .needs_text = "anything",
                .needs = [&] {
                  asked_too_late |= ticking.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
                  return true;
                },
                .uses = {{std::string(Frame::kOutput), Access::Color}},
                .run = [](PassContext&) {}});
  app_.render({8, 8}, 1, 1, 1, [&] { from_ticks.set_value(); });
  EXPECT_FALSE(asked_too_late);
  EXPECT_EQ(ticking.wait_for(std::chrono::seconds(0)), std::future_status::ready);
}

// Whoever drops what passes read is alone with it.
TEST_F(AppGpu, WaitingForPassesReturnsWhenTheyHaveDrawn) {
  app_.waitForPasses();  // without any it returns at once
  std::promise<void> from_ticks;
  std::future<void> ticking = from_ticks.get_future();
  std::atomic<bool> drawn = false;
  bool drawn_first = false;
  addPass([&] {
    ticking.wait();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    drawn = true;
  });
  app_.render({8, 8}, 1, 1, 1, [&] {
    from_ticks.set_value();
    app_.waitForPasses();
    drawn_first = drawn;
  });
  EXPECT_TRUE(drawn_first);
}

TEST_F(AppGpu, TicksHaveEndedWhenAPassThrows) {
  addPass([] { throw std::runtime_error("torn"); });
  bool done = false;
  EXPECT_THROW(app_.render({8, 8}, 1, 1, 1,
                           [&] {
                             std::this_thread::sleep_for(std::chrono::milliseconds(20));
                             done = true;
                             throw std::runtime_error("spilt");
                           }),
               std::runtime_error);
  EXPECT_TRUE(done);
}

// A contact sheet holds at most 48 frames: when there are more it keeps every second one, and so on.
TEST_F(AppGpu, AContactSheetOfMoreFramesThanItHolds) {
  addPass([] {});
  const auto folder = std::filesystem::temp_directory_path() / ("scree_sheet_" + std::to_string(getpid()));
  for (const int frames : {1, 48, 49, 97, 200}) {
    Result<Capture> capture = Capture::open(folder, false);
    ASSERT_TRUE(capture.ok()) << capture.error();
    for (int k = 0; k < frames; ++k) {
      app_.render({16, 8});
      ASSERT_TRUE(capture->add(app_.frame(), static_cast<uint64_t>(k), {}).ok());
    }
    ASSERT_TRUE(capture->finish().ok());
    Result<ImageData> sheet = loadImage(folder / "contact_sheet.png", ColorEncoding::Srgb);
    ASSERT_TRUE(sheet.ok()) << sheet.error();
    const int kept = frames <= 48 ? frames : frames <= 96 ? (frames + 1) / 2 : frames <= 192 ? (frames + 3) / 4 : (frames + 7) / 8;
    const int columns = static_cast<int>(std::ceil(std::sqrt(kept)));
    EXPECT_EQ(sheet->width, 16 * columns) << frames;
    EXPECT_EQ(sheet->height, 8 * ((kept + columns - 1) / columns)) << frames;
    std::filesystem::remove_all(folder);
  }
}

}  // namespace
}  // namespace scree::test
