// The committed win, played again: the same states and the same pixels, whatever draws or computes.
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/core/file.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

const fs::path kReplay = fs::path(SCREE_SOURCE_DIR) / "tests/game/replays/level1_win.replay";
// Captured ticks and size: enough to see every part of the level, small enough for CI.
constexpr const char* kFrames = "60,600";
constexpr const char* kSize = "320x180";

struct Played {
  std::string hashes;
  std::string out;
  fs::path folder;
};

Played playReplay(const std::string& name, const std::vector<std::string>& extra) {
  Played played;
  played.folder = scratchFolder("replay_" + name);
  std::vector<std::string> arguments{"--replay", kReplay.string(), "--hash-log",
                                     (played.folder / "hashes").string()};
  arguments.insert(arguments.end(), extra.begin(), extra.end());
  const ProgramRun run = runProgram("hourglass", arguments, 580);
  EXPECT_EQ(run.status, 0) << run.err;
  played.out = run.out;
  Result<std::string> hashes = readText(played.folder / "hashes");
  EXPECT_TRUE(hashes.ok());
  if (hashes.ok()) played.hashes = *hashes;
  return played;
}

std::vector<std::string> drawing(const std::string& name, const std::string& context,
                                 const std::string& threads) {
  return {"--context", context, "--threads", threads, "--size", kSize, "--frames", kFrames, "--capture",
          (fs::path(SCREE_BINARY_DIR) / "scratch" / ("replay_" + name) / "frames").string()};
}

// The PNG files, byte for byte: their encoder is deterministic.
std::string pixels(const Played& played) {
  std::string all;
  for (const char* frame : {"frame_000060.png", "frame_000600.png", "contact_sheet.png"}) {
    Result<std::string> file = readText(played.folder / "frames" / frame);
    EXPECT_TRUE(file.ok()) << frame;
    if (file.ok()) all += *file;
  }
  return all;
}

TEST(Replay, IsAWinAndTheSameForEveryThreadCountAndContext) {
  const Played egl_one = playReplay("egl1", drawing("egl1", "egl", "1"));
  EXPECT_EQ(egl_one.out.find("won: "), egl_one.out.rfind("won: "));
  EXPECT_NE(egl_one.out.find("won: "), std::string::npos) << egl_one.out;
  const auto ticks = std::count(egl_one.hashes.begin(), egl_one.hashes.end(), '\n');
  EXPECT_GT(ticks, 600);

  const Played egl_two = playReplay("egl2", drawing("egl2", "egl", "2"));
  EXPECT_TRUE(egl_two.hashes == egl_one.hashes) << "state hashes differ between 1 and 2 threads";
  EXPECT_TRUE(pixels(egl_two) == pixels(egl_one)) << "pixels differ between 1 and 2 threads";

  const Played osmesa = playReplay("osmesa", drawing("osmesa", "osmesa", "2"));
  EXPECT_TRUE(osmesa.hashes == egl_one.hashes) << "state hashes differ between EGL and OSMesa";
  EXPECT_TRUE(pixels(osmesa) == pixels(egl_one)) << "pixels differ between EGL and OSMesa";
}

TEST(Replay, RecordingAReplayGivesTheSameFile) {
  const fs::path copy = scratchFolder("rerecord") / "copy.replay";
  const ProgramRun run = runProgram(
      "hourglass", {"--replay", kReplay.string(), "--record", copy.string(), "--context", "egl"}, 580);
  ASSERT_EQ(run.status, 0) << run.err;
  Result<std::string> original = readText(kReplay), again = readText(copy);
  ASSERT_TRUE(original.ok() && again.ok());
  EXPECT_TRUE(*original == *again);
}

}  // namespace
}  // namespace scree::hourglass
