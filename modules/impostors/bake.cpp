// One view after another, cast, summed, filtered and stored.
#include "modules/impostors/bake.h"

#include <fmt/format.h>

#include <cstring>
#include <mutex>

#include "engine/core/hash.h"
#include "engine/core/parallel.h"
#include "modules/impostors/bounding_ellipsoid.h"
#include "modules/impostors/cast.h"
#include "modules/impostors/measure.h"
#include "modules/impostors/outline.h"
#include "modules/impostors/texels.h"

namespace scree {
namespace {

using namespace impostors;

// Of the bake's rules: raised with every change that makes other bytes of the same mesh.
constexpr uint64_t kBakeVersion = 6;
constexpr double kViewsShare = 0.4, kMeasureShare = 0.3;  // of the progress; bounding outlines takes the rest

Shot shotOf(const vec3& axis, int texels, int supersample) {
  const rules::ImpostorBasis basis = rules::impostorBasis(axis);
  return {dvec3(axis), dvec3(basis.right), dvec3(basis.up),
          static_cast<double>(rules::impostorExtent(texels)), texels * supersample};
}

std::vector<TexelSum> summed(const UnitGrain& grain, const std::vector<Seen>& seen, int texels,
                             int supersample) {
  std::vector<TexelSum> sums(static_cast<size_t>(texels) * static_cast<size_t>(texels));
  const int samples = texels * supersample;
  const float weight = 1.0f / static_cast<float>(supersample * supersample);
  for (int y = 0; y < samples; ++y) {
    for (int x = 0; x < samples; ++x) {
      const Seen& s =
          seen[static_cast<size_t>(y) * static_cast<size_t>(samples) + static_cast<size_t>(x)];
      if (s.triangle < 0) continue;
      const Surface surface =
          surfaceAt(grain, grain.triangles[static_cast<size_t>(s.triangle)], s.b, s.c, s.flipped);
      TexelSum& sum = sums[static_cast<size_t>(y / supersample * texels + x / supersample)];
      const float alpha = surface.roughness * surface.roughness;
      sum.coverage += weight;
      sum.albedo += surface.albedo * weight;
      sum.metallic += surface.metallic * weight;
      sum.normal += surface.normal * weight;
      sum.alpha2 += alpha * alpha * weight;
      sum.height += s.height * weight;
    }
  }
  return sums;
}

void store(ImpostorAtlas& atlas, int level, int layer, const std::vector<TexelSum>& sums,
           const std::vector<Texel>& texels) {
  const uint64_t first = atlas.offset(level, layer);
  for (size_t i = 0; i < texels.size(); ++i) {
    const StoredTexel out = stored(sums[i].coverage, texels[i]);
    std::memcpy(&atlas.shape[(first + i) * 2], out.shape, 2);
    std::memcpy(&atlas.color[(first + i) * 4], out.color, 4);
    std::memcpy(&atlas.normal[(first + i) * 4], out.normal, 4);
  }
}

void bakeView(const UnitGrain& grain, const BakeParameters& parameters, int layer,
              ImpostorAtlas& atlas) {
  const vec3 axis = rules::impostorViewDirection(static_cast<uint32_t>(layer), parameters.edge);
  std::vector<Seen> seen;
  cast(grain, shotOf(axis, parameters.texels, parameters.supersample), seen);
  const int levels = atlas.levels();
  std::vector<std::vector<TexelSum>> sums(static_cast<size_t>(levels));
  sums[0] = summed(grain, seen, parameters.texels, parameters.supersample);
  for (int level = 1; level < levels; ++level)
    sums[static_cast<size_t>(level)] =
        halved(sums[static_cast<size_t>(level) - 1], atlas.side(level - 1));
  std::vector<Texel> coarser;
  for (int level = levels - 1; level >= 0; --level) {
    const std::vector<TexelSum>& from = sums[static_cast<size_t>(level)];
    std::vector<Texel> texels;
    texels.reserve(from.size());
    for (const TexelSum& sum : from) texels.push_back(meanOf(sum, axis));
    spreadOut(texels, atlas.side(level), coarser, {.normal = axis});
    store(atlas, level, layer, from, texels);
    coarser = std::move(texels);
  }
}

// Of an atlas that shows nothing: by an alpha that hides all, or by triangles thinner than its samples.
Error unseen(const GrainMesh& grain, const ImpostorAtlas& atlas) {
  for (size_t p = 0; p < grain.parts.size(); ++p) {
    const int m = grain.parts[p].material;
    if (m < 0 || grain.materials[static_cast<size_t>(m)].alpha_mode == AlphaMode::Opaque) continue;
    const MaterialData& material = grain.materials[static_cast<size_t>(m)];
    return Error{fmt::format("grain: part {} \"{}\": material {} \"{}\": its alpha is below {:g} wherever it is seen, so that the grain shows "
                             "in none of its {} views; allowed is a grain of which something is opaque",
                             p, grain.parts[p].name, m, material.name,
                             material.alpha_mode == AlphaMode::Mask ? material.alpha_cutoff : 0.5f, atlas.views())};
  }
  return Error{fmt::format("grain: shows in none of its {} views of {} x {} texels: its triangles are too thin; more texels may show them",
                           atlas.views(), atlas.texels, atlas.texels)};
}

bool showsNothing(const ImpostorAtlas& atlas) {
  for (size_t k = 0; k < atlas.shape.size(); k += 2)
    if (atlas.shape[k] > 0) return false;
  return true;
}

}  // namespace

Status checkParameters(const BakeParameters& p) {
  const auto outside = [](const char* name, int value, const std::string& allowed) {
    return Error{fmt::format("impostor: {} is {}, allowed are {}", name, value, allowed)};
  };
  if (p.edge < rules::kImpostorMinEdge || p.edge > kImpostorMaxBakedEdge)
    return outside("views (n)", p.edge,
                   fmt::format("{} to {}", rules::kImpostorMinEdge, kImpostorMaxBakedEdge));
  if (p.texels < kImpostorMinTexels || p.texels > kImpostorMaxTexels ||
      (p.texels & (p.texels - 1)) != 0)
    return outside("texels (p)", p.texels, "16, 32, 64, 128, 256");
  if (p.supersample < 1 || p.supersample > 8)
    return outside("supersample", p.supersample, "1 to 8");
  if (p.directions < 0 || p.directions > 1024)
    return outside("directions", p.directions, "0 to 1024");
  if (const uint64_t bytes = impostorBytes(p.edge, p.texels); bytes > kImpostorMaxBytes)
    return Error{fmt::format("impostor: {} views of {} x {} texels take {} MiB on the GPU, allowed are {}",
                             rules::impostorViewCount(p.edge), p.texels, p.texels, bytes >> 20,
                             kImpostorMaxBytes >> 20)};
  return Done{};
}

uint64_t bakeKey(const GrainMesh& grain, const BakeParameters& p) {
  uint64_t key = hashCombine(contentHash(grain), kBakeVersion);
  for (int value : {p.edge, p.texels, p.supersample, p.directions})
    key = hashCombine(key, static_cast<uint64_t>(value));
  return key;
}

Result<ImpostorAtlas> bake(const GrainMesh& mesh, const BakeParameters& parameters,
                           const BakeProgress& progress) {
  if (Status fine = checkParameters(parameters); !fine.ok()) return fine.takeError();
  if (Status fine = checkGrain(mesh); !fine.ok()) return fine.takeError();
  Result<UnitGrain> unit = unitGrain(mesh);
  if (!unit.ok()) return unit.takeError();
  ImpostorAtlas atlas{.edge = parameters.edge,
                      .texels = parameters.texels,
                      .key = bakeKey(mesh, parameters),
                      .center = vec3(unit->center),
                      // Rounding keeps the mesh inside the one and outside the other.
                      .outer = static_cast<float>(unit->outer * (1 + 1e-6)),
                      .inner = static_cast<float>(unit->inner * (1 - 4e-6)),
                      .proxy = proxyOf(unit->corners, 0.5 * (1 + unit->inner)),
                      .bound = boundingEllipsoid(unit->corners)};
  const uint64_t texels = atlas.texelCount();
  atlas.shape.resize(texels * 2);
  atlas.color.resize(texels * 4);
  atlas.normal.resize(texels * 4);
  std::mutex reporting;
  size_t done = 0;
  const auto views = static_cast<size_t>(atlas.views());
  parallelChunks(views, 1, [&](size_t view, size_t, size_t) {
    bakeView(*unit, parameters, static_cast<int>(view), atlas);
    const std::lock_guard lock(reporting);
    ++done;
    if (progress)
      progress(static_cast<double>(done) / static_cast<double>(views) *
               (parameters.directions > 0 ? kViewsShare : 1));
  });
  if (showsNothing(atlas)) return unseen(mesh, atlas);
  if (parameters.directions > 0) {
    atlas.errors = measure(*unit, atlas, parameters.directions, [&](double share) {
      if (progress) progress(kViewsShare + share * kMeasureShare);
    });
    atlas.errors.outlines = outlineBounds(*unit, atlas, [&](double share) {
      if (progress) progress(kViewsShare + kMeasureShare + share * (1 - kViewsShare - kMeasureShare));
    });
  }
  return atlas;
}

}  // namespace scree
