// The committed win, played again: the same states and the same pixels, whatever draws or computes.
#include <gtest/gtest.h>

#include "engine/core/file.h"
#include "tests/game/support/program.h"
#include "tests/game/support/replay_run.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

// Each value of each kind; the slow tier has all combinations.
TEST(Replay, IsAWinAndTheSameForEveryThreadCountAndContext) {
  const Way first{"egl", 1, 0};
  const Played reference = playWin(first);
  const size_t won = reference.out.find("won: ");
  EXPECT_NE(won, std::string::npos) << reference.out;
  EXPECT_EQ(won, reference.out.rfind("won: "));
  for (const Way& way : {Way{"egl", 2, 1}, Way{"osmesa", 2, 2}})
    expectSame(playWin(way), reference, wayName(way) + " against " + wayName(first));
}

TEST(Replay, RecordingAReplayGivesTheSameFile) {
  const fs::path win = fs::path(SCREE_SOURCE_DIR) / "tests/game/replays/level1_win.replay";
  const fs::path copy = scratchFolder("rerecord") / "copy.replay";
  const ProgramRun run = runProgram(
      "hourglass", {"--replay", win.string(), "--record", copy.string(), "--context", "egl"}, 580);
  ASSERT_EQ(run.status, 0) << run.err;
  Result<std::string> original = readText(win), again = readText(copy);
  ASSERT_TRUE(original.ok() && again.ok());
  EXPECT_TRUE(*original == *again);
}

}  // namespace
}  // namespace scree::hourglass
