// The bindings file: round trip, partial files, and damaged files that each end in one clear line.
#include <gtest/gtest.h>

#include <iterator>
#include <string>
#include <vector>

#include "engine/core/random.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

ActionMap someMap() {
  ActionMap map;
  map.add({"move_x",
           ActionKind::Axis,
           {{Source::KeyD}, {Source::KeyA, -1}, {Source::PadLeftX, 0.5f, 0.2f}}});
  map.add({"pause", ActionKind::Button, {{Source::KeyP}}});
  map.add({"unbound", ActionKind::Button, {}});
  return map;
}

TEST(Bindings, WrittenBindingsAreReadBack) {
  const ActionMap written = someMap();
  ActionMap read;
  read.add({"move_x", ActionKind::Axis, {}});
  read.add({"pause", ActionKind::Button, {}});
  read.add({"unbound", ActionKind::Button, {{Source::KeyU}}});
  const Status status = read.parseBindings(written.formatBindings(), "b.json");
  ASSERT_TRUE(status.ok()) << status.error();
  EXPECT_EQ(read.formatBindings(), written.formatBindings());
  const Binding& stick = read.actions()[0].bindings[2];
  EXPECT_EQ(stick.source, Source::PadLeftX);
  EXPECT_EQ(stick.scale, 0.5f);
  EXPECT_EQ(stick.dead_zone, 0.2f);
}

TEST(Bindings, AFileChangesOnlyWhatItNames) {
  ActionMap map = someMap();
  const Status status = map.parseBindings(
      R"({"version": 1, "actions": {"pause": ["key.escape", {"source": "pad.start"}]}})", "b.json");
  ASSERT_TRUE(status.ok()) << status.error();
  EXPECT_EQ(map.actions()[0].bindings.size(), 3u);
  ASSERT_EQ(map.actions()[1].bindings.size(), 2u);
  EXPECT_EQ(map.actions()[1].bindings[0].source, Source::KeyEscape);
  EXPECT_EQ(map.actions()[1].bindings[1].source, Source::PadStart);
}

TEST(Bindings, ReboundActionsAnswerToTheirNewKeys) {
  ActionMap map = someMap();
  ActionSampler sampler(map);
  ActionState state;
  ASSERT_TRUE(map.parseBindings(R"({"version": 1, "actions": {"pause": ["key.x"]}})", "b").ok());
  sampler.feed({{{Source::KeyP, 1}}});
  sampler.tick(state);
  EXPECT_FALSE(state.down(map.id("pause")));
  sampler.feed({{{Source::KeyX, 1}}});
  sampler.tick(state);
  EXPECT_TRUE(state.pressed(map.id("pause")));
}

std::string bindings(const std::string& list) {
  return R"({"version": 1, "actions": {"pause": ["key.x"], "move_x": )" + list + "}}";
}

TEST(Bindings, DamagedFilesAreRefusedInOneLineAndChangeNothing) {
  struct Case {
    std::string text;
    std::vector<std::string> named;  // what the line must say
  };
  std::string many = "[";
  for (int i = 0; i < 17; ++i) many += std::string(i ? "," : "") + "\"key.a\"";
  many += "]";
  const Case cases[] = {
      {"", {"b.json:1", "not JSON"}},
      {"{\"version\": 1,\n\"actions\": {\n", {"b.json:3", "not JSON"}},
      {"{\"version\": 1,\n\"actions\" {}}", {"b.json:2", "not JSON"}},
      {"[]", {"[]", "allowed is an object"}},
      {R"({"actions": {}})", {"version is missing"}},
      {R"({"version": 2, "actions": {}})", {"version is 2", "allowed is 1"}},
      {R"({"version": 1.0, "actions": {}})", {"version is 1.0", "allowed is 1"}},
      {R"({"version": 1})", {"actions is missing"}},
      {R"({"version": 1, "actions": []})", {"actions is []"}},
      {R"({"version": 1, "actions": {}, "extra": 1})", {"\"extra\"", "allowed are version"}},
      {R"({"version": 1, "actions": {"jump": []}})", {"unknown action \"jump\"", "move_x, pause"}},
      {R"({"version": 1, "actions": {"pause": [], "pause": []}})", {"\"pause\" is given twice"}},
      {bindings("\"key.a\""), {"action 'move_x'", "\"key.a\"", "allowed is a list"}},
      {bindings(many), {"action 'move_x'", "17 bindings", "at most 16"}},
      {bindings("[\"key.a\", \"key.aa\"]"), {"action 'move_x': binding 2", "source is \"key.aa\""}},
      {bindings("[12]"), {"binding 1", "12", "allowed is the name of a source"}},
      {bindings("[{\"scale\": 1}]"), {"binding 1", "source is missing"}},
      {bindings("[{\"source\": 7}]"), {"binding 1", "source is 7"}},
      {bindings("[{\"source\": \"key.a\", \"scale\": 0}]"), {"binding 1", "scale is 0"}},
      {bindings("[{\"source\": \"key.a\", \"scale\": 101}]"), {"scale is 101", "-100 to 100"}},
      {bindings("[{\"source\": \"key.a\", \"scale\": 1e300}]"), {"scale is 1e+300", "-100 to 100"}},
      {bindings("[{\"source\": \"key.a\", \"scale\": \"1\"}]"), {"scale is \"1\""}},
      {bindings("[{\"source\": \"key.a\", \"scale\": null}]"), {"scale is null"}},
      {bindings("[{\"source\": \"pad.left_x\", \"dead_zone\": 1}]"),
       {"dead_zone is 1", "0 to 0.9"}},
      {bindings("[{\"source\": \"pad.left_x\", \"dead_zone\": -0.1}]"), {"dead_zone is -0.1"}},
      {bindings("[{\"source\": \"key.a\", \"dead_zone\": 0.1}]"), {"only gamepad axes"}},
      {bindings("[{\"source\": \"key.a\", \"speed\": 1}]"), {"unknown field \"speed\""}},
      {bindings("[\"key.a\\u0000\\n\"]"), {"source is \"key.a"}},
      {std::string("{\"version\": 1\0}", 15), {"b.json:1", "not JSON"}},
      {"\xff\xfe{}", {"b.json:1", "not JSON"}},
      {std::string(100000, '['), {"b.json", "nested deeper than 16"}},
      {R"({"version": )" + std::string(500000, '['), {"b.json", "nested deeper"}},
      {R"({"version": )" + std::string(500000, '[') + std::string(500000, ']') + "}",
       {"b.json", "nested deeper"}},
      {R"({"version": 1, "actions": {"pa\nuse": []}})", {"unknown action \"pa\\nuse\""}},
      {R"({"version": 1e999, "actions": {}})", {"not JSON", "1e999"}},
  };
  for (const Case& damaged : cases) {
    ActionMap map = someMap();
    const std::string before = map.formatBindings();
    const Status status = map.parseBindings(damaged.text, "b.json");
    const std::string text = damaged.text.substr(0, 100);
    ASSERT_FALSE(status.ok()) << text;
    const std::string& line = status.error();
    EXPECT_EQ(line.find("b.json"), 0u) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    EXPECT_LT(line.size(), 300u) << line;
    for (const std::string& name : damaged.named)
      EXPECT_NE(line.find(name), std::string::npos) << line << "\n  lacks: " << name;
    EXPECT_EQ(map.formatBindings(), before) << text;
  }
}

TEST(Bindings, RandomDamageEndsInOneLineOrInValidBindings) {
  constexpr uint64_t kSeed = 11;
  const std::string good = someMap().formatBindings();
  const std::string pieces[] = {
      "{",    "}",  "[",     "]",         "\"",        ",",
      ":",    "-",  "1e308", "null",      "\\u0000",   "\\ud800",
      "\xc3", "\n", "true",  "\"key.a\"", "\"scale\"", "99999999999999999999"};
  for (uint64_t run = 0; run < 5000; ++run) {
    const auto draw = [&](uint64_t i, uint64_t limit) {
      return randomBits(kSeed, run, 0, i) % limit;
    };
    std::string text = good;
    for (uint64_t i = 0; i <= draw(0, 4); ++i)
      text.replace(draw(10 + i, text.size()), draw(20 + i, 4),
                   pieces[draw(30 + i, std::size(pieces))]);
    ActionMap map = someMap();
    const Status status = map.parseBindings(text, "b.json");
    if (status.ok()) {
      ActionMap again = someMap();
      ASSERT_TRUE(again.parseBindings(map.formatBindings(), "b.json").ok()) << text;
      continue;
    }
    ASSERT_EQ(status.error().find("b.json"), 0u) << "seed " << kSeed << " run " << run;
    for (unsigned char c : status.error()) ASSERT_GE(c, 32) << "seed " << kSeed << " run " << run;
    ASSERT_EQ(map.formatBindings(), good);
  }
}

TEST(Bindings, AMissingFileIsNamed) {
  ActionMap map = someMap();
  const Status status = map.loadBindings("/nowhere/b.json");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error(), "/nowhere/b.json: no such file");
}

}  // namespace
}  // namespace scree
