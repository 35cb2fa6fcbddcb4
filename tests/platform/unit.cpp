// Fixed step, quantisation, the action sampler on synthetic input, file watch, names of contexts.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "engine/core/random.h"
#include "engine/platform/context.h"
#include "engine/platform/file_watch.h"
#include "engine/platform/fixed_step.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

constexpr double kStep = 1.0 / 60.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(FixedStep, OneTickForEachStepOfTime) {
  FixedStep step;
  for (int i = 0; i < 100000; ++i) ASSERT_EQ(step.advance(kStep), 1) << i;
  EXPECT_EQ(step.alpha(), 0);
  EXPECT_EQ(step.droppedSeconds(), 0);
}

TEST(FixedStep, TicksFollowRealTimeAtAnyFrameRate) {
  for (double hertz : {7.0, 24.0, 59.94, 60.0, 75.0, 144.0, 1000.0}) {
    FixedStep step(kStep, 10);
    long double real_s = 0;
    int64_t ticks = 0;
    for (int frame = 0; frame < 20000; ++frame) {
      const double elapsed_s = 1.0 / hertz;
      real_s += elapsed_s;
      ticks += step.advance(elapsed_s);
      ASSERT_GE(step.alpha(), 0.0f);
      ASSERT_LT(step.alpha(), 1.0f);
      // Ticks and the rest that is owed add up to the real time.
      ASSERT_NEAR(static_cast<double>(real_s), (static_cast<double>(ticks) + step.alpha()) * kStep,
                  1e-5 * kStep + 1e-9 * static_cast<double>(real_s));
    }
    EXPECT_EQ(step.droppedSeconds(), 0) << hertz;
  }
}

TEST(FixedStep, CatchUpIsBoundedAndTheRestIsDropped) {
  FixedStep step(kStep, 5);
  EXPECT_EQ(step.advance(12.25 * kStep), 5);
  EXPECT_NEAR(step.droppedSeconds(), 7 * kStep, 1e-12);
  EXPECT_NEAR(step.alpha(), 0.25f, 1e-5f);
  // Nothing is owed from before: no spiral.
  EXPECT_EQ(step.advance(0.5 * kStep), 0);
  EXPECT_EQ(step.advance(5 * kStep), 5);
  EXPECT_NEAR(step.alpha(), 0.75f, 1e-5f);
}

TEST(FixedStep, HostileTimesDoNoHarm) {
  FixedStep step;
  for (double bad : {-1.0, -kInfinity, kInfinity, std::nan(""), 0.0, -0.0}) {
    EXPECT_EQ(step.advance(bad), 0) << bad;
    EXPECT_EQ(step.alpha(), 0) << bad;
  }
  for (double huge : {1e3, 1e9, 1e18, 1e300, std::numeric_limits<double>::max()}) {
    EXPECT_EQ(step.advance(huge), 5) << huge;
    EXPECT_GE(step.alpha(), 0.0f);
    EXPECT_LT(step.alpha(), 1.0f);
  }
  step.reset();
  EXPECT_EQ(step.advance(1e-300), 0);
  EXPECT_EQ(step.advance(kStep), 1);
}

TEST(Quantise, StepsAreExactAndSymmetric) {
  for (int i = -32767; i <= 32767; ++i) {
    const auto value = static_cast<int16_t>(i);
    ASSERT_EQ(quantise(actionValue(value)), value);
    ASSERT_EQ(actionValue(static_cast<int16_t>(-i)), -actionValue(value));
  }
  EXPECT_EQ(actionValue(kFullValue), 1.0f);
}

TEST(Quantise, NearestStepWithinTheRange) {
  for (uint64_t i = 0; i < 100000; ++i) {
    const float value = 2 * randomUnit(1, i, 0, 0) - 1;
    ASSERT_LE(std::abs(static_cast<double>(quantise(value)) / 32767 - value), 0.5 / 32767 + 1e-9);
  }
  EXPECT_EQ(quantise(2), 32767);
  EXPECT_EQ(quantise(-2), -32767);
  EXPECT_EQ(quantise(std::numeric_limits<float>::infinity()), 32767);
  EXPECT_EQ(quantise(-std::numeric_limits<float>::infinity()), -32767);
  EXPECT_EQ(quantise(std::nanf("")), 0);
}

TEST(Sources, EveryNameIsFoundAgain) {
  for (size_t i = 0; i < static_cast<size_t>(Source::Count); ++i) {
    const auto source = static_cast<Source>(i);
    ASSERT_EQ(findSource(sourceName(source)), source) << sourceName(source);
  }
  EXPECT_EQ(findSource("key.none"), Source::Count);
  EXPECT_EQ(findSource(""), Source::Count);
}

// A map with an axis and two buttons, and what a player does to it.
struct Play {
  ActionMap map;
  ActionId move_x = map.add(
      {"move_x",
       ActionKind::Axis,
       {{Source::KeyD}, {Source::KeyA, -1}, {Source::PadLeftX, 1, 0.2f}, {Source::MouseX, 0.01f}}});
  ActionId jump = map.add({"jump", ActionKind::Button, {{Source::KeySpace}, {Source::PadA}}});
  ActionId zoom =
      map.add({"zoom", ActionKind::Button, {{Source::MouseWheel}, {Source::PadLeftTrigger}}});
  ActionSampler sampler{map};
  ActionState state;

  void feed(std::initializer_list<RawEvent> events) { sampler.feed(RawInput{events}); }
  void tick() { sampler.tick(state); }
};

TEST(ActionSampler, PressAndReleaseAreEdgesOfOneTick) {
  Play play;
  play.tick();
  EXPECT_FALSE(play.state.down(play.jump));
  play.feed({{Source::KeySpace, 1}});
  play.tick();
  EXPECT_TRUE(play.state.pressed(play.jump));
  EXPECT_EQ(play.state.value(play.jump), 1.0f);
  // A second tick in the same frame sees no second press.
  play.tick();
  EXPECT_FALSE(play.state.pressed(play.jump));
  EXPECT_TRUE(play.state.down(play.jump));
  play.feed({{Source::KeySpace, 0}});
  play.tick();
  EXPECT_TRUE(play.state.released(play.jump));
  EXPECT_FALSE(play.state.down(play.jump));
  play.tick();
  EXPECT_FALSE(play.state.released(play.jump));
}

TEST(ActionSampler, AShortPressBetweenTicksIsNotLost) {
  Play play;
  play.feed({{Source::KeySpace, 1}});
  play.feed({{Source::KeySpace, 0}});
  play.tick();
  EXPECT_TRUE(play.state.pressed(play.jump));
  play.tick();
  EXPECT_TRUE(play.state.released(play.jump));
  play.tick();
  EXPECT_FALSE(play.state.down(play.jump));
  // While held: released and pressed again between two ticks is a release, then a press.
  play.feed({{Source::KeySpace, 1}});
  play.tick();
  play.feed({{Source::KeySpace, 0}, {Source::KeySpace, 1}});
  play.tick();
  EXPECT_TRUE(play.state.released(play.jump));
  play.tick();
  EXPECT_TRUE(play.state.pressed(play.jump));
  play.tick();
  EXPECT_TRUE(play.state.down(play.jump));
}

TEST(ActionSampler, AStormOfPressesEndsInTheTrueState) {
  Play play;
  for (int i = 0; i < 1001; ++i) play.feed({{Source::KeySpace, static_cast<float>((i + 1) % 2)}});
  for (int i = 0; i < 4; ++i) play.tick();
  EXPECT_TRUE(play.state.down(play.jump));
  EXPECT_FALSE(play.state.pressed(play.jump));
}

TEST(ActionSampler, TwoSourcesOfOneButtonAreOnePress) {
  Play play;
  play.feed({{Source::KeySpace, 1}, {Source::PadA, 1}});
  play.tick();
  play.feed({{Source::KeySpace, 0}});
  play.tick();
  EXPECT_TRUE(play.state.down(play.jump));
  play.feed({{Source::PadA, 0}});
  play.tick();
  EXPECT_TRUE(play.state.released(play.jump));
}

TEST(ActionSampler, WheelAndTriggerActAsButtons) {
  Play play;
  play.feed({{Source::MouseWheel, 1}});
  play.tick();
  EXPECT_TRUE(play.state.pressed(play.zoom));
  play.tick();
  EXPECT_TRUE(play.state.released(play.zoom));
  play.feed({{Source::MouseWheel, -1}});
  play.tick();
  EXPECT_FALSE(play.state.down(play.zoom));
  play.feed({{Source::PadLeftTrigger, 0.4f}});
  play.tick();
  EXPECT_FALSE(play.state.down(play.zoom));
  play.feed({{Source::PadLeftTrigger, 0.9f}});
  play.tick();
  EXPECT_TRUE(play.state.down(play.zoom));
}

TEST(ActionSampler, AxisSumsAndClampsItsSources) {
  Play play;
  play.feed({{Source::KeyD, 1}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), 1.0f);
  play.feed({{Source::PadLeftX, 1}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), 1.0f);
  play.feed({{Source::KeyA, 1}, {Source::PadLeftX, 0}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), 0.0f);
  play.feed({{Source::KeyD, 0}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), -1.0f);
}

TEST(ActionSampler, ATapOnAnAxisKeyLastsOneTick) {
  Play play;
  play.feed({{Source::KeyA, 1}, {Source::KeyA, 0}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), -1.0f);
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), 0.0f);
}

TEST(ActionSampler, DeadZoneIsCutAndTheRestStretched) {
  Play play;
  const auto at = [&](float position) {
    play.feed({{Source::PadLeftX, position}});
    play.tick();
    return play.state.value(play.move_x);
  };
  EXPECT_EQ(at(0.2f), 0.0f);
  EXPECT_EQ(at(-0.19f), 0.0f);
  EXPECT_NEAR(at(0.6f), 0.5f, 1e-4f);
  EXPECT_NEAR(at(-0.6f), -0.5f, 1e-4f);
  EXPECT_EQ(at(1.0f), 1.0f);
  EXPECT_EQ(at(-1.5f), -1.0f);
}

TEST(ActionSampler, MouseMotionIsConserved) {
  Play play;
  double moved = 0, seen = 0;
  for (uint64_t i = 0; i < 5000; ++i) {
    const float pixels = 160 * randomUnit(2, i, 0, 0) - 80;
    play.feed({{Source::MouseX, pixels}});
    moved += pixels * 0.01;
    if (i % 3 == 2) continue;  // a frame without a tick
    play.tick();
    seen += play.state.value(play.move_x);
  }
  for (int i = 0; i < 8; ++i) {
    play.tick();
    seen += play.state.value(play.move_x);
  }
  EXPECT_NEAR(seen, moved, 1e-3);
  EXPECT_EQ(play.state.value(play.move_x), 0.0f);
}

TEST(ActionSampler, AFlickOfTheMouseIsBounded) {
  Play play;
  play.feed({{Source::MouseX, 1e9f}});
  int ticks = 0;
  for (play.tick(); play.state.down(play.move_x); play.tick()) {
    EXPECT_EQ(play.state.value(play.move_x), 1.0f);
    ASSERT_LT(++ticks, 100);
  }
  EXPECT_EQ(ticks, static_cast<int>(ActionSampler::kMaxMotionTicks));
}

TEST(ActionSampler, HostileEventsAreIgnored) {
  Play play;
  const float infinity = std::numeric_limits<float>::infinity();
  play.feed({{Source::MouseX, std::nanf("")},
             {Source::MouseX, infinity},
             {Source::PadLeftX, std::nanf("")},
             {Source::PadLeftX, -infinity},
             {Source::Count, 1},
             {static_cast<Source>(60000), 1}});
  play.tick();
  EXPECT_EQ(play.state.value(play.move_x), 0.0f);
  EXPECT_FALSE(play.state.down(play.jump));
}

TEST(ActionSampler, ResetForgetsWhatIsHeld) {
  Play play;
  play.feed({{Source::KeySpace, 1}, {Source::KeyD, 1}, {Source::MouseX, 1000}});
  play.tick();
  play.sampler.reset();
  play.tick();
  EXPECT_TRUE(play.state.released(play.jump));
  EXPECT_EQ(play.state.value(play.move_x), 0.0f);
}

TEST(ActionMapDeath, BadDeclarationsEndTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Play play;
  EXPECT_DEATH(play.map.add({"jump", ActionKind::Button, {}}), "'jump' is declared twice");
  EXPECT_DEATH(play.map.add({"Jump", ActionKind::Button, {}}), "lower-case");
  EXPECT_DEATH(play.map.add({"", ActionKind::Button, {}}), "lower-case");
  EXPECT_DEATH(play.map.add({"fly", ActionKind::Button, {{Source::KeyA, 0}}}), "out of range");
  EXPECT_DEATH((void)play.map.id("fly"), "'fly' was not declared");
}

class FileWatchTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("scree_watch_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
               "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const char* name, const std::string& content) {
    const auto path = folder_ / name;
    std::ofstream(path) << content;
    return path;
  }
  std::filesystem::path folder_;
};

TEST_F(FileWatchTest, SeesChangesOnce) {
  const auto a = write("a", "1"), b = write("b", "1");
  FileWatch watch;
  watch.add(a);
  watch.add(b);
  watch.add(a);
  EXPECT_EQ(watch.size(), 2u);
  EXPECT_TRUE(watch.poll().empty());
  write("a", "22");
  ASSERT_EQ(watch.poll().size(), 1u);
  EXPECT_TRUE(watch.poll().empty());
  // Same size and content, later time.
  std::filesystem::last_write_time(b,
                                   std::filesystem::last_write_time(b) + std::chrono::seconds(1));
  const auto changed = watch.poll();
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(changed[0], b);
}

TEST_F(FileWatchTest, SeesReplacedVanishedAndCreatedFiles) {
  const auto a = write("a", "1");
  FileWatch watch;
  watch.add(a);
  watch.add(folder_ / "later");
  // An editor that writes a new file and renames it over the old one, with the time kept.
  const auto time = std::filesystem::last_write_time(a);
  const auto other = write("other", "2");
  std::filesystem::last_write_time(other, time);
  std::filesystem::rename(other, a);
  EXPECT_EQ(watch.poll().size(), 1u);
  std::filesystem::remove(a);
  EXPECT_EQ(watch.poll().size(), 1u);
  EXPECT_TRUE(watch.poll().empty());
  write("later", "");
  write("a", "1");
  EXPECT_EQ(watch.poll().size(), 2u);
  watch.clear();
  EXPECT_EQ(watch.size(), 0u);
}

TEST(ContextKinds, NamesAreReadBack) {
  for (ContextKind kind :
       {ContextKind::Auto, ContextKind::Window, ContextKind::Egl, ContextKind::OsMesa})
    EXPECT_EQ(parseContextKind(contextKindName(kind)).value(), kind);
  for (const char* bad : {"", "EGL", "window ", "glx"}) {
    const auto parsed = parseContextKind(bad);
    ASSERT_FALSE(parsed.ok()) << bad;
    EXPECT_EQ(parsed.error(),
              "context is '" + std::string(bad) + "'; allowed are auto, window, egl, osmesa");
  }
}

}  // namespace
}  // namespace scree
