// Where text is placed and what the inspector says, without GL.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/random.h"
#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/frame/frame.h"
#include "modules/overlay/inspector.h"
#include "modules/overlay/overlay.h"
#include "modules/overlay/text_layout.h"
#include "modules/scene/scene.h"

namespace scree {
namespace {

constexpr uint64_t kSeed = 7;

TextLine lineOf(std::string text, Anchor anchor = Anchor::TopLeft, float size = 1) {
  TextLine line;
  line.text = std::move(text);
  line.anchor = anchor;
  line.size = size;
  return line;
}

TEST(OverlayFactor, GrowsWithTheOutput) {
  for (const auto& [height, factor] : {std::pair{1, 1},
                                       {360, 1},
                                       {539, 1},
                                       {540, 2},
                                       {720, 2},
                                       {899, 2},
                                       {900, 3},
                                       {1080, 3},
                                       {1440, 4},
                                       {2160, 6}})
    EXPECT_EQ(overlayFactor(height), factor) << height;
}

TEST(OverlayTextLines, KeepTheirMemoryAndTheirDefaults) {
  OverlayText text;
  EXPECT_TRUE(text.empty());
  text.add("a line longer than any small string can hold", Anchor::Center, 3, vec4(0)).backing = 0;
  const char* memory = text.lines()[0].text.data();
  text.clear();
  EXPECT_TRUE(text.empty());
  EXPECT_TRUE(text.lines().empty());
  text.add("another line");
  ASSERT_EQ(text.lines().size(), 1u);
  EXPECT_EQ(text.lines()[0].text, "another line");
  EXPECT_EQ(text.lines()[0].text.data(), memory);
  EXPECT_EQ(text.lines()[0].anchor, Anchor::TopLeft);
  EXPECT_EQ(text.lines()[0].size, 1.0f);
  EXPECT_EQ(text.lines()[0].color, vec4(1));
  EXPECT_EQ(text.lines()[0].backing, TextLine().backing);
}

TEST(TextExtent, CountsLettersNotBytes) {
  EXPECT_EQ(textExtent(""), ivec2(0, 1));
  EXPECT_EQ(textExtent("abc"), ivec2(3, 1));
  EXPECT_EQ(textExtent("abc\nde"), ivec2(3, 2));
  EXPECT_EQ(textExtent("a\nlonger\n"), ivec2(6, 3));
  EXPECT_EQ(textExtent("gr\xc3\xbc\xc3\x9f"), ivec2(4, 1));
  EXPECT_EQ(textExtent("\xe2\x8c\x9b"), ivec2(1, 1));
  EXPECT_EQ(textExtent("a\tb\r"), ivec2(6, 1));
}

TEST(ShownText, IsCutBetweenLetters) {
  EXPECT_EQ(shownText("abc"), "abc");
  EXPECT_EQ(shownText(std::string(5000, 'x')).size(), kMaxTextBytes);
  std::string wide(kMaxTextBytes - 1, 'x');
  wide += "\xc3\xbc\xc3\xbc";
  EXPECT_EQ(shownText(wide).size(), kMaxTextBytes - 1);
}

TEST(TextScale, IsWholeAndFits) {
  const auto scale = [](float size, ivec2 extent, ivec2 output) {
    return textScale(lineOf("", Anchor::TopLeft, size), extent, output);
  };
  EXPECT_EQ(scale(1, {10, 1}, {640, 360}), 1);
  EXPECT_EQ(scale(2, {10, 1}, {640, 360}), 2);
  EXPECT_EQ(scale(1, {10, 1}, {3840, 2160}), 6);
  EXPECT_EQ(scale(1.5f, {10, 1}, {1280, 720}), 3);
  EXPECT_EQ(scale(0.1f, {10, 1}, {640, 360}), 1);
  EXPECT_EQ(scale(-5, {10, 1}, {640, 360}), 1);
  // 80 letters at factor 6 are 3,396 px; at 1920 px of width only factor 3 fits.
  EXPECT_EQ(scale(1, {80, 1}, {1920, 2160}), 3);
  EXPECT_EQ(scale(1, {100000, 1}, {640, 360}), 1);
  const float infinity = std::numeric_limits<float>::infinity();
  for (float bad : {std::nanf(""), infinity, -infinity})
    EXPECT_EQ(scale(bad, {10, 1}, {640, 360}), 1);
  EXPECT_EQ(scale(1e30f, {0, 1}, {16384, 360}), 64);
}

bool overlap(const TextBox& a, const TextBox& b) {
  return a.origin.x < b.origin.x + b.size.x && b.origin.x < a.origin.x + a.size.x &&
         a.origin.y < b.origin.y + b.size.y && b.origin.y < a.origin.y + a.size.y;
}

TEST(PlaceLines, LinesOfOneAnchorStackWithoutOverlapWithinTheOutput) {
  for (uint64_t run = 0; run < 500; ++run) {
    SCOPED_TRACE(fmt::format("seed {} run {}", kSeed, run));
    const auto draw = [&](uint64_t i, uint64_t limit) {
      return randomBits(kSeed, run, 0, i) % limit;
    };
    const ivec2 sizes[] = {{640, 360}, {641, 361}, {960, 540}, {1280, 720}, {3840, 2160}};
    const ivec2 size = sizes[draw(0, 5)];
    std::vector<TextLine> lines;
    const uint64_t count = draw(1, 12);
    for (uint64_t i = 0; i < count; ++i)
      lines.push_back(lineOf(std::string(draw(10 + i, 20), 'x') + (draw(40 + i, 5) ? "" : "\ny"),
                             static_cast<Anchor>(draw(70 + i, kAnchorCount))));
    std::vector<TextBox> boxes;
    placeLines(lines, size, boxes);
    ASSERT_EQ(boxes.size(), lines.size());
    for (size_t i = 0; i < boxes.size(); ++i) {
      const TextBox& box = boxes[i];
      // 12 lines of two rows are at most 324 px of 360: everything fits.
      ASSERT_TRUE(box.origin.x >= 0 && box.origin.y >= 0) << box.origin.x << " " << box.origin.y;
      ASSERT_TRUE(box.origin.x + box.size.x <= size.x && box.origin.y + box.size.y <= size.y);
      const int third_x = (2 * box.origin.x + box.size.x) * 3 / (2 * size.x);
      ASSERT_EQ(third_x, static_cast<int>(lines[i].anchor) % 3);
      for (size_t j = 0; j < i; ++j) {
        if (lines[i].anchor != lines[j].anchor) continue;
        ASSERT_FALSE(overlap(boxes[i], boxes[j]));
        ASSERT_LT(boxes[j].origin.y, boxes[i].origin.y);
      }
    }
  }
}

TEST(PlaceLines, EachAnchorIsWhereItsNameSays) {
  std::vector<TextLine> lines;
  for (size_t i = 0; i < kAnchorCount; ++i) lines.push_back(lineOf("abc", static_cast<Anchor>(i)));
  std::vector<TextBox> boxes;
  placeLines(lines, {640, 360}, boxes);
  // 3 letters: 21 + 6 px wide, 13 + 2 px high; margins 4 px.
  const ivec2 expected[] = {{4, 4},     {306, 4}, {609, 4},   {4, 172},  {306, 172},
                            {609, 172}, {4, 341}, {306, 341}, {609, 341}};
  for (size_t i = 0; i < kAnchorCount; ++i) {
    EXPECT_EQ(boxes[i].size, ivec2(27, 15));
    EXPECT_EQ(boxes[i].origin, expected[i]) << i;
  }
}

TEST(PlaceLines, AnAnchorOutOfRangeDoesNoHarm) {
  std::vector<TextBox> boxes;
  const TextLine line = lineOf("abc", static_cast<Anchor>(1000000));
  placeLines({&line, 1}, {640, 360}, boxes);
  EXPECT_EQ(boxes.size(), 1u);
}

struct Gauge {
  bool on = true;
  int32_t level = -3;
  uint64_t serial = 18446744073709551615ull;
  float mass_kg = 2.5f;
  dvec3 place{1, 2, 3};
  std::array<float, 3> marks{0.5f, 1, 2};
  Entity owner = Entity::kNone;
  char label[8] = "eight";
};
SCREE_COMPONENT(Gauge, (on, ""), (level, ""), (serial, ""), (mass_kg, "kg"), (place, "m"),
                (marks, ""), (owner, ""), (label, ""));
struct Marked {};
SCREE_COMPONENT(Marked);

std::string entitiesText(World& world, const Inspector& inspector = {}, ivec2 letters = {80, 100}) {
  PanelText panel;
  panel.begin(letters);
  describeEntities(panel, world, inspector);
  return std::string(panel.text());
}

TEST(InspectorText, ShowsEveryFieldWithItsUnit) {
  World world;
  const Entity owner = world.spawn(Marked{});
  Gauge gauge;
  gauge.owner = owner;
  const Entity e = world.spawn(gauge, makeName("dial"));
  const std::string text = entitiesText(world);
  const std::string id = fmt::format("#{}.{}", e.index, e.generation);
  const std::string owner_id = fmt::format("#{}.{}", owner.index, owner.generation);
  for (const std::string& part :
       {std::string("2 entities in 2 tables\n"), fmt::format("{} dial\n", id),
        std::string("  Marked\n"), std::string("  Gauge.on true\n"),
        std::string("  Gauge.level -3\n"), std::string("  Gauge.serial 18446744073709551615\n"),
        std::string("  Gauge.mass_kg 2.5 kg\n"), std::string("  Gauge.place (1, 2, 3) m\n"),
        std::string("  Gauge.marks 0.5 1 2\n"), fmt::format("  Gauge.owner {}\n", owner_id),
        std::string("  Gauge.label 'eight'")})
    EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks: " << part;
}

TEST(InspectorText, TheSelectedEntityComesFirst) {
  World world;
  std::vector<Entity> entities;
  for (int i = 0; i < 50; ++i) entities.push_back(world.spawn(makeName(fmt::format("e{}", i))));
  Inspector inspector;
  inspector.selected = entities[40];
  EXPECT_LT(entitiesText(world, inspector).find(" e40\n"),
            entitiesText(world, inspector).find(" e0\n"));
  // A dead selection is no selection.
  world.destroy(entities[40]);
  EXPECT_EQ(entitiesText(world, inspector).find("selected"), std::string::npos);
}

TEST(InspectorText, BeginsAtTheEntityAskedFor) {
  World world;
  for (int i = 0; i < 5; ++i) world.spawn(makeName(fmt::format("a{}", i)));
  for (int i = 0; i < 5; ++i) world.spawn(makeName(fmt::format("b{}", i)), Marked{});
  Inspector inspector;
  inspector.first_entity = 7;
  const std::string text = entitiesText(world, inspector);
  EXPECT_EQ(text.find(" a4"), std::string::npos) << text;
  EXPECT_EQ(text.find(" b1"), std::string::npos) << text;
  EXPECT_NE(text.find(" b2\n"), std::string::npos) << text;
  inspector.first_entity = 4000000000u;
  EXPECT_EQ(entitiesText(world, inspector).find('#'), std::string::npos);
}

TEST(InspectorText, StaysWithinItsPanel) {
  World world;
  Name bad;
  for (size_t i = 0; i < sizeof bad.text; ++i) bad.text[i] = static_cast<char>(i * 7 + 1);
  for (int i = 0; i < 1000; ++i) world.spawn(bad, Transform{});
  for (ivec2 letters : {ivec2(40, 20), ivec2(1, 1), ivec2(0, 5), ivec2(5, 0), ivec2(0, 0)}) {
    const std::string text = entitiesText(world, {}, letters);
    int rows = text.empty() ? 0 : 1, columns = 0;
    for (char c : text) {
      if (c == '\n') {
        ++rows;
        columns = 0;
        continue;
      }
      ASSERT_TRUE(c >= 32 && c < 127);
      ASSERT_LE(++columns, letters.x);
    }
    ASSERT_LE(rows, std::max(letters.y, 0));
    if (letters == ivec2(40, 20)) {
      EXPECT_EQ(rows, 20);
    }
  }
}

TEST(InspectorText, ListsSystemsAndTheirState) {
  World world;
  Frame frame;
  Schedule schedule;
  schedule.add({.name = "test.runs", .phase = Phase::Simulate, .run = [](World&) {}});
  schedule.add({.name = "test.sleeps",
                .phase = Phase::Simulate,
                .needs = [] { return false; },
                .run = [](World&) {}});
  schedule.run(Phase::Simulate, world);
  PanelText panel;
  panel.begin({80, 100});
  describePasses(panel, frame, schedule, false);
  const std::string text(panel.text());
  const auto lineWith = [&](const char* name) {
    const size_t at = text.find(name);
    return at == std::string::npos ? std::string() : text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(lineWith("test.runs").substr(37), " on");
  EXPECT_EQ(lineWith("test.sleeps").substr(37), "off");
  EXPECT_EQ(text.find("ms"), std::string::npos);
}

TEST(PanelBoxes, LieBesideEachOtherWithinTheOutput) {
  for (ivec2 size :
       {ivec2(640, 360), ivec2(1281, 719), ivec2(3840, 2160), ivec2(1, 1), ivec2(10, 2000)}) {
    const int scale = overlayFactor(size.y);
    const TextBox left = panelBox(size, scale, 0), right = panelBox(size, scale, 1);
    EXPECT_FALSE(overlap(left, right));
    const ivec2 letters = panelLetters(size, scale);
    EXPECT_GE(letters.x, 0);
    EXPECT_GE(letters.y, 0);
    if (letters.x == 0 || letters.y == 0) continue;
    EXPECT_LE(right.origin.x + right.size.x, size.x);
    EXPECT_LE(right.origin.y + right.size.y, size.y);
  }
}

}  // namespace
}  // namespace scree
