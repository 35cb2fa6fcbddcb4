// Impostors against their meshes, one grain at a time: by how a ray's point is found, at equal memory, over the size on
// the screen; and by the number of views and their texels, over memory. The programs' rules run on the CPU, so times are
// those of the CPU copy.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "modules/impostors/impostors.h"
#include "modules/impostors/measure.h"
#include "modules/impostors/unit_grain.h"
#include "tests/bench/bench.h"

namespace scree::bench {
namespace {

constexpr BakeParameters kAtlas{.edge = 6, .texels = 64, .directions = 0};
constexpr float kFromPx = 24;  // claims are of this diameter and more: below it a pixel hides what schemes differ in
constexpr float kMemoryPx = 48;

GrainMesh load(const char* name) {
  Result<SceneData> scene = loadGltf(contentRoot() / "models" / name);
  if (!scene.ok()) fail(scene.error());
  Result<GrainMesh> grain = grainFromScene(std::move(scene).value());
  if (!grain.ok()) fail(grain.error());
  return std::move(grain).value();
}

ImpostorAtlas baked(const GrainMesh& grain, BakeParameters parameters) {
  Result<ImpostorAtlas> atlas = bake(grain, parameters);
  if (!atlas.ok()) fail(atlas.error());
  return std::move(atlas).value();
}

images::Image drawn(const impostors::UnitGrain& grain, const ImpostorAtlas& atlas, ImpostorScheme scheme, float diameter_px) {
  const impostors::Scene scene = impostors::randomScene(0, diameter_px);
  return scheme == ImpostorScheme::Mesh ? impostors::drawMesh(grain, scene, 1) : impostors::drawImpostor(atlas, scheme, scene);
}

// ---- By scheme ---------------------------------------------------------------------------------

// Means from kFromPx on.
struct Means {
  double dissimilarity = 0, silhouette_px = 0;  // 1 - SSIM
};
using SchemeMeans = std::array<Means, kImpostorSchemes>;

SchemeMeans bySize(Bench& bench, const std::string& model, const impostors::UnitGrain& grain, const ImpostorAtlas& atlas) {
  const int directions = bench.quick() ? 6 : 24;
  const ImpostorErrors errors = impostors::measure(grain, atlas, directions, [](double) {});
  SchemeMeans means{};
  int counted = 0;
  for (size_t size = 0; size < kImpostorSizes; ++size) {
    const float diameter = kImpostorSizesPx[size];
    if (bench.quick() && size % 2 == 1) continue;
    std::vector<Variant> variants;
    for (size_t scheme = 0; scheme < kImpostorSchemes; ++scheme)
      variants.push_back({kImpostorSchemeNames[scheme], [&, scheme] {
                            drawn(grain, atlas, static_cast<ImpostorScheme>(scheme), diameter);
                          }});
    const Paired timed = bench.paired(variants);
    counted += diameter >= kFromPx;
    for (size_t scheme = 0; scheme < kImpostorSchemes; ++scheme) {
      const ImpostorError& error = errors.of[scheme][size];
      const images::Image image = drawn(grain, atlas, static_cast<ImpostorScheme>(scheme), diameter);
      Row row{.scenario = fmt::format("{} of {} px", model, diameter),
              .label = kImpostorSchemeNames[scheme],
              .knobs = {{"diameter, px", diameter}, {"n", atlas.edge}, {"p", atlas.texels}, {"directions", directions}},
              .time_ms = timed.variants[scheme].median_ms,
              .error = std::max(0.0, 1.0 - static_cast<double>(error.ssim)),
              .error_kind = "1 - SSIM to the mesh with 64 samples a pixel",
              .hash = hashBytes(image.rgb.data(), image.rgb.size() * sizeof(float)),
              .baseline = static_cast<ImpostorScheme>(scheme) == ImpostorScheme::Mesh,
              .measured = {{"SSIM", error.ssim}, {"FLIP", error.flip}}};
      if (!row.baseline) row.measured["silhouette, px"] = error.silhouette_px;
      bench.row(std::move(row));
      if (diameter < kFromPx) continue;
      means[scheme].dissimilarity += 1.0 - static_cast<double>(error.ssim);
      means[scheme].silhouette_px += static_cast<double>(error.silhouette_px);
    }
  }
  for (Means& mean : means) {
    mean.dissimilarity /= counted;
    mean.silhouette_px /= counted;
  }
  return means;
}

// ---- By memory ---------------------------------------------------------------------------------

// FLIP with the fewest views / with the most, at the most texels.
double byMemory(Bench& bench, const std::string& model, const GrainMesh& mesh, const impostors::UnitGrain& grain) {
  const std::vector<int> edges = bench.quick() ? std::vector<int>{3, 5, 8} : std::vector<int>{3, 4, 5, 6, 7, 8, 10, 12};
  const std::vector<int> texels = bench.quick() ? std::vector<int>{16, 64} : std::vector<int>{16, 32, 64, 128};
  const int directions = bench.quick() ? 6 : 24;
  double fewest = 0, most = 0;
  for (const int edge : edges)
    for (const int side : texels) {
      const ImpostorAtlas atlas = baked(mesh, {.edge = edge, .texels = side, .directions = 0});
      const float flip = impostors::flipAt(grain, atlas, ImpostorScheme::Proxy, kMemoryPx, directions);
      if (side == texels.back() && edge == edges.front()) fewest = static_cast<double>(flip);
      if (side == texels.back() && edge == edges.back()) most = static_cast<double>(flip);
      const Paired timed = bench.paired({{"proxy", [&] { drawn(grain, atlas, ImpostorScheme::Proxy, kMemoryPx); }}});
      bench.row({.scenario = fmt::format("{} with n {}", model, edge),
                 .label = fmt::format("p {}", side),
                 .knobs = {{"MiB", static_cast<double>(impostorBytes(edge, side)) / (1 << 20)}, {"n", edge}, {"p", side}, {"views", atlas.views()}},
                 .time_ms = timed.variants[0].median_ms,
                 .error = static_cast<double>(flip),
                 .error_kind = fmt::format("FLIP to the mesh with 64 samples a pixel, {} px", kMemoryPx),
                 .hash = hashBytes(atlas.color.data(), atlas.color.size())});
    }
  return fewest / most;
}

}  // namespace

SCREE_BENCH(impostors, "one impostor beside its mesh: how a ray's point is found, by size; views and texels, by memory") {
  const ImpostorScheme proxy = ImpostorScheme::Proxy, mixed = ImpostorScheme::Mixed;
  double least_similar = std::numeric_limits<double>::infinity(), most_outline = 0, least_views = least_similar;
  for (const char* file : {"coffee_bean.glb", "pebble.glb", "bolt.glb"}) {
    const std::string model = std::filesystem::path(file).stem().string();
    bench.progress("impostors: {}", model);
    const GrainMesh mesh = load(file);
    Result<impostors::UnitGrain> grain = impostors::unitGrain(mesh);
    if (!grain.ok()) fail(grain.error());
    const ImpostorAtlas atlas = baked(mesh, kAtlas);
    const SchemeMeans means = bySize(bench, model, *grain, atlas);
    const auto of = [&](ImpostorScheme scheme) { return means[static_cast<size_t>(scheme)]; };
    least_similar = std::min(least_similar, of(mixed).dissimilarity / of(proxy).dissimilarity);
    most_outline = std::max(most_outline, of(proxy).silhouette_px / of(mixed).silhouette_px);
    least_views = std::min(least_views, byMemory(bench, model, mesh, *grain));
    for (const char* measured : {"SSIM", "FLIP", "silhouette, px"})
      bench.curve({.knob = "diameter, px", .measured = measured, .scenarios = model + " of"});
    bench.curve({.knob = "MiB", .measured = "error", .scenarios = model + " with"});
  }
  bench.claimAtLeast("1 - SSIM: the paper's mixed sampling / proxy, from 24 px on, worst grain", least_similar, 1.15);
  bench.claimAtMost("outlines off: proxy / the paper's mixed sampling, from 24 px on, worst grain", most_outline, 1);
  bench.claimAtLeast("FLIP at 48 px: fewest views / most views, worst grain", least_views, 1.3);
}

}  // namespace scree::bench
