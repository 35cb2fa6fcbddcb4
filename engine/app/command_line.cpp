// Flags through CLI11.
#include "engine/app/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <vector>

#include "engine/core/file.h"

namespace scree {
namespace {

// Largest output side, pixels, and most samples a pixel, ticks and threads that a flag may ask for.
constexpr int kMaxSide = 8192;
constexpr int kMaxSamples = 65536;
constexpr uint64_t kMaxTicks = 100'000'000;
constexpr int kMaxThreads = 256;

bool parseWhole(std::string_view text, uint64_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

std::string parseSize(const std::string& text, ivec2& size) {
  const size_t cross = text.find('x');
  uint64_t width = 0, height = 0;
  if (cross == std::string::npos || !parseWhole(std::string_view(text).substr(0, cross), width) ||
      !parseWhole(std::string_view(text).substr(cross + 1), height) || width < 1 || height < 1 ||
      width > kMaxSide || height > kMaxSide)
    return fmt::format("'{}' is not WIDTHxHEIGHT with sides of 1 to {} pixels", text, kMaxSide);
  size = {static_cast<int>(width), static_cast<int>(height)};
  return {};
}

std::string parseTicks(const std::string& text, std::vector<uint64_t>& ticks) {
  ticks.clear();
  size_t at = 0;
  while (at <= text.size()) {
    const size_t comma = std::min(text.find(',', at), text.size());
    uint64_t tick = 0;
    if (!parseWhole(std::string_view(text).substr(at, comma - at), tick) || tick < 1 ||
        tick > kMaxTicks)
      return fmt::format("'{}' is not a list of ticks like 60,120 (each 1 to {})", text, kMaxTicks);
    ticks.push_back(tick);
    at = comma + 1;
  }
  std::sort(ticks.begin(), ticks.end());
  ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
  return {};
}

// A path; an empty one is refused, not taken for "not given".
void addPath(CLI::App& cli, const std::string& flag, const std::string& type,
             const std::string& help, std::filesystem::path& path) {
  cli.add_option(flag, path, help)->type_name(type)->check([](const std::string& text) {
    return text.empty() ? std::string("is empty; allowed is a path") : std::string();
  });
}

// A flag whose text a function turns into a value, or refuses with a reason.
template <class Parse>
void addParsed(CLI::App& cli, const std::string& flag, const std::string& type,
               const std::string& help, Parse parse) {
  cli.add_option_function<std::string>(
         flag,
         [flag, parse](const std::string& text) {
           if (const std::string reason = parse(text); !reason.empty())
             throw CLI::ValidationError(flag, reason);
         },
         help)
      ->type_name(type);
}

}  // namespace

void addCommonFlags(CLI::App& cli, AppOptions& options) {
  addParsed(cli, "--size", "WxH", "Output size in pixels (default 1280x720)",
            [&](const std::string& text) { return parseSize(text, options.size); });
  addParsed(cli, "--context", "KIND",
            "auto, window, egl or osmesa; auto takes the first that works (default auto)",
            [&](const std::string& text) -> std::string {
              Result<ContextKind> kind = parseContextKind(text);
              if (!kind.ok()) return kind.error();
              options.context = *kind;
              return {};
            });
  cli.add_option("--threads", options.threads, "Threads of the simulation; 0: one per core")
      ->type_name("N")
      ->check(CLI::Range(0, kMaxThreads));
  addPath(cli, "--replay", "FILE", "Play recorded actions", options.replay);
  addPath(cli, "--record", "FILE", "Record the actions of this run", options.record);
  addPath(cli, "--bindings", "FILE", "Keys and buttons of the actions, JSON", options.bindings);
  cli.add_option("--ticks", options.max_ticks, "End after this many ticks of 1/60 s")
      ->type_name("N")
      ->check(CLI::Range(uint64_t{1}, kMaxTicks));

  addPath(cli, "--capture", "DIR", "Write frames and a contact sheet to this folder", options.capture);
  addParsed(cli, "--frames", "LIST", "Ticks to capture, like 60,120",
            [&](const std::string& text) { return parseTicks(text, options.capture_frames); });
  cli.add_option("--every", options.capture_every, "Capture every N-th tick")
      ->type_name("N")
      ->check(CLI::Range(uint64_t{1}, kMaxTicks));
  cli.add_flag("--exr", options.capture_exr, "Also write linear radiance as EXR (the PNG may then differ by one step)");
  cli.add_option("--truth", options.truth, "Samples a pixel in captured frames (default 1)")
      ->type_name("N")
      ->check(CLI::Range(1, kMaxSamples));

  addPath(cli, "--hash-log", "FILE", "Write a line a tick: tick and state hash", options.hash_log);
  addPath(cli, "--stats", "FILE", "Write times and counts of the run, JSON", options.stats);
  addPath(cli, "--trace", "FILE", "Write a Chrome trace of systems and passes", options.trace);
  cli.add_flag("--print-frame", options.print_frame,
               "At the end, print which passes of the frame are on, and why");
  cli.add_flag("--gl-debug", options.gl_debug, "Log messages of the GL driver");
}

namespace {

namespace fs = std::filesystem;

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// A name that captures use.
bool isCaptured(const std::string& name) {
  return name == "contact_sheet.png" || name.starts_with("frame_");
}

// Files to be written: each in a place where one can be, and none of them another's, or read.
Status checkOutputs(const AppOptions& options) {
  struct Named {
    const char* flag;
    const fs::path& path;
  };
  const std::array<Named, 4> outputs{{{"--record", options.record},
                                      {"--hash-log", options.hash_log},
                                      {"--stats", options.stats},
                                      {"--trace", options.trace}}};
  std::vector<Named> taken{{"--level", options.level_file},
                           {"--replay", options.replay},
                           {"--bindings", options.bindings}};
  for (const Named& output : outputs) {
    if (output.path.empty()) continue;
    if (Status status = checkOutputPath(output.path, output.flag); !status.ok()) return status;
    for (const Named& other : taken) {
      if (!other.path.empty() && areSameFile(other.path, output.path))
        return Error{fmt::format("{} and {} name the same file '{}'", other.flag, output.flag,
                                 output.path.string())};
    }
    if (!options.capture.empty() && areSameFile(options.capture, folderOf(output.path)) &&
        isCaptured(output.path.filename().string()))
      return Error{fmt::format("--capture and {} name the same file '{}'", output.flag,
                               output.path.string())};
    taken.push_back(output);
  }
  return Done{};
}

}  // namespace

Status checkOptions(const AppOptions& options) {
  if (Status status = checkOutputs(options); !status.ok()) return status;
  const bool picks = !options.capture_frames.empty() || options.capture_every > 0;
  if (options.capture.empty()) {
    if (picks) return Error{"--frames and --every need --capture DIR"};
    if (options.capture_exr) return Error{"--exr needs --capture DIR"};
    if (options.truth > 1) return Error{"--truth needs --capture DIR"};
  } else if (!picks) {
    return Error{"--capture needs --frames LIST or --every N"};
  }
  return Done{};
}

}  // namespace scree
