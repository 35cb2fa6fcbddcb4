// game/play.sh in a tree of its own: help without a build, the window if there is one, and the
// recorded win, with one line that says why, if there is none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "engine/core/file.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

// The script beside a build script that only says so, and a game that `game_script` acts.
class Play : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"game", "engine", "build/bin"}) fs::create_directories(root_ / folder);
    fs::copy_file(fs::path(SCREE_SOURCE_DIR) / "game/play.sh", root_ / "game/play.sh");
    script("engine/build.sh", "echo built >>\"$(dirname \"$0\")/builds\"");
  }

  void script(const fs::path& name, const std::string& body) {
    const fs::path path = root_ / name;
    ASSERT_TRUE(writeFile(path, "#!/bin/bash\n" + body + "\n").ok());
    fs::permissions(path, fs::perms::owner_all);
  }

  // The game as built, but the recorded win is only named.
  void useTheGame() {
    const fs::path program = fs::path(SCREE_BINARY_DIR) / "bin/hourglass";
    script("build/bin/hourglass", "case \"$*\" in *--replay*) echo \"plays $*\"; exit 0 ;; esac\n"
                                  "exec '" + program.string() + "' \"$@\"");
  }

  ProgramRun play(const std::vector<std::string>& arguments,
                  const std::vector<std::string>& environment = {}) {
    return runCommand((root_ / "game/play.sh").string(), arguments, environment, 60);
  }
  bool built() const { return fs::exists(root_ / "engine/builds"); }

  fs::path root_ = scratchFolder("play");
};

TEST_F(Play, HelpNeedsNoBuild) {
  for (const std::vector<std::string>& flags : {std::vector<std::string>{"--help"}, {"--level", "1", "-h"}}) {
    fs::remove(root_ / "build/bin/hourglass");
    const ProgramRun unbuilt = play(flags);
    EXPECT_EQ(unbuilt.status, 0) << unbuilt.err;
    EXPECT_NE(unbuilt.out.find("Usage: game/play.sh"), std::string::npos) << unbuilt.out;
    useTheGame();
    const ProgramRun after = play(flags);
    EXPECT_EQ(after.status, 0) << after.err;
    for (const char* part : {"Usage: game/play.sh", "--level", "--replay", "--context"})
      EXPECT_NE(after.out.find(part), std::string::npos) << after.out;
    EXPECT_FALSE(built());
  }
}

TEST_F(Play, FlagsGoToTheGame) {
  script("build/bin/hourglass", "echo \"flags: $*\"; exit 5");
  const ProgramRun run = play({"--level", "a b"});
  EXPECT_TRUE(built());
  EXPECT_EQ(run.status, 5);
  EXPECT_EQ(run.out, "flags: --level a b\n");
}

TEST_F(Play, WithoutAWindowTheRecordedWinIsPlayed) {
  useTheGame();
  // No display, one that does not exist, and one whose name makes no sense: what is said of each.
  const std::pair<std::vector<std::string>, const char*> displays[] = {
      {{}, "DISPLAY"}, {{"DISPLAY=:7654"}, ":7654"}, {{"DISPLAY=nonsense"}, "nonsense"}};
  for (const auto& [environment, name] : displays) {
    const ProgramRun run = play({}, environment);
    EXPECT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.err, "") << name;
    const size_t line_end = run.out.find('\n');
    const std::string why = run.out.substr(0, line_end);
    EXPECT_EQ(why.find("No window (X11: "), 0u) << run.out;
    EXPECT_NE(why.find(name), std::string::npos) << why;
    EXPECT_EQ(run.out.find("plays --replay ", line_end), line_end + 1) << run.out;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 2) << run.out;
    EXPECT_TRUE(fs::is_directory(root_ / "build/captures/level1_win"));
  }
}

TEST_F(Play, AGameThatFailsIsNotReplacedByTheRecordedWin) {
  script("build/bin/hourglass",
         "case \"$*\" in *--replay*) echo replayed ;; *) echo played; echo 'error: lost' >&2; exit 1 ;; esac");
  const ProgramRun failed = play({}, {"DISPLAY=:0"});
  EXPECT_EQ(failed.status, 1);
  EXPECT_EQ(failed.out, "played\n");
  EXPECT_EQ(failed.err, "error: lost\n");
  script("build/bin/hourglass", "echo \"played $*\"");
  const ProgramRun fine = play({}, {"DISPLAY=:0"});
  EXPECT_EQ(fine.status, 0);
  EXPECT_EQ(fine.out, "played --context window\n");
}

}  // namespace
}  // namespace scree::hourglass
