// The game in a real window on a display of its own, played with synthetic keys.
#include <gtest/gtest.h>

#include <cstdlib>
#include <sys/wait.h>

#include "engine/core/file.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

int shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

TEST(Window, IsPlayedWithSyntheticKeys) {
  ASSERT_EQ(shell("command -v xvfb-run xauth xdotool >/dev/null"), 0)
      << "the packages xvfb, xauth and xdotool are needed";
  const fs::path folder = scratchFolder("window");
  const fs::path record = folder / "played.replay", script = folder / "play.sh";
  // Waits for the window, holds W, pauses and goes on, and quits; the game must then end by itself.
  ASSERT_TRUE(writeFile(script, R"(#!/bin/bash
"$1" --context window --size 320x180 --record "$2" 2>"$2.err" >"$2.out" &
game=$!
for i in $(seq 300); do xdotool search --name '^Hourglass$' >/dev/null 2>&1 && break; sleep 0.1; done
sleep 2
xdotool keydown w; sleep 1.5; xdotool keyup w
xdotool key p; sleep 0.5; xdotool key p; sleep 0.5
xdotool key Escape
for i in $(seq 300); do kill -0 $game 2>/dev/null || break; sleep 0.1; done
kill -9 $game 2>/dev/null && exit 99
wait $game
)").ok());
  const fs::path program = fs::path(SCREE_BINARY_DIR) / "bin/hourglass";
  EXPECT_EQ(shell("timeout 120 xvfb-run -a -s '-screen 0 800x600x24' bash '" + script.string() + "' '" +
                  program.string() + "' '" + record.string() + "'"),
            0)
      << readText(record.string() + ".err").value();
  Result<std::string> played = readText(record);
  ASSERT_TRUE(played.ok()) << played.error();
  for (const char* action : {" move_y 32767\n", " move_y 0\n", " pause 32767\n", " quit 32767\n"})
    EXPECT_NE(played.value().find(action), std::string::npos) << action;
  EXPECT_NE(readText(record.string() + ".err").value().find("window: "), std::string::npos);
}

}  // namespace
}  // namespace scree::hourglass
