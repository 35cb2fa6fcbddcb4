// Running the program on the committed win, and comparing what it left.
#include "tests/game/support/replay_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/core/file.h"
#include "engine/platform/replay.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kFrames = 6;
// Enough to see every part of the level, small enough for each run of the tests.
constexpr const char* kSize = "320x180";

}  // namespace

std::string wayName(const Way& way) {
  return fmt::format("{}_threads{}_raster{}", way.context, way.threads, way.rasteriser_threads);
}

Played playWin(const Way& way) {
  const fs::path win = fs::path(SCREE_SOURCE_DIR) / "tests/game/replays/level1_win.replay";
  const Result<Replay> replay = readReplay(win);
  EXPECT_TRUE(replay.ok()) << replay.error();
  if (!replay.ok()) return {};
  const uint64_t ticks = replay.value().ticks;
  std::string frames = "1";
  for (uint64_t i = 1; i <= kFrames; ++i) frames += fmt::format(",{}", ticks * i / kFrames);

  const fs::path folder = scratchFolder("replay_" + wayName(way));
  const ProgramRun run = runProgram(
      "hourglass",
      {"--replay", win.string(), "--hash-log", (folder / "hashes").string(), "--context", way.context,
       "--threads", std::to_string(way.threads), "--size", kSize, "--frames", frames, "--capture",
       (folder / "frames").string()},
      580, {fmt::format("LP_NUM_THREADS={}", way.rasteriser_threads)});
  EXPECT_EQ(run.status, 0) << wayName(way) << ": " << run.err;
  Played played;
  played.out = run.out;
  if (Result<std::string> hashes = readText(folder / "hashes"); hashes.ok()) played.hashes = *hashes;
  EXPECT_EQ(static_cast<uint64_t>(std::count(played.hashes.begin(), played.hashes.end(), '\n')), ticks)
      << wayName(way) << ": a hash for each tick";
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator(folder / "frames", ignored)) {
    Result<std::string> bytes = readText(file.path());
    if (file.path().extension() == ".png" && bytes.ok()) played.frames[file.path().filename()] = *bytes;
  }
  EXPECT_EQ(played.frames.size(), kFrames + 2) << wayName(way) << ": frames and a contact sheet";
  return played;
}

void expectSame(const Played& played, const Played& reference, const std::string& what) {
  if (played.hashes != reference.hashes) {
    const auto [here, there] = std::mismatch(played.hashes.begin(), played.hashes.end(),
                                             reference.hashes.begin(), reference.hashes.end());
    ADD_FAILURE() << what << ": state hashes differ from tick "
                  << std::count(played.hashes.begin(), here, '\n') + 1 << " on";
  }
  for (const auto& [name, bytes] : reference.frames) {
    const auto found = played.frames.find(name);
    EXPECT_TRUE(found != played.frames.end() && found->second == bytes)
        << what << ": other pixels in " << name;
  }
}

}  // namespace scree::hourglass
