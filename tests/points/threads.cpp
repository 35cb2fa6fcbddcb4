// The same picture to the bit in every run, with one, two and four threads of the rasteriser: of whole processes.
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>

#include "engine/core/hash.h"
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class Threads : public GlTest {};

// Printed for the test below.
TEST_F(Threads, Hash) {
  for (int run = 0; run < 5; ++run) {
    PointScene scene({64, 48});
    scene.sun({0.4, 1, 0.6});
    scene.look({0, 100, 170}, {0, 0, 0}, 0.24f);
    const auto grains = pouredBed(0.3f, {20, 24}, 1);
    scene.show(scene.addBall(vec3(1), 1, 0), grains);
    scene.show(scene.addBall(vec3(1), 1, 1), cloud(5000, 12, 0.05f, 0.6f));
    scene.show(scene.addBall(vec3(1), 1, 0), cloud(200'000, 14, 0.04f, 0.09f));  // some stand for all
    scene.render();
    uint64_t hash = 0;
    for (const std::string_view target : {kGbufferAlbedo, kGbufferNormal, kRadiance}) {
      const std::vector<float> values = scene.floats(target, 4);
      hash = hashBytes(values.data(), values.size() * sizeof(float), hash);
    }
    const std::vector<uint32_t> ids = scene.ids();
    std::printf("hash %016llx\n", static_cast<unsigned long long>(hashBytes(ids.data(), ids.size() * sizeof(uint32_t), hash)));
  }
}

TEST(ThreadsOfProcesses, AllDrawTheSame) {
  std::array<char, 4096> self{};
  ASSERT_GT(readlink("/proc/self/exe", self.data(), self.size() - 1), 0);
  std::multiset<std::string> hashes;
  for (const char* threads : {"1", "2", "4"}) {
    const std::string command = std::string("LP_NUM_THREADS=") + threads + " '" + self.data() + "' --gtest_filter=Threads.Hash";
    FILE* output = popen(command.c_str(), "r");
    ASSERT_NE(output, nullptr);
    std::array<char, 256> line{};
    while (std::fgets(line.data(), line.size(), output) != nullptr)
      if (std::string(line.data()).starts_with("hash ")) hashes.insert(line.data());
    ASSERT_EQ(pclose(output), 0) << command;
  }
  EXPECT_EQ(hashes.size(), 15u);
  for (const std::string& hash : hashes) EXPECT_EQ(hash, *hashes.begin());
}

}  // namespace
}  // namespace scree::test
