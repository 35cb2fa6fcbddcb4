// Plays level 1 with the bot until it is won, and writes the replay: for when the simulation or the
// level changed on purpose. Usage: record_win FILE
#include <fmt/format.h>

#include <cstdlib>

#include "engine/core/file.h"
#include "engine/platform/replay.h"
#include "game/rules/game.h"
#include "tests/game/support/bot.h"

int main(int argc, char** argv) {
  using namespace scree;
  if (argc != 2 || argv[1][0] == '-') {
    fmt::print(stderr, "usage: record_win FILE\n");
    return 2;
  }
  const std::filesystem::path level = contentRoot() / "levels" / "level1.glb";
  Result<std::unique_ptr<App>> opened = hourglass::openGame({}, level);
  if (!opened.ok()) {
    fmt::print(stderr, "{}\n", opened.error());
    return 2;
  }
  App& app = **opened;
  hourglass::Bot bot(app, {0.0, -1.5, 1.5, -2.6, 2.6, -0.75, 0.75}, -3.0, 3.6);
  ReplayRecorder recorder(app.actions(), app.options().level, app.options().level_content);
  ActionState& actions = app.world().singleton<ActionState>();
  constexpr uint64_t kMostTicks = 60 * 300, kAfterWin = 120;
  uint64_t after_win = 0;
  while (after_win < kAfterWin && app.tickIndex() < kMostTicks) {
    bot.act(actions);
    recorder.record(actions);
    app.tick();
    const auto state = app.world().singleton<const hourglass::Match>().state;
    if (state != hourglass::MatchState::Playing) ++after_win;
    if (app.tickIndex() % 300 == 0)
      fmt::print("{:5.1f} s  lanes {}  {}\n", static_cast<double>(app.tickIndex()) / 60,
                 bot.lanesDone(), hourglass::describeMatch(app.world()));
  }
  fmt::print("{}\n", hourglass::describeMatch(app.world()));
  if (Status status = writeReplay(argv[1], recorder.replay()); !status.ok()) {
    fmt::print(stderr, "{}\n", status.error());
    return 1;
  }
  return app.world().singleton<const hourglass::Match>().state == hourglass::MatchState::Won ? 0 : 1;
}
