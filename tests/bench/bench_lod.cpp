// The dolly shot: a heap of coffee beans from near to far, drawn by the router's choice, as each representation
// alone, and as the sprites of 2020; time against error, by distance.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "engine/assets/image_flip.h"
#include "engine/core/hash.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "tests/bench/bean_heap.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"
#include "tests/bench/raster_impostors.h"

namespace scree::bench {
namespace {

// What --quick changes.
struct Plan {
  size_t beans;
  ivec2 size;
  std::vector<double> distances_m;  // of the heap's nearest point
  int frames;                       // timed, of each way at each distance, as long as they take
  double budget_ms;                 // no longer than this, after the first
  double too_slow_ms;               // beyond it meshes are left out at this distance and all that follow
};
Plan planOf(bool quick) {
  if (quick) return {100'000, {640, 360}, {0.1, 0.4, 1.5, 6, 18, 50}, 7, 1500, 2500};
  return {1'600'000, {1280, 720}, {0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12, 24, 48}, 9, 6000, 12'000};
}

enum Way : size_t { kHybrid, kMeshes, kImpostors, kPoints, kUnculled, kSprites, kWays };
constexpr const char* kLabels[kWays] = {"hybrid", "mesh", "impostor", "point", "impostor, not culled", "sprites of 2020"};

struct Scenes {
  Heap heap;
  std::vector<std::unique_ptr<HeapScene>> scenes;
};

Scenes makeScenes(const Plan& plan, const std::filesystem::path& folder) {
  Scenes all{makeHeap(plan.beans), {}};
  for (size_t way = 0; way < kWays; ++way) {
    const auto kind = way == kSprites ? HeapScene::Kind::Bare : HeapScene::Kind::Swarm;
    all.scenes.push_back(std::make_unique<HeapScene>(all.heap, folder / "bean.impostor", kind));
    HeapScene& scene = *all.scenes.back();
    scene.size = plan.size;
    LodSettings& settings = scene.world.singleton<LodSettings>();
    if (way == kMeshes) settings.only = rules::kMesh;
    if (way == kImpostors || way == kUnculled) settings.only = rules::kImpostor;
    if (way == kPoints) settings.only = rules::kPoint;
    settings.cull = way != kUnculled;
  }
  std::filesystem::create_directory(folder / "shaders");
  addRasterImpostors(*all.scenes[kSprites], all.heap, folder / "shaders");
  return all;
}

// ---- Time --------------------------------------------------------------------------------------

double frameMs(HeapScene& scene) {
  const auto start = std::chrono::steady_clock::now();
  scene.render();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Medians of frames that follow one another in each way, and take turns between the ways; nothing where it was
// too slow.
using Times = std::array<std::optional<double>, kWays>;
Times timesAt(Scenes& all, const Plan& plan, double distance_m, bool& meshes_given_up) {
  std::array<std::vector<double>, kWays> samples;
  std::array<bool, kWays> measured{};
  for (size_t way = 0; way < kWays; ++way) {
    if (way == kMeshes && meshes_given_up) continue;
    HeapScene& scene = *all.scenes[way];
    scene.look(distance_m);
    const double first = frameMs(scene);
    if (way == kMeshes && first > plan.too_slow_ms) meshes_given_up = true;
    measured[way] = way != kMeshes || !meshes_given_up;
    // The second frame knows what the first showed; of sprites no frame knows another.
    if (measured[way] && way != kSprites) scene.render();
  }
  std::array<double, kWays> spent{};
  for (int frame = 0; frame < plan.frames; ++frame)
    for (size_t way = 0; way < kWays; ++way) {
      if (!measured[way] || spent[way] > plan.budget_ms) continue;
      samples[way].push_back(frameMs(*all.scenes[way]));
      spent[way] += samples[way].back();
    }
  Times times;
  for (size_t way = 0; way < kWays; ++way)
    if (measured[way]) times[way] = spread(samples[way]).median;
  return times;
}

// ---- Error -------------------------------------------------------------------------------------

// A part of the picture, at its own scale, without shadows, which the sprites do not cast.
constexpr ivec2 kPart{320, 180};
constexpr int kTruthSide = 4;  // samples along a pixel's side

struct Picture {
  std::vector<float> radiance;  // 4 a pixel, rows from the bottom
  std::vector<bool> heap;       // where it shows
};

Picture pictureOf(HeapScene& scene) {
  scene.app.frame().keep(kRadiance, true);
  scene.render();
  Picture picture{gpu::readFloats(scene.app.frame().texture(kRadiance), 4), {}};
  for (const float depth : gpu::readFloats(scene.app.frame().texture(kGbufferDepth), 1)) picture.heap.push_back(depth > 0);
  return picture;
}

// Mean of squares of side x side pixels.
Picture halvedTo(const Picture& fine, ivec2 size, int side) {
  const auto pixels = static_cast<size_t>(size.x) * static_cast<size_t>(size.y);
  Picture picture{std::vector<float>(4 * pixels), std::vector<bool>(pixels)};
  const float share = 1 / static_cast<float>(side * side);
  for (int y = 0; y < size.y * side; ++y)
    for (int x = 0; x < size.x * side; ++x) {
      const auto from = static_cast<size_t>(y) * static_cast<size_t>(size.x * side) + static_cast<size_t>(x);
      const auto to = static_cast<size_t>(y / side) * static_cast<size_t>(size.x) + static_cast<size_t>(x / side);
      for (size_t c = 0; c < 4; ++c) picture.radiance[4 * to + c] += share * fine.radiance[4 * from + c];
      if (fine.heap[from]) picture.heap[to] = true;
    }
  return picture;
}

// The meshes with 16 samples a pixel, as one larger picture: each bean's triangles are set up once. The finest
// level, or a coarser one where that is off by less than 1/20 of a pixel.
Picture truthOf(HeapScene& scene, double bean_px) {
  const GrainShape& bean = scene.bean();
  uint32_t level = 0;
  while (level + 1 < bean.levels.size() && static_cast<double>(bean.levels[level + 1].error) * bean_px < 0.05) ++level;
  LodSettings& settings = scene.world.singleton<LodSettings>();
  settings.only = rules::kMesh + level;
  scene.size = kPart * kTruthSide;
  const Picture fine = pictureOf(scene);
  scene.size = kPart;
  settings.only = rules::kMesh;
  return halvedTo(fine, kPart, kTruthSide);
}

struct Error {
  double flip = 0;       // mean where the heap shows in the truth
  double luminance = 1;  // mean there / that of the truth
  uint64_t hash = 0;
};

Error errorOf(const Picture& picture, const Picture& truth) {
  const auto imageOf = [](const Picture& p) {
    return images::imageFromLinear(kPart.x, kPart.y, 4, p.radiance, RowOrder::BottomUp);
  };
  const images::Flip flip = images::flip(imageOf(picture), imageOf(truth));
  double sum = 0, seen = 0, light = 0, true_light = 0;
  for (int y = 0; y < kPart.y; ++y)
    for (int x = 0; x < kPart.x; ++x) {
      const auto at = static_cast<size_t>(y * kPart.x + x), from_top = static_cast<size_t>((kPart.y - 1 - y) * kPart.x + x);
      if (!truth.heap[at]) continue;
      const auto luminance = [at](const Picture& p) {
        return 0.2126 * static_cast<double>(p.radiance[4 * at]) + 0.7152 * static_cast<double>(p.radiance[4 * at + 1]) +
               0.0722 * static_cast<double>(p.radiance[4 * at + 2]);
      };
      sum += flip.map[from_top];
      light += luminance(picture);
      true_light += luminance(truth);
      ++seen;
    }
  return {sum / seen, light / true_light, hashBytes(picture.radiance.data(), picture.radiance.size() * sizeof(float))};
}

// Of all ways that were timed at this distance.
std::array<Error, kWays> errorsAt(Scenes& all, const Plan& plan, double distance_m, const Times& times) {
  // As many pixels a radian in fewer rows.
  const double tan_half = std::tan(0.5 * static_cast<double>(kHeapFovY)) * kPart.y / plan.size.y;
  for (const auto& scene : all.scenes) {
    scene->size = kPart;
    scene->look(distance_m, static_cast<float>(2 * std::atan(tan_half)));
  }
  const Picture truth = truthOf(*all.scenes[kMeshes], beanPx(all.heap, distance_m, plan.size.y));
  std::array<Error, kWays> errors;
  for (size_t way = 0; way < kWays; ++way)
    if (times[way]) errors[way] = errorOf(pictureOf(*all.scenes[way]), truth);
  return errors;
}

// ---- Claims ------------------------------------------------------------------------------------

// Whether this representation alone is good enough for all beans of the heap.
bool suffices(size_t way, const LodThresholds& thresholds, double nearest_px, double farthest_px) {
  if (way == kMeshes) return true;
  if (way == kPoints) return nearest_px < static_cast<double>(thresholds.point_px);
  return way == kImpostors && nearest_px < static_cast<double>(thresholds.impostor_px) &&
         farthest_px >= static_cast<double>(thresholds.impostor_from_px);
}

struct Shot {
  double hybrid_ms = 0, sprites_ms = 0;  // of all distances
  double dearest_ms = 0, cheapest_ms = std::numeric_limits<double>::infinity();
  double worst_to_single = 0;  // hybrid / cheapest single representation that suffices
};

void addTo(Shot& shot, const Times& times, const Scenes& all, const Plan& plan, double distance_m) {
  const double hybrid = *times[kHybrid];
  shot.hybrid_ms += hybrid;
  shot.sprites_ms += *times[kSprites];
  shot.dearest_ms = std::max(shot.dearest_ms, hybrid);
  shot.cheapest_ms = std::min(shot.cheapest_ms, hybrid);
  const LodThresholds thresholds = thresholdsOf(
      all.scenes[kHybrid]->bean(), LodSettings{}, static_cast<float>(beanPx(all.heap, 1, plan.size.y)) / all.heap.bean_radius);
  const double nearest = beanPx(all.heap, distance_m, plan.size.y),
               farthest = beanPx(all.heap, distance_m + static_cast<double>(kHeapSize), plan.size.y);
  double single = std::numeric_limits<double>::infinity();
  for (const size_t way : {kMeshes, kImpostors, kPoints})
    if (times[way] && suffices(way, thresholds, nearest, farthest)) single = std::min(single, *times[way]);
  shot.worst_to_single = std::max(shot.worst_to_single, hybrid / single);
}

}  // namespace

SCREE_BENCH(lod, "a heap of beans from near to far: the router beside each representation alone, and sprites") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  bench.sweeps("distance_m");
  const Plan plan = planOf(bench.quick());
  const WorkFolder folder;
  bench.progress("lod: baking the bean's impostor");
  Scenes all = makeScenes(plan, folder.path());
  bench.progress("lod: {} beans, {} x {}", all.heap.beans.size(), plan.size.x, plan.size.y);

  Shot shot;
  std::vector<Times> times;
  bool meshes_given_up = false;
  for (const double distance : plan.distances_m) {
    times.push_back(timesAt(all, plan, distance, meshes_given_up));
    std::string line = fmt::format("lod: {} m, beans of {:.2f} px:", distance, beanPx(all.heap, distance, plan.size.y));
    for (size_t way = 0; way < kWays; ++way)
      line += times.back()[way] ? fmt::format(" {} {:.1f} ms;", kLabels[way], *times.back()[way])
                                : fmt::format(" {} left out: over {:.1f} s;", kLabels[way], plan.too_slow_ms / 1000);
    bench.progress("{}", line);
    addTo(shot, times.back(), all, plan, distance);
  }
  for (const auto& scene : all.scenes)
    if (scene != all.scenes[kSprites]) scene->castShadows(false);
  for (size_t k = 0; k < times.size(); ++k) {
    const double distance = plan.distances_m[k], px = beanPx(all.heap, distance, plan.size.y);
    const std::array<Error, kWays> errors = errorsAt(all, plan, distance, times[k]);
    for (size_t way = 0; way < kWays; ++way) {
      if (!times[k][way]) continue;
      bench.row({.scenario = fmt::format("{} m", distance),
                 .label = kLabels[way],
                 .knobs = {{"beans", all.heap.beans.size()}, {"distance_m", distance}, {"nearest_px", px}},
                 .time_ms = *times[k][way],
                 .error = errors[way].flip,
                 .error_kind = "mean FLIP to 16 samples a pixel of the meshes, where the heap shows",
                 .hash = errors[way].hash,
                 .baseline = way == kSprites,
                 .measured = {{"luminance / truth", errors[way].luminance}}});
    }
  }
  bench.claimAtLeast("shot: sprites of 2020 / hybrid", shot.sprites_ms / shot.hybrid_ms, 8);
  bench.claimAtMost("hybrid / cheapest single representation that suffices, worst distance", shot.worst_to_single, 1.05);
  bench.claimAtMost("hybrid: dearest / cheapest frame", shot.dearest_ms / shot.cheapest_ms, 3);
}

}  // namespace scree::bench
