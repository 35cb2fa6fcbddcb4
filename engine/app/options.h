// What a run is asked for: the fields behind the common command-line flags.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/math.h"
#include "engine/platform/context.h"

namespace scree {

struct AppOptions {
  std::string title = "Scree";
  ContextKind context = ContextKind::Auto;
  ivec2 size{1280, 720};  // output, pixels
  int threads = 0;        // 0: one per core
#ifdef NDEBUG
  bool gl_debug = false;  // debug context: GL messages are logged
#else
  bool gl_debug = true;
#endif

  std::filesystem::path level_file;  // what is played: no output may replace it
  std::string level;               // name in recordings; a replay of another level is refused
  uint64_t level_content = 0;      // hash of what level_file holds; so is a replay of another content
  std::filesystem::path replay;    // empty: live input
  std::filesystem::path record;    // empty: off
  std::filesystem::path bindings;  // action bindings, JSON; empty: the defaults

  std::filesystem::path capture;         // folder; empty: off
  std::vector<uint64_t> capture_frames;  // ticks to capture
  uint64_t capture_every = 0;            // ticks between captures; 0: off
  bool capture_exr = false;              // linear radiance beside the PNG
  int truth = 1;                         // samples a pixel in captured frames

  std::filesystem::path hash_log;  // one line a tick: tick and state hash
  std::filesystem::path stats;     // JSON
  std::filesystem::path trace;     // Chrome trace
  bool print_frame = false;        // print the pass list of the last rendered frame
  uint64_t max_ticks = 0;          // 0: until quit or the replay's end
  std::vector<std::string> radiance_targets;  // EXR captures hold the first that was written
};

}  // namespace scree
