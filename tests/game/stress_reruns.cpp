// No false alarm: every moment drawn a hundred times in one process, each time the same and within
// the gate's bounds of its golden. Run with one and with two rasteriser threads (LP_NUM_THREADS).
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "engine/gpu/gl.h"
#include "tests/game/support/moments.h"

namespace scree::hourglass {
namespace {

using images::Image;

constexpr int kReruns = 100;

// Threads of this process that llvmpipe named.
int rasteriserThreads() {
  int count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    count += name.starts_with("llvmpipe");
  }
  return count;
}

TEST_F(MomentTest, AHundredRerunsRaiseNoAlarm) {
  playTo(kMoments[0]);
  draw();  // after which all its threads have begun and have their names
  const char* wanted = std::getenv("LP_NUM_THREADS");
  const std::string renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  if (wanted && renderer.find("llvmpipe") != std::string::npos) {
    EXPECT_EQ(std::to_string(rasteriserThreads()), wanted);
  }
  for (const uint64_t moment : kMoments) {
    playTo(moment);
    SCOPED_TRACE(fmt::format("tick {}", moment));
    const Result<Image> golden = images::readImage(images::goldenPath(momentName(moment)));
    ASSERT_TRUE(golden.ok()) << golden.error();
    const Image first = draw();
    for (int i = 1; i <= kReruns; ++i) {
      const Image again = draw();
      ASSERT_TRUE(again.rgb == first.rgb && again.ids == first.ids) << "rerun " << i << " differs";
      const images::GateResult result =
          images::compareImages(images::quantised(again), golden.value(), momentBounds());
      ASSERT_TRUE(result.passed) << "rerun " << i << ": " << result.message;
    }
  }
}

}  // namespace
}  // namespace scree::hourglass
