// Runs of the committed win by the program, to be compared with each other.
#pragma once

#include <map>
#include <string>

namespace scree::hourglass {

// What must not change a state or a pixel.
struct Way {
  std::string context;      // egl or osmesa
  int threads;              // of the simulation
  int rasteriser_threads;   // of llvmpipe
};
std::string wayName(const Way& way);

struct Played {
  std::string hashes;  // a line a tick: "tick hash"
  std::string out;
  // PNG files by name, byte for byte (their encoder is deterministic): the first tick, and six more
  // evenly spread to the last.
  std::map<std::string, std::string> frames;
};

// Plays the whole win. What goes wrong fails the test.
Played playWin(const Way& way);

// Same hash at each tick, same bytes of each frame.
void expectSame(const Played& played, const Played& reference, const std::string& what);

}  // namespace scree::hourglass
