// Frames of a moving camera over meshes, impostors and points, with what hides others: the same to the bit in every run,
// with one, two and four threads of the rasteriser; of whole processes.
#include "tests/swarms/same_frames.h"

namespace scree::test {
namespace {

class SwarmThreads : public GlTest {};

// Printed for the test below.
TEST_F(SwarmThreads, Hash) { printFrameHashes(); }

TEST(SwarmThreadsOfProcesses, AllDrawTheSame) { expectSameFrames("SwarmThreads.Hash", 2); }

}  // namespace
}  // namespace scree::test
