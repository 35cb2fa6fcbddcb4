// A flight past a heap of beans, frame by frame, with culling and without: runs of grains fall asleep behind what hides
// them and wake when it does no more, and no pixel shows it.
#include <algorithm>
#include <cmath>

#include "modules/impostors/impostors.h"
#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class ImpostorsFlight : public GlTest {};

struct Heap : SwarmScene {
  Heap(std::span<const SwarmGrain> grains, bool cull) : SwarmScene({160, 120}) {
    addImpostors(app);
    Result<uint32_t> shape = loadGrainShape(world, std::string(SCREE_SOURCE_DIR) + "/content/models/coffee_bean.glb",
                                            {.edge = 5, .texels = 32, .directions = 2},
                                            std::string(SCREE_BINARY_DIR) + "/bean_flight.impostor");
    EXPECT_TRUE(shape.ok());
    world.singleton<LodSettings>().cull = cull;
    world.singleton<LodSettings>().band = 0;  // or what was culled before decides how a grain is drawn
    if (shape.ok()) show(*shape, grains);
  }
  std::vector<uint32_t> shown() {
    render();
    return gpu::readUints(app.frame().texture(kSwarmVisible), 1);
  }
  // A run each: whether it sleeps in the next frame if that is told of by this one.
  std::vector<bool> hiddenRuns() {
    const auto& part = static_cast<const lod::Part&>(drawn().part(0));
    const auto counts = gpu::readBuffer<glm::uvec4>(part.routes->counts, part.runs);
    std::vector<bool> hidden(counts.size());
    for (size_t run = 0; run < counts.size(); ++run) hidden[run] = rules::onlyHidden(counts[run]);
    return hidden;
  }
};

// Places in a ball, as dense as beans lie.
std::vector<SwarmGrain> heap(size_t count, float shift) {
  std::vector<SwarmGrain> grains = cloud(count, 1, 0.045f, 0.05f);
  for (SwarmGrain& grain : grains) {
    const float length = glm::length(grain.position);
    if (length > 1) grain.position *= 0.9f / length;
    grain.position.x += shift * grain.position.y;
  }
  return grains;
}

TEST_F(ImpostorsFlight, NoPixelShowsWhatSleeps) {
  constexpr size_t kCount = 20'000;
  std::vector<SwarmGrain> grains = heap(kCount, 0);
  Heap culled(grains, true), all(grains, false);
  size_t missing = 0, ties = 0, slept = 0, woke = 0, frames = 0;
  std::vector<bool> before;
  double angle = 0, distance = 3, fov = 0.8;
  for (int frame = 0; frame < 120; ++frame) {
    // Around it, into it and through it, back out; then faster, by turns that tell nothing, and through another lens.
    angle += frame < 90 ? 0.02 : 0.15;
    distance += frame < 30 ? 0 : frame < 60 ? -0.08 : frame < 80 ? 0.15 : 0;
    if (frame == 100) fov = 0.2;
    if (frame == 110) fov = 1.4;
    if (frame % 40 == 39) {
      grains = heap(kCount, 0.01f * static_cast<float>(frame));
      for (Heap* scene : {&culled, &all}) scene->world.singleton<SwarmStore>().replace(0, grains);
    }
    for (Heap* scene : {&culled, &all})
      scene->look({distance * std::sin(angle), 0.3, distance * std::cos(angle)}, {0.2 * std::sin(7 * angle), 0, 0}, static_cast<float>(fov), 0.01f);
    const std::vector<uint32_t> some = culled.shown(), every = all.shown();
    const std::vector<uint32_t> routes = culled.routes();
    for (size_t pixel = 0; pixel < every.size(); ++pixel) {
      if (some[pixel] == every[pixel]) continue;
      const bool left_out = every[pixel] != 0 && routes[every[pixel] - 1] == rules::kNotDrawn;
      ++(left_out || every[pixel] == 0 ? missing : ties);
    }
    ASSERT_EQ(missing, 0u) << "frame " << frame;
    const std::vector<bool> now = culled.hiddenRuns();
    slept += static_cast<size_t>(std::ranges::count(now, true));
    for (size_t run = 0; run < before.size(); ++run) woke += before[run] && !now[run];
    before = now;
    frames += now.size();
  }
  std::printf("%.0f %% of the runs sleep, %zu woke; %zu pixels with ties\n", 100 * static_cast<double>(slept) / static_cast<double>(frames), woke, ties);
  EXPECT_GT(slept, frames / 25);
  EXPECT_GT(woke, 100u);
  EXPECT_LT(ties, 20u);
}

}  // namespace
}  // namespace scree::test
