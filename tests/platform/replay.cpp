// Replays: what is recorded is played back exactly, and damaged files end in one clear line.
#include "engine/platform/replay.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/random.h"

namespace scree {
namespace {

constexpr uint64_t kSeed = 20240607;

ActionMap mapOf(std::initializer_list<ActionDesc> actions) {
  ActionMap map;
  for (const ActionDesc& action : actions) map.add(action);
  return map;
}

ActionMap gameMap() {
  return mapOf({{"move_x", ActionKind::Axis, {}},
                {"move_y", ActionKind::Axis, {}},
                {"restart", ActionKind::Button, {}},
                {"pause", ActionKind::Button, {}}});
}

// The value of an action at a tick: mostly unchanged, sometimes anything, often an extreme.
int16_t randomValue(ActionKind kind, int16_t last, uint64_t run, uint64_t tick, uint64_t action) {
  const auto draw = [&](uint64_t i) { return randomBits(kSeed + run, action, tick, i); };
  if (draw(0) % 8 != 0) return last;
  if (kind == ActionKind::Button) return draw(1) % 2 ? kFullValue : int16_t{0};
  if (draw(2) % 4 == 0) return static_cast<int16_t>(int(draw(3) % 3) * 32767 - 32767);
  return static_cast<int16_t>(int(draw(4) % 65535) - 32767);
}

TEST(Replay, RandomStreamsArePlayedBackExactly) {
  for (uint64_t run = 0; run < 200; ++run) {
    SCOPED_TRACE(fmt::format("seed {} run {}", kSeed, run));
    ActionMap map;
    const size_t count = randomBits(kSeed, run, 0, 0) % (kMaxActions + 1);
    for (size_t i = 0; i < count; ++i)
      map.add({fmt::format("action_{}", i),
               randomBits(kSeed, run, 1, i) % 2 ? ActionKind::Axis : ActionKind::Button,
               {}});
    const uint64_t ticks = randomBits(kSeed, run, 2, 0) % 300;
    const uint64_t level_seed = randomBits(kSeed, run, 3, 0);

    ReplayRecorder recorder(map, fmt::format("levels/a b {}.glb", run), ~level_seed, level_seed);
    std::vector<ActionState> played;
    ActionState state;
    std::vector<int16_t> values(count, 0);
    for (uint64_t tick = 1; tick <= ticks; ++tick) {
      for (size_t i = 0; i < count; ++i)
        values[i] = randomValue(map.actions()[i].kind, values[i], run, tick, i);
      state.begin(values);
      recorder.record(state);
      played.push_back(state);
    }

    const std::string text = formatReplay(recorder.replay());
    Result<Replay> read = parseReplay(text, "r", &map);
    ASSERT_TRUE(read.ok()) << read.error();
    ASSERT_EQ(*read, recorder.replay());
    ASSERT_EQ(formatReplay(*read), text);

    ReplayPlayer player(*read, map);
    ActionState again;
    for (uint64_t tick = 0; tick < ticks; ++tick) {
      ASSERT_FALSE(player.finished());
      player.tick(again);
      for (ActionId i = 0; i < count; ++i) {
        ASSERT_EQ(again.quantised(i), played[tick].quantised(i)) << "tick " << tick + 1;
        ASSERT_EQ(again.pressed(i), played[tick].pressed(i));
        ASSERT_EQ(again.released(i), played[tick].released(i));
      }
    }
    EXPECT_TRUE(player.finished());
    player.tick(again);
    for (ActionId i = 0; i < count; ++i) EXPECT_EQ(again.quantised(i), 0);
    EXPECT_EQ(player.tickIndex(), ticks);
  }
}

TEST(Replay, ActionsAreFoundByNameInAnotherOrder) {
  const ActionMap recorded = gameMap();
  ReplayRecorder recorder(recorded, "l", 1);
  ActionState state;
  const int16_t values[] = {5, -6, 0, kFullValue};
  state.begin(values);
  recorder.record(state);
  const ActionMap grown = mapOf({{"pause", ActionKind::Button, {}},
                                 {"added", ActionKind::Axis, {}},
                                 {"restart", ActionKind::Button, {}},
                                 {"move_y", ActionKind::Axis, {}},
                                 {"move_x", ActionKind::Axis, {}}});
  Result<Replay> read = parseReplay(formatReplay(recorder.replay()), "r", &grown);
  ASSERT_TRUE(read.ok()) << read.error();
  ReplayPlayer player(*read, grown);
  ActionState again;
  player.tick(again);
  EXPECT_EQ(again.quantised(grown.id("move_x")), 5);
  EXPECT_EQ(again.quantised(grown.id("move_y")), -6);
  EXPECT_EQ(again.quantised(grown.id("added")), 0);
  EXPECT_TRUE(again.pressed(grown.id("pause")));
}

TEST(Replay, IsWrittenAndReadAsAFile) {
  const auto path =
      std::filesystem::path(testing::TempDir()) / fmt::format("scree_{}.replay", getpid());
  Replay replay;
  replay.level = "level1.glb";
  replay.content = 5;
  replay.actions = {{"move_x", ActionKind::Axis}};
  replay.changes = {{3, 0, -32767}, {9, 0, 0}};
  replay.ticks = 12;
  ASSERT_TRUE(writeReplay(path, replay).ok());
  Result<Replay> read = readReplay(path);
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_EQ(*read, replay);
  // What could not be read again is not written, and the old file stays.
  Replay bad = replay;
  bad.level = "two\nlines";
  EXPECT_FALSE(writeReplay(path, bad).ok());
  bad = replay;
  bad.changes[1].tick = 2;
  EXPECT_FALSE(writeReplay(path, bad).ok());
  EXPECT_EQ(*readReplay(path), replay);
  std::filesystem::remove(path);
  EXPECT_EQ(readReplay(path).error(), path.string() + ": no such file");
}

const std::string kHead =
    "scree-replay 2\nlevel level1.glb\ncontent 00c0ffee00c0ffee\nrate 60\nseed 7\n"
    "action move_x axis\naction pause button\nbegin\n";

// `text` up to the checksum, with the right checksum.
std::string sealed(const std::string& text) {
  return fmt::format("{}{:016x}\n", text, hashBytes(text.data(), text.size()));
}

TEST(Replay, TheSealedHeadIsAccepted) {
  const ActionMap map = gameMap();
  auto read = parseReplay(
      sealed(kHead + "1 move_x -32767\n1 pause 32767\n2 pause 0\nend 10 checksum "), "r", &map);
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_EQ(read.value().changes.size(), 3u);
  EXPECT_EQ(read.value().seed, 7u);
  EXPECT_EQ(read.value().content, 0x00c0ffee00c0ffeeu);
}

TEST(Replay, DamagedFilesAreRefusedWithTheirLine) {
  const std::string tail = "end 10 checksum ";
  const std::string good = sealed(kHead + "1 move_x 5\n" + tail);
  const auto head = [](const char* from, const char* to) {
    std::string text = kHead;
    const size_t at = text.find(from);
    text.replace(at, std::string(from).size(), to);
    return sealed(text + "end 10 checksum ");
  };
  const auto body = [&](const std::string& lines) { return sealed(kHead + lines + tail); };
  struct Case {
    std::string text;
    int line;
    std::string named;
  };
  std::string many_actions;
  for (int i = 0; i < 60; ++i) many_actions += fmt::format("action a{} axis\n", i);
  many_actions += "action move_y axis\naction restart button\naction more axis\n";
  const Case cases[] = {
      {"", 1, "the file ends here"},
      {"\n", 1, "expected a line that begins with 'scree-replay'"},
      {"scree-replay 1\n", 1, "'scree-replay 1' is not a version that is read; allowed is 'scree-replay 2'"},
      {"scree-replay 2", 1, "ends within this line"},
      {"scree-replay 2 \n", 1, "not a version"},
      {"\xef\xbb\xbfscree-replay 2\n", 1, "\\xef\\xbb\\xbf"},
      {"scree-replay 2\n", 2, "'level' is missing"},
      {head("level level1.glb", "level "), 2, "0 bytes"},
      {head("level1.glb", std::string(257, 'x').c_str()), 2, "257 bytes"},
      {head("level1.glb", std::string(5000, 'x').c_str()), 2, "a line of 5006 bytes"},
      {head("level1.glb", "a\tb"), 2, "control character 0x09 in column 8"},
      {head("content 00c0ffee00c0ffee\n", ""), 3, "expected a line that begins with 'content'"},
      {head("00c0ffee00c0ffee", "c0ffee00c0ffee"), 3, "content is 'c0ffee00c0ffee'; allowed are 16 of the digits 0 to 9 and a to f"},
      {head("00c0ffee00c0ffee", "00C0FFEE00C0FFEE"), 3, "content is '00C0FFEE00C0FFEE'"},
      {head("00c0ffee00c0ffee", "00c0ffee00c0ffee0"), 3, "content is '00c0ffee00c0ffee0'"},
      {head("00c0ffee00c0ffee", "0x00c0ffee00c0ff"), 3, "content is '0x00c0ffee00c0ff'"},
      {head("00c0ffee00c0ffee", "-0c0ffee00c0ffee"), 3, "content is '-0c0ffee00c0ffee'"},
      {head("00c0ffee00c0ffee", "00c0ffee 00c0ffee"), 3, "not of the form 'content DIGITS'"},
      {head("rate 60", "rate 0"), 4, "rate is '0'; allowed is a whole number from 1 to 1000"},
      {head("rate 60", "rate 60.0"), 4, "rate is '60.0'"},
      {head("rate 60", "rate 60 1"), 4, "not of the form 'rate TICKS_PER_SECOND'"},
      {head("seed 7", "seed -7"), 5, "seed is '-7'"},
      {head("seed 7", "seed 18446744073709551616"), 5, "seed is '18446744073709551616'"},
      {head("seed 7", "sead 7"), 5, "expected a line that begins with 'seed'"},
      {head("axis", "stick"), 6, "'stick'; allowed are axis, button"},
      {head("move_x", "fly"), 6, "action 'fly' is not one of this game"},
      {head("move_x axis", "move_x button"), 6, "kind 'button' here"},
      {head("pause button", "move_x axis"), 7, "given twice"},
      {head("begin\n", (many_actions + "begin\n").c_str()), 70, "more than 64 actions"},
      {head("begin\n", ""), 8, "expected 'action NAME axis|button' or 'begin'"},
      {body("0 move_x 5\n"), 9, "tick is '0'"},
      {body("-1 move_x 5\n"), 9, "tick is '-1'"},
      {body("5184001 move_x 5\n"), 9, "from 1 to 5184000"},
      {body("99999999999999999999999 move_x 5\n"), 9, "tick is '99999999999999999999999'"},
      {body("1e3 move_x 5\n"), 9, "tick is '1e3'"},
      {body("01 move_x 5\n"), 9, "tick is '01'"},
      {body("+1 move_x 5\n"), 9, "tick is '+1'"},
      {body("5 move_x 5\n4 move_x 6\n"), 10, "tick 4 comes after tick 5"},
      {body("5 move_y 5\n"), 9, "action 'move_y' is not one of the header"},
      {body("5 pause 32767\n5 move_x 5\n"), 10, "out of the header's order"},
      {body("5 move_x 5\n5 move_x 6\n"), 10, "out of the header's order"},
      {body("5 move_x 32768\n"), 9, "value is '32768'"},
      {body("5 move_x -32768\n"), 9, "from -32767 to 32767"},
      {body("5 move_x 0.5\n"), 9, "value is '0.5'"},
      {body("5 move_x -0\n"), 9, "value is '-0'"},
      {body("5 move_x nan\n"), 9, "value is 'nan'"},
      {body("5 pause 1\n"), 9, "allowed are 0 and 32767"},
      {body("5 pause -32767\n"), 9, "from 0 to 32767"},
      {body("5 move_x 5\n6 move_x 5\n"), 10, "already has the value 5"},
      {body("5 move_x 0\n"), 9, "already has the value 0"},
      {body("11 move_x 5\n"), 10, "the last change is at tick 11, after the end at 10"},
      {body("5  move_x 5\n"), 9, "not of the form 'TICK ACTION VALUE'"},
      {body("5 move_x 5 \n"), 9, "not of the form"},
      {body("5 move_x 5\r\n"), 9, "control character 0x0d"},
      {body(std::string("5 move_x 5\0\n", 12)), 9, "control character 0x00 in column 11"},
      {body("\n"), 9, "not of the form"},
      {body(std::string(100000, '5') + " move_x 5\n"), 9, "a line of 100009 bytes"},
      {kHead, 9, "'end TICKS checksum DIGITS' is missing"},
      {kHead + "1 move_x 5\n", 10, "is missing"},
      {kHead + "end 10\n", 9, "not of the form 'end TICKS checksum DIGITS'"},
      {kHead + "end 10 checksum 12\n", 9, "with 16 digits"},
      {kHead + "end 10 checksum 0123456789abcdef\n", 9, "the file was changed"},
      {sealed(kHead + "end 9999999999 checksum "), 9, "ticks is '9999999999'"},
      {good.substr(0, good.size() - 1), 10, "ends within this line"},
      {good + "\n", 11, "after the end"},
      {good + "2 move_x 6\n", 11, "'2 move_x 6\\x0a' after the end"},
      {good + std::string(1, '\0'), 11, "'\\x00' after the end"},
      {std::string(1000, '\0'), 1, "a line of 1000 bytes"},
      {std::string(10, '\0'), 1, "control character 0x00"},
  };
  ActionMap map = gameMap();
  for (int i = 0; i < 60; ++i) map.add({fmt::format("a{}", i), ActionKind::Axis, {}});
  ASSERT_TRUE(parseReplay(good, "r", &map).ok());
  for (const Case& damaged : cases) {
    const auto read = parseReplay(damaged.text, "f.replay", &map);
    ASSERT_FALSE(read.ok()) << damaged.named;
    const std::string& line = read.error();
    EXPECT_EQ(line.find(fmt::format("f.replay:{}: ", damaged.line)), 0u)
        << line << " / " << damaged.named;
    EXPECT_NE(line.find(damaged.named), std::string::npos)
        << line << "\n  lacks: " << damaged.named;
    EXPECT_LT(line.size(), 250u) << line;
    for (unsigned char c : line) ASSERT_TRUE(c >= 32 && c < 127) << line;
  }
}

TEST(Replay, EveryTruncationAndEveryFlippedBitIsRefused) {
  const std::string good =
      sealed(kHead + "1 move_x 5\n1 pause 32767\n30 pause 0\nend 99 checksum ");
  ASSERT_TRUE(parseReplay(good, "r").ok());
  for (size_t size = 0; size < good.size(); ++size)
    ASSERT_FALSE(parseReplay(good.substr(0, size), "r").ok()) << size;
  for (size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ (1 << bit));
      const auto read = parseReplay(bad, "r");
      ASSERT_FALSE(read.ok()) << "byte " << i << " bit " << bit;
      ASSERT_EQ(read.error().find('\n'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace scree
