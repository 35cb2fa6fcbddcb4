// hourglass: the game, its flags and its exit status.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "engine/app/command_line.h"
#include "engine/core/file.h"
#include "engine/core/log.h"
#include "game/rules/game.h"
#include "game/rules/rules.h"

namespace {

namespace fs = std::filesystem;

constexpr int kFine = 0, kFailed = 1, kBadInput = 2;

int exitStatus(const scree::Status& status) {
  scree::logError("{}", status.error());
  return status.errorKind() == scree::ErrorKind::Failure ? kFailed : kBadInput;
}

// A number names a level of the game; anything else is a glTF file.
scree::Result<fs::path> levelPath(const std::string& level) {
  if (level.empty()) return scree::Error{"--level: is empty; allowed is a level's number or a glTF file"};
  if (level.find_first_not_of("0123456789") != std::string::npos) return fs::path(level);
  const auto numbered = [](std::string_view number) {
    return scree::contentRoot() / "levels" / fmt::format("level{}.glb", number);
  };
  const fs::path path = numbered(level);
  std::error_code ignored;
  if (fs::exists(path, ignored)) return path;
  int count = 0;
  while (fs::exists(numbered(std::to_string(count + 1)), ignored)) ++count;
  return scree::Error{fmt::format("--level {}: no such level; allowed are 1 to {}, or a glTF file", level, count)};
}

int play(scree::AppOptions options, const fs::path& level) {
  scree::Result<std::unique_ptr<scree::App>> app =
      scree::hourglass::openGame(std::move(options), level);
  if (!app.ok()) return exitStatus(app.takeError());
  if (scree::Status status = (*app)->run(); !status.ok()) return exitStatus(status);
  fmt::print("{}\n", scree::hourglass::describeMatch((*app)->world()));
  return kFine;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli{"Hourglass: shoulder the grains onto the scale before the time runs out.\n"
               "W A S D or arrows walk, Q E turn the view, P pauses, R restarts, F1 inspects, Esc "
               "quits; a gamepad works too."};
  cli.set_version_flag("--version", SCREE_VERSION);
  std::string level = "1";
  cli.add_option("--level", level, "A level's number, or a glTF file (default 1)")
      ->type_name("N|FILE");
  scree::AppOptions options;
  scree::addCommonFlags(cli, options);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return cli.exit(success);
  } catch (const CLI::ParseError& error) {
    scree::logError("{} (see --help)", error.what());
    return kBadInput;
  }
  try {
    scree::Result<fs::path> path = levelPath(level);
    if (!path.ok()) return exitStatus(path.takeError());
    return play(std::move(options), *path);
  } catch (const std::exception& error) {
    scree::logError("{}", error.what());
    return kFailed;
  }
}
