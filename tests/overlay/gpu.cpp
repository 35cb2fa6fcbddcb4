// What the overlay draws: exact pixels where the text is, nothing elsewhere, and nothing when idle.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/app.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/readback.h"
#include "modules/overlay/overlay.h"
#include "modules/overlay/text_layout.h"
#include "modules/scene/scene.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/image_expect.h"

namespace scree {
namespace {

using Pixel = std::array<uint8_t, 4>;
constexpr Pixel kGround{200, 120, 40, 255};

// The output of one frame; rows from the top.
struct Shot {
  ivec2 size{0};
  std::vector<Pixel> pixels;
  Pixel at(int x, int y) const { return pixels[static_cast<size_t>(y * size.x + x)]; }
  bool operator==(const Shot&) const = default;
};

// An app that shows the overlay on a plain ground.
class Screen {
 public:
  Screen() {
    app_.addPass({.name = "test.ground",
                  .stage = Stage::Present,
                  .uses = {{std::string(Frame::kOutput), Access::Clear}},
                  .run = [](PassContext& context) {
                    vec4 color;
                    for (int i = 0; i < 4; ++i)
                      color[i] = static_cast<float>(kGround[static_cast<size_t>(i)]) / 255;
                    context.framebuffer->clearColor(0, color);
                  }});
    addOverlay(app_);
  }
  OverlayText& text() { return app_.world().singleton<OverlayText>(); }
  Inspector& inspector() { return app_.world().singleton<Inspector>(); }
  World& world() { return app_.world(); }
  App& app() { return app_; }
  void render(ivec2 size, int samples = 1) { app_.render(size, 1, 1, samples); }
  Shot shoot(ivec2 size) {
    render(size);
    const std::vector<uint8_t> bytes = gpu::readBytes(app_.frame().texture(Frame::kOutput), 4);
    Shot shot{size, std::vector<Pixel>(static_cast<size_t>(size.x * size.y))};
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        for (int c = 0; c < 4; ++c)
          shot.pixels[static_cast<size_t>(y * size.x + x)][static_cast<size_t>(c)] =
              bytes[static_cast<size_t>(((size.y - 1 - y) * size.x + x) * 4 + c)];
    return shot;
  }
  uint64_t runs() { return app_.frame().runCount("overlay.draw"); }

 private:
  App app_{AppOptions{}};
};

class OverlayGpu : public test::GlTest {};

TextBox onlyBox(const OverlayText& text, ivec2 size) {
  std::vector<TextBox> boxes;
  placeLines(text.lines(), size, boxes);
  return boxes.at(0);
}

bool inside(const TextBox& box, int x, int y) {
  return x >= box.origin.x && y >= box.origin.y && x < box.origin.x + box.size.x &&
         y < box.origin.y + box.size.y;
}

TEST_F(OverlayGpu, NoTextCostsNothing) {
  Screen screen;
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 3; ++i) screen.render({320, 200});
  const gpu::Counters spent = gpu::counters() - before;
  EXPECT_EQ(screen.runs(), 0u);
  EXPECT_EQ(spent.draws, 0u);
  EXPECT_EQ(spent.programs, 0u);
  EXPECT_EQ(spent.buffers, 0u);
  EXPECT_EQ(spent.bytes_uploaded, 0u);
  EXPECT_EQ(spent.textures, 1u);  // the output
  const auto& report = screen.app().frame().report();
  ASSERT_EQ(report.size(), 2u);
  EXPECT_FALSE(report[1].on);
  EXPECT_NE(report[1].why.find("text"), std::string::npos) << report[1].why;
}

TEST_F(OverlayGpu, TextThatIsClearedLeavesNoTraceAndStopsCosting) {
  Screen screen;
  const Shot ground = screen.shoot({320, 200});
  screen.text().add("text");
  EXPECT_NE(screen.shoot({320, 200}), ground);
  screen.text().clear();
  const gpu::Counters before = gpu::counters();
  EXPECT_EQ(screen.shoot({320, 200}), ground);
  EXPECT_EQ((gpu::counters() - before).draws, 0u);
  EXPECT_EQ(screen.runs(), 1u);
}

TEST_F(OverlayGpu, TextIsOneDrawAndCreatesNothingInTheSteadyState) {
  Screen screen;
  for (int i = 0; i < 3; ++i) {
    screen.text().clear();
    screen.text().add(fmt::format("{} kg", i), Anchor::TopLeft);
    screen.text().add("second", Anchor::Center, 2);
    screen.render({640, 360});
  }
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 5; ++i) {
    screen.text().clear();
    screen.text().add(fmt::format("{} kg", i), Anchor::TopLeft);
    screen.text().add("second", Anchor::Center, 2);
    screen.render({640, 360});
  }
  const gpu::Counters spent = gpu::counters() - before;
  EXPECT_EQ(spent.draws, 5u);
  EXPECT_EQ(spent.programs + spent.buffers + spent.textures + spent.framebuffers + spent.readbacks,
            0u);
}

TEST_F(OverlayGpu, PixelsChangeInTheBoxAndNowhereElse) {
  const vec4 color{0.2f, 0.8f, 1, 1};
  const Pixel letter{51, 204, 255, 255};
  for (ivec2 size : {ivec2(640, 360), ivec2(641, 363), ivec2(1280, 720), ivec2(1920, 1080)}) {
    for (size_t anchor = 0; anchor < kAnchorCount; ++anchor) {
      SCOPED_TRACE(fmt::format("{}x{} anchor {}", size.x, size.y, anchor));
      Screen screen;
      screen.text().add("12:34 Scale", static_cast<Anchor>(anchor), 1, color).backing = 0.6f;
      const Shot shot = screen.shoot(size);
      const TextBox box = onlyBox(screen.text(), size);
      int letters = 0, dark = 0;
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const Pixel pixel = shot.at(x, y);
          if (!inside(box, x, y)) {
            ASSERT_EQ(pixel, kGround) << x << " " << y;
          } else if (pixel == letter) {
            ++letters;
          } else {
            // Black at 0.6 over the ground; one step for rounding.
            for (size_t c = 0; c < 3; ++c)
              ASSERT_NEAR(pixel[c], 0.4 * kGround[c], 1.0) << x << " " << y;
            ASSERT_EQ(pixel[3], 255);
            ++dark;
          }
        }
      }
      EXPECT_EQ(letters + dark, box.size.x * box.size.y);
      EXPECT_GT(letters, 10 * 10 * box.scale * box.scale);
      EXPECT_LT(letters, dark);
    }
  }
}

// The same text at twice the size is the same image, each pixel doubled: nothing is blurred.
TEST_F(OverlayGpu, LargerLettersAreTheSameLetters) {
  const auto show = [](ivec2 size) {
    Screen screen;
    screen.text().add("gjpqy |_^ AWM@ 0123456789\nsecond row", Anchor::TopLeft);
    screen.text().add("lower right", Anchor::BottomRight, 2, {1, 0.5f, 0, 0.7f});
    return screen.shoot(size);
  };
  const Shot small = show({640, 360});
  for (int factor : {2, 3, 6}) {
    const Shot large = show(factor * ivec2(640, 360));
    int wrong = 0;
    for (int y = 0; y < large.size.y; ++y)
      for (int x = 0; x < large.size.x; ++x)
        wrong += large.at(x, y) != small.at(x / factor, y / factor);
    EXPECT_EQ(wrong, 0) << "factor " << factor;
  }
}

// Neither mirrored nor upside down: an L has its stem on the left and its foot below.
TEST_F(OverlayGpu, LettersStandUpright) {
  Screen screen;
  screen.text().add("L", Anchor::TopLeft, 1, vec4(1)).backing = 0;
  const Shot shot = screen.shoot({64, 64});
  std::vector<ivec2> lit;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      if (shot.at(x, y) != kGround) lit.push_back({x, y});
  ASSERT_FALSE(lit.empty());
  const auto left =
      std::min_element(lit.begin(), lit.end(), [](ivec2 a, ivec2 b) { return a.x < b.x; })->x;
  const auto low =
      std::max_element(lit.begin(), lit.end(), [](ivec2 a, ivec2 b) { return a.y < b.y; })->y;
  int stem = 0, foot = 0;
  for (ivec2 pixel : lit) {
    stem += pixel.x == left;
    foot += pixel.y == low;
  }
  EXPECT_GE(stem, 7);
  EXPECT_GE(foot, 4);
  EXPECT_EQ(static_cast<int>(lit.size()), stem + foot - 1);
}

TEST_F(OverlayGpu, TransparentTextIsBlended) {
  Screen screen;
  screen.text().add("L", Anchor::TopLeft, 1, {1, 1, 1, 0.5f}).backing = 0;
  const Shot shot = screen.shoot({64, 64});
  int lit = 0;
  for (const Pixel& pixel : shot.pixels) {
    if (pixel == kGround) continue;
    ++lit;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], 0.5 * (kGround[c] + 255), 1.5);
    EXPECT_EQ(pixel[3], 255);
  }
  EXPECT_GT(lit, 10);
}

TEST_F(OverlayGpu, SameTextSamePixelsInEveryApp) {
  const auto show = [] {
    Screen screen;
    screen.world().spawn(makeName("beast"), Transform{});
    screen.inspector().open = true;
    screen.inspector().times = false;
    screen.text().add("on top", Anchor::Center, 2);
    screen.shoot({640, 360});
    return screen.shoot({640, 360});
  };
  EXPECT_EQ(show(), show());
}

TEST_F(OverlayGpu, TheInspectorShowsItsPanels) {
  Screen screen;
  screen.world().spawn(makeName("beast"), Transform{});
  screen.world().spawn(makeName("lamp"), Light{});
  const Shot ground = screen.shoot({1280, 720});
  screen.inspector().open = true;
  screen.inspector().times = false;
  const Shot first = screen.shoot({1280, 720});
  const TextBox panels[] = {panelBox({1280, 720}, 2, 0), panelBox({1280, 720}, 2, 1)};
  for (int y = 0; y < 720; ++y) {
    for (int x = 0; x < 1280; ++x) {
      const bool panel = inside(panels[0], x, y) || inside(panels[1], x, y);
      ASSERT_EQ(first.at(x, y) != kGround, panel) << x << " " << y;
    }
  }
  screen.world().spawn(makeName("third"));
  EXPECT_NE(screen.shoot({1280, 720}), first);
  screen.inspector().open = false;
  EXPECT_EQ(screen.shoot({1280, 720}), ground);
}

TEST_F(OverlayGpu, MoreLettersThanSixteenBitsCanIndex) {
  const ivec2 size{3840, 1000};
  const auto show = [&](int rows) {
    Screen screen;
    for (int i = 0; i < rows; ++i) screen.text().add(std::string(500, 'W'), Anchor::TopLeft, 0.3f);
    screen.text().add("the last line", Anchor::BottomRight);
    return screen.shoot(size);
  };
  const Shot alone = show(0), crowded = show(60);
  // 60 rows of 15 px end above the last line's 45 px; every row of letters is the same.
  for (int y = 940; y < 1000; ++y)
    for (int x = 0; x < size.x; ++x) ASSERT_EQ(crowded.at(x, y), alone.at(x, y)) << x << " " << y;
  for (int y = 12; y < 27; ++y)
    for (int x = 0; x < 3560; ++x)
      for (int row : {1, 31, 32, 33, 59})
        ASSERT_EQ(crowded.at(x, y + 15 * row), crowded.at(x, y)) << x << " " << y;
}

TEST_F(OverlayGpu, HostileTextAndSizesDoNoHarm) {
  const float infinity = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  const std::string texts[] = {"",
                               "\n\n\n",
                               std::string(100000, 'x'),
                               std::string("a\0b", 3),
                               "\xff\xfe\xc3",
                               "\xe2\x8c\x9b\xf0\x9f\x98\x80",
                               "\t\r\x01\x1b[31m%s%n",
                               std::string(3000, '\n')};
  for (ivec2 size : {ivec2(1, 1), ivec2(7, 3), ivec2(320, 1), ivec2(1, 2000), ivec2(320, 200)}) {
    Screen screen;
    for (const std::string& text : texts) {
      for (float bad : {0.0f, -1.0f, nan, infinity, 1e30f}) {
        screen.text().add(text, Anchor::Center, bad, {bad, -1, 2, bad}).backing = bad;
        screen.text().add(text, static_cast<Anchor>(12345), 1, vec4(nan));
      }
    }
    screen.inspector().open = true;
    screen.inspector().selected = {3, 4};
    screen.inspector().first_entity = 5;
    screen.shoot(size);
    EXPECT_EQ(screen.runs(), 1u);
  }
}

TEST_F(OverlayGpu, DrawsOverTheLastSampleOnly) {
  Screen screen;
  screen.text().add("text");
  screen.render({320, 200}, 4);
  EXPECT_EQ(screen.runs(), 1u);
}

images::Image pictureOf(Screen& screen) {
  for (int i = 0; i < 2; ++i) screen.render({640, 360});
  const gpu::Texture& output = screen.app().frame().texture(Frame::kOutput);
  return images::imageFromBytes(640, 360, 4, gpu::readBytes(output, 4), RowOrder::BottomUp);
}

TEST_F(OverlayGpu, GoldenText) {
  Screen screen;
  screen.text().add("812 / 1000 kg", Anchor::TopLeft);
  screen.text().add("9 of 12 gates", Anchor::TopLeft);
  screen.text().add("1:59", Anchor::TopRight, 1, {1, 0.5f, 0.4f, 1});
  screen.text().add("WON", Anchor::Center, 3, {0.6f, 0.93f, 0.5f, 1});
  screen.text().add("in 63.2 s", Anchor::Center);
  screen.text().add("R plays again", Anchor::BottomCenter, 1, vec4(1)).backing = 0;
  EXPECT_GOLDEN(pictureOf(screen), "overlay/text");
}

TEST_F(OverlayGpu, GoldenInspector) {
  Screen screen;
  screen.world().spawn(makeName("beast"), Transform{.position = {1, 2, 3}});
  screen.world().spawn(makeName("lamp"), Light{}, Transform{});
  screen.inspector().open = true;
  screen.inspector().times = false;
  EXPECT_GOLDEN(pictureOf(screen), "overlay/inspector");
}

}  // namespace
}  // namespace scree
