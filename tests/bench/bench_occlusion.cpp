// How much of what is hidden in heaps of impostors the depth pyramid finds, and what that saves: of beans by distance,
// of other grains by the ratio of their inner to their outer radius.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unordered_set>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/impostors/impostors.h"
#include "tests/bench/bean_heap.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"
#include "tests/bench/stack_shapes.h"

namespace scree::bench {
namespace {

struct Drawn {
  double count = 0;         // impostors that the last frame drew
  std::vector<bool> which;  // by number
};
Drawn drawnBy(HeapScene& scene) {
  const SwarmsDrawn& swarms = scene.world.singleton<const SwarmsDrawn>();
  Drawn drawn{0, std::vector<bool>(swarms.grainCount())};
  for (size_t k = 0; k < swarms.size(); ++k) {
    const SwarmPart& part = swarms.part(k);
    rules::SwarmCommands commands{};
    gpu::readBuffer(*part.commands, &commands, sizeof(commands));
    for (const uint32_t r : {rules::kImpostor, rules::kSmallImpostor})
      for (const uint32_t list : {r, r + rules::kFirst}) {
        drawn.count += commands.count[list];
        for (const uint32_t grain : gpu::readBuffer<uint32_t>(*part.list, commands.count[list], 4 * size_t{commands.begin[list]}))
          drawn.which[part.first + grain] = true;
      }
  }
  return drawn;
}

struct Shown {
  double grains = 0;  // that some pixel shows
  uint64_t hash = 0;
  std::vector<uint32_t> numbers;  // which grain each pixel shows, + 1
};
Shown shownBy(HeapScene& scene) {
  std::vector<uint32_t> numbers = gpu::readUints(scene.app.frame().texture(kSwarmVisible), 1);
  std::unordered_set<uint32_t> grains(numbers.begin(), numbers.end());
  grains.erase(0);
  const uint64_t hash = hashBytes(numbers.data(), numbers.size() * sizeof(uint32_t));
  return {static_cast<double>(grains.size()), hash, std::move(numbers)};
}

// Pixels whose grain was not drawn with culling. Of grains at the same depth, the first one drawn shows, and which one
// that is depends on the frame before: no fault.
double missing(const Shown& truth, const Shown& shown, const Drawn& drawn) {
  double pixels = 0;
  for (size_t p = 0; p < truth.numbers.size(); ++p) {
    const uint32_t number = truth.numbers[p];
    pixels += number != shown.numbers[p] && (number == 0 || !drawn.which[number - 1]);
  }
  return pixels;
}

// ---- By r / R ----------------------------------------------------------------------------------

// Share of a heap's volume that its grains fill: as much as poured grains do.
constexpr double kFilled = 0.58;
constexpr const char* kRatio = "r / R";
constexpr const char* kHiddenCulled = "hidden that are culled, %";
constexpr const char* kStillCulled = "hidden that are culled once the camera stands, %";

struct StackGrain {
  std::string label;
  GrainMesh mesh;
};
std::vector<StackGrain> stackGrains(bool quick) {
  std::vector<StackGrain> grains;
  for (const float inner : {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f, 1.0f}) {
    const bool always = inner == 0.1f || inner == 0.3f || inner == 0.5f || inner == 0.8f || inner == 1.0f;
    if (always || !quick) grains.push_back({"needle", needle(inner)});
  }
  for (const float inner : {0.3f, 0.5f, 0.8f}) grains.push_back({"disc", disc(inner)});
  for (const float inner : {0.3f, 0.5f, 0.8f}) grains.push_back({"star", star(inner)});
  grains.push_back({"cube", cube()});
  return grains;
}

struct Culled {
  double in_view = 0, shown = 0, drawn = 0;  // mean over frames, grains
  double share = 0, still_share = 0;         // of the hidden: in flight, and once the camera stands
  double ms = 0, all_ms = 0;
  double missing = 0;  // pixels
  uint64_t hash = 0;
};

double msOf(HeapScene& scene) {
  const auto start = std::chrono::steady_clock::now();
  scene.render();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double shareOf(double in_view, double drawn, double shown) { return (in_view - drawn) / (in_view - shown); }

// A slow flight past the heap, in which each frame knows what the last one showed; then the camera stands.
Culled fly(HeapScene& culled, HeapScene& all, double distance) {
  constexpr int kFrames = 7, kFirst = 3;
  Culled sum;
  std::vector<double> ms, all_ms;
  for (int frame = 0; frame < kFrames; ++frame) {
    const double step = 0.01 * distance * frame;
    const dvec3 at(step, 0.5 * static_cast<double>(kHeapHeight), 0.5 * static_cast<double>(kHeapRadius));
    const dvec3 from = at + glm::normalize(dvec3(0, kHeapRadius, kHeapHeight)) * (distance + 0.5 * step);
    culled.lookFrom(from, at);
    const double now = msOf(culled);
    if (frame < kFirst) continue;
    all.lookFrom(from, at);
    all_ms.push_back(msOf(all));
    ms.push_back(now);
    const Shown shown = shownBy(culled), truth = shownBy(all);
    const Drawn drawn = drawnBy(culled);
    sum.in_view += drawnBy(all).count;
    sum.drawn += drawn.count;
    sum.shown += truth.grains;
    sum.missing += missing(truth, shown, drawn);
    sum.hash = shown.hash;
  }
  sum.share = shareOf(sum.in_view, sum.drawn, sum.shown);
  for (int frame = 0; frame < 2; ++frame) culled.render();
  sum.still_share = shareOf(drawnBy(all).count, drawnBy(culled).count, shownBy(all).grains);
  for (double* count : {&sum.in_view, &sum.drawn, &sum.shown}) *count /= kFrames - kFirst;
  sum.ms = spread(ms).median;
  sum.all_ms = spread(all_ms).median;
  return sum;
}

// Worst shares at r / R of 0.8 or more; a grid of triangles makes 0.79 of an ellipsoid of 0.8.
struct Least {
  double moving = 1, still = 1;
};
Least byRatio(Bench& bench, double& missing_pixels) {
  Least least;
  for (const StackGrain& grain : stackGrains(bench.quick())) {
    Result<ImpostorAtlas> atlas = bake(grain.mesh, {.edge = 5, .texels = 32, .directions = 0});
    if (!atlas.ok()) fail(atlas.error());
    const double ratio = std::round(100 * static_cast<double>(atlas->inner)) / 100;
    const double volume = volumeOf(grain.mesh) / std::pow(static_cast<double>(atlas->outer), 3);
    // Balls of volume 1 touch where they fill pi / sqrt(18) of the space, each in sqrt(32) radii^3.
    const double swell = std::cbrt(kFilled * std::sqrt(32.0) / volume);
    const Heap heap = makeHeap(bench.quick() ? 100'000 : 400'000, static_cast<float>(swell));
    const auto addShape = [&](World& world) {
      ImpostorAtlas copy = *atlas;
      copy.errors.directions = 1;  // good at all sizes: drawn as nothing else
      return addGrainShape(world, grain.label, grain.mesh, std::move(copy));
    };
    HeapScene culled(heap, addShape), all(heap, addShape);
    for (HeapScene* scene : {&culled, &all}) {
      scene->size = bench.quick() ? ivec2(640, 360) : ivec2(1280, 720);
      scene->world.singleton<LodSettings>().only = rules::kImpostor;
      // Without hysteresis: what covers a pixel depends on this frame alone.
      scene->world.singleton<LodSettings>().band = 0;
      scene->castShadows(false);
    }
    all.world.singleton<LodSettings>().cull = false;
    for (const double distance : {0.3, 1.2}) {
      const Culled found = fly(culled, all, distance);
      missing_pixels += found.missing;
      if (ratio >= 0.785) least = {std::min(least.moving, found.share), std::min(least.still, found.still_share)};
      bench.row({.scenario = fmt::format("stack {} m {} {}", distance, grain.label, ratio),
                 .label = grain.label,
                 .knobs = {{kRatio, ratio}, {"distance_m", distance}, {"nearest_px", beanPx(heap, distance, culled.size.y)}},
                 .time_ms = found.ms,
                 .error = 1 - found.share,
                 .error_kind = "share of the impostors that no pixel shows that was drawn",
                 .hash = found.hash,
                 .measured = {{kHiddenCulled, 100 * found.share}, {kStillCulled, 100 * found.still_share}, {"in view", found.in_view}, {"drawn", found.drawn}, {"shown", found.shown}, {"all ms", found.all_ms}}});
    }
  }
  return least;
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
    // Without hysteresis: what covers a pixel depends on this frame alone.
    scene->world.singleton<LodSettings>().band = 0;
  }
  all.world.singleton<LodSettings>().cull = false;
  bench.progress("occlusion: {} beans", heap.beans.size());

  double least = 1;
  double missing_pixels = 0;
  for (const double distance : {0.1, 0.25, 0.6, 1.5, 3.0}) {
    culled.look(distance);
    all.look(distance);
    const Paired timed = bench.paired({{"culled", [&] { culled.render(); }}, {"all", [&] { all.render(); }}});
    const Drawn drawn_now = drawnBy(culled);
    const double in_view = drawnBy(all).count, drawn = drawn_now.count;
    const Shown shown = shownBy(culled), truth = shownBy(all);
    const double hidden = in_view - truth.grains, found = in_view - drawn;
    missing_pixels += missing(truth, shown, drawn_now);
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
  const Least dense = byRatio(bench, missing_pixels);
  for (const char* scenarios : {"stack 0.3 m", "stack 1.2 m"})
    bench.curve({.knob = kRatio, .measured = kHiddenCulled, .scenarios = scenarios, .linear = true});
  bench.claimAtLeast("hidden impostors that are culled, worst distance", least, 0.7);
  bench.claimAtLeast("hidden impostors that are culled in stacks with r / R >= 0.8, camera stands, worst", dense.still, 0.9);
  bench.claimAtLeast("hidden impostors that are culled in stacks with r / R >= 0.8, camera moves, worst", dense.moving, 0.9);
  bench.claimAtMost("pixels whose grain is not drawn with culling", missing_pixels, 0);
}

}  // namespace scree::bench
