// How much of what is hidden in a heap of impostors the depth pyramid finds, and what that saves, by distance.
#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "engine/core/hash.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "tests/bench/bean_heap.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

// Impostors that the last frame drew.
double drawnBy(HeapScene& scene) {
  const SwarmsDrawn& drawn = scene.world.singleton<const SwarmsDrawn>();
  double count = 0;
  for (size_t k = 0; k < drawn.size(); ++k) {
    rules::SwarmCommands commands{};
    gpu::readBuffer(*drawn.part(k).commands, &commands, sizeof(commands));
    for (const uint32_t r : {rules::kImpostor, rules::kSmallImpostor})
      count += commands.count[r] + commands.count[r + rules::kFirst];
  }
  return count;
}

struct Shown {
  double grains = 0;  // that some pixel shows
  uint64_t hash = 0;
};
Shown shownBy(HeapScene& scene) {
  const std::vector<uint32_t> numbers = gpu::readUints(scene.app.frame().texture(kSwarmVisible), 1);
  std::unordered_set<uint32_t> grains(numbers.begin(), numbers.end());
  grains.erase(0);
  return {static_cast<double>(grains.size()), hashBytes(numbers.data(), numbers.size() * sizeof(uint32_t))};
}

}  // namespace

SCREE_BENCH(occlusion, "a heap of beans as impostors: the share of the hidden ones that the depth pyramid culls") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  bench.sweeps("distance_m");
  const Heap heap = makeHeap(bench.quick() ? 100'000 : 400'000);
  const WorkFolder folder;
  HeapScene culled(heap, folder.path() / "bean.impostor"), all(heap, folder.path() / "bean.impostor");
  for (HeapScene* scene : {&culled, &all}) {
    scene->size = bench.quick() ? ivec2(640, 360) : ivec2(1280, 720);
    scene->world.singleton<LodSettings>().only = rules::kImpostor;
  }
  all.world.singleton<LodSettings>().cull = false;
  bench.progress("occlusion: {} beans", heap.beans.size());

  double least = 1;
  bool same = true;
  for (const double distance : {0.1, 0.25, 0.6, 1.5, 3.0}) {
    culled.look(distance);
    all.look(distance);
    const Paired timed = bench.paired({{"culled", [&] { culled.render(); }}, {"all", [&] { all.render(); }}});
    const double in_view = drawnBy(all), drawn = drawnBy(culled);
    const Shown shown = shownBy(culled), truth = shownBy(all);
    const double hidden = in_view - truth.grains, found = in_view - drawn;
    same = same && shown.hash == truth.hash;
    least = std::min(least, found / hidden);
    const double px = beanPx(heap, distance, culled.size.y);
    for (const bool cull : {true, false})
      bench.row({.scenario = fmt::format("{} m", distance),
                 .label = cull ? "culled" : "all in view",
                 .knobs = {{"beans", heap.beans.size()}, {"distance_m", distance}, {"nearest_px", px}},
                 .time_ms = timed.variants[cull ? 0 : 1].median_ms,
                 .error = cull ? 1 - found / hidden : 1,
                 .error_kind = "share of the impostors that no pixel shows that was drawn",
                 .hash = cull ? shown.hash : truth.hash,
                 .baseline = !cull,
                 .measured = {{"in view", in_view}, {"drawn", cull ? drawn : in_view}, {"shown", truth.grains}}});
  }
  bench.claimAtLeast("hidden impostors that are culled, worst distance", least, 0.7);
  bench.claimAtLeast("pictures with and without culling are the same", same ? 1 : 0, 1);
}

}  // namespace scree::bench
