// Hashes of frames in which all representations and culling are at work, and processes that must print the same ones.
#pragma once

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "engine/core/hash.h"
#include "tests/swarms/bean_bed.h"

namespace scree::test {

inline constexpr int kHashedFrames = 6;

// One line "frame K HASH" a frame: of the G-buffer, the picture, ids, lists and routes.
inline void printFrameHashes() {
  BeanScene scene({320, 200});
  // Crumbs over large ones, so that all representations are seen at once; so many, in such disorder, that threads meet.
  scene.world.add(scene.show(scene.bean, beanBed(40, 6, 0.8f)), CastsShadow{});
  std::vector<SwarmGrain> crumbs = cloud(150'000, 14, 0.002f, 0.05f);
  for (SwarmGrain& crumb : crumbs) crumb.position.y = 0.1f * crumb.position.y + 1.5f;
  scene.show(scene.bean, crumbs);
  for (int frame = 0; frame < kHashedFrames; ++frame) {
    const double t = 0.05 * frame;
    scene.look({6 * t, 3 + t, 14 - 8 * t}, {0, -1, -4 * t}, 0.9f, 0.05f);
    scene.render();
    uint64_t hash = 0;
    for (const std::string_view target : {kGbufferAlbedo, kGbufferNormal, kRadiance}) {
      const std::vector<float> values = scene.floats(target, 4);
      hash = hashBytes(values.data(), values.size() * sizeof(float), hash);
    }
    const std::vector<float> depth = scene.floats(kGbufferDepth, 1);
    hash = hashBytes(depth.data(), depth.size() * sizeof(float), hash);
    for (const std::vector<uint32_t>& ids : {scene.ids(), gpu::readUints(scene.app.frame().texture(kSwarmVisible), 1)})
      hash = hashBytes(ids.data(), ids.size() * sizeof(uint32_t), hash);
    for (size_t k = 0; k < scene.drawn().size(); ++k) {
      const SwarmPart& part = scene.drawn().part(k);
      const lod::Routes& routes = *static_cast<const lod::Part&>(part).routes;
      rules::SwarmCommands commands{};
      gpu::readBuffer(*part.commands, &commands, sizeof(commands));
      hash = hashBytes(&commands, sizeof(commands), hash);
      for (const auto& words : {gpu::readBuffer<uint32_t>(routes.representations, part.count / 8),
                                gpu::readBuffer<uint32_t>(*part.list, commands.listed)})
        hash = hashBytes(words.data(), words.size() * sizeof(uint32_t), hash);
    }
    std::printf("frame %d %016llx\n", frame, static_cast<unsigned long long>(hash));
    const auto drawn = scene.drawnAs();
    for (const uint32_t r : {rules::kPoint, rules::kSmallImpostor, rules::kImpostor, rules::kMesh}) {
      ASSERT_GT(drawn[r], 20u) << "representation " << r << " is missing in frame " << frame;
    }
  }
  // Culling was at work: without it, more is drawn.
  const uint64_t hidden = scene.drawnAs()[rules::kNotDrawn];
  scene.settings().cull = false;
  scene.render();
  ASSERT_GT(hidden, scene.drawnAs()[rules::kNotDrawn] + 300);
}

// Runs the test of this program's that prints hashes, in `runs` processes for each number of threads.
inline void expectSameFrames(const std::string& test, int runs) {
  std::array<char, 4096> self{};
  ASSERT_GT(readlink("/proc/self/exe", self.data(), self.size() - 1), 0);
  std::map<std::string, std::map<std::string, int>> seen;  // by frame: how often each hash was
  for (const char* threads : {"1", "2", "4"})
    for (int run = 0; run < runs; ++run) {
      const std::string command = std::string("LP_NUM_THREADS=") + threads + " '" + self.data() + "' --gtest_filter=" + test + " 2>&1";
      FILE* output = popen(command.c_str(), "r");
      ASSERT_NE(output, nullptr);
      std::array<char, 256> line{};
      std::string text;
      while (std::fgets(line.data(), line.size(), output) != nullptr) {
        const std::string got(line.data());
        text += got;
        if (got.starts_with("frame ")) ++seen[got.substr(0, 7)][got.substr(8)];
      }
      ASSERT_EQ(pclose(output), 0) << command << '\n' << text;
    }
  EXPECT_EQ(seen.size(), static_cast<size_t>(kHashedFrames));
  for (const auto& [frame, hashes] : seen) {
    EXPECT_EQ(hashes.size(), 1u) << frame << " differs";
    EXPECT_EQ(hashes.begin()->second, 3 * runs) << frame;
  }
}

}  // namespace scree::test
