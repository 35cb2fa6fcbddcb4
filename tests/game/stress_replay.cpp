// The committed win in every combination of context, threads and rasteriser threads.
#include <gtest/gtest.h>

#include "tests/game/support/replay_run.h"

namespace scree::hourglass {
namespace {

TEST(Replay, IsTheSameInEveryCombination) {
  const Way first{"egl", 1, 0};
  const Played reference = playWin(first);
  for (const char* context : {"egl", "osmesa"}) {
    for (const int threads : {1, 2}) {
      for (const int rasteriser_threads : {0, 1, 2}) {
        const Way way{context, threads, rasteriser_threads};
        expectSame(playWin(way), reference, wayName(way) + " against " + wayName(first));
      }
    }
  }
}

}  // namespace
}  // namespace scree::hourglass
