// The same as threads.cpp in twenty processes for each number of threads.
#include "tests/swarms/same_frames.h"

namespace scree::test {
namespace {

class StressSwarmThreads : public GlTest {};

TEST_F(StressSwarmThreads, Hash) { printFrameHashes(); }

TEST(StressSwarmThreadsOfProcesses, AllDrawTheSame) { expectSameFrames("StressSwarmThreads.Hash", 20); }

}  // namespace
}  // namespace scree::test
