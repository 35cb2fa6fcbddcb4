// A file's impostor, from the cache or baked; and the shape of grains that it makes.
#include "modules/impostors/impostors.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/core/log.h"
#include "engine/ecs/world.h"
#include "modules/lod/lod.h"
#include "shaders/shared/gbuffer.h"

namespace scree {

namespace {

Result<GrainMesh> grainOf(const std::filesystem::path& mesh) {
  Result<SceneData> scene = loadGltf(mesh);
  if (!scene.ok()) return scene.takeError();
  return grainFromScene(std::move(scene).value());
}

Result<ImpostorAtlas> atlasOf(const GrainMesh& grain, const BakeParameters& parameters,
                              const std::filesystem::path& cache, const BakeProgress& progress) {
  std::error_code ignored;
  bool is_kept = true;
  if (std::filesystem::exists(cache, ignored)) {
    Result<ImpostorAtlas> kept = readAtlas(cache);
    if (kept.ok() && kept->key == bakeKey(grain, parameters)) return kept;
    is_kept = mayReplace(cache);
    if (!kept.ok()) logWarning("{}; baking anew{}", kept.error(), is_kept ? "" : ", and the file is left as it is");
  }
  Result<ImpostorAtlas> atlas = bake(grain, parameters, progress);
  if (atlas.ok() && is_kept)
    if (const Status written = writeAtlas(cache, *atlas); !written.ok()) logWarning("{}", written.error());
  return atlas;
}

// At the sizes that were measured, and where mip levels change.
std::vector<SizeError> sizeErrors(const ImpostorAtlas& atlas) {
  std::vector<float> diameters(std::begin(kImpostorSizesPx), std::end(kImpostorSizesPx));
  for (int level = 1; level < atlas.levels(); ++level) diameters.push_back(impostorLevelMostPx(atlas.texels, level));
  std::ranges::sort(diameters);
  const ImpostorOutlines& outlines = atlas.errors.outlines;
  std::vector<SizeError> sizes;
  for (const float diameter : diameters) {
    size_t level = 0;
    while (static_cast<int>(level) + 1 < atlas.levels() && diameter <= impostorLevelMostPx(atlas.texels, static_cast<int>(level) + 1))
      ++level;
    const float ssim = atlas.errors.at(ImpostorScheme::Proxy, diameter).ssim,
                mesh_ssim = atlas.errors.at(ImpostorScheme::Mesh, diameter).ssim,
                small_ssim = atlas.errors.at(ImpostorScheme::Nearest, diameter).ssim;
    sizes.push_back({0.5f * diameter, outlines.full[level], outlines.small[level], outlines.full_near, outlines.small_near, ssim, mesh_ssim, small_ssim});
  }
  return sizes;
}

}  // namespace

Result<ImpostorAtlas> impostorOf(const std::filesystem::path& mesh, const BakeParameters& parameters,
                                 const std::filesystem::path& cache, const BakeProgress& progress) {
  if (Status fine = checkParameters(parameters); !fine.ok()) return fine.takeError();
  Result<GrainMesh> grain = grainOf(mesh);
  if (!grain.ok()) return grain.takeError();
  Result<ImpostorAtlas> atlas = atlasOf(*grain, parameters, cache, progress);
  if (!atlas.ok()) return Error{fmt::format("{}: {}", mesh.string(), atlas.error()), atlas.errorKind()};
  return atlas;
}

namespace {

// Mean colour of what its views show: folds that few of them look into count as little as they are seen.
vec3 albedoSeen(const ImpostorAtlas& atlas) {
  dvec3 sum(0);
  double covered = 0;
  for (int view = 0; view < atlas.views(); ++view)
    for (uint64_t k = atlas.offset(0, view); k < atlas.offset(0, view) + static_cast<uint64_t>(atlas.texels * atlas.texels); ++k) {
      const vec3 code(atlas.color[4 * k], atlas.color[4 * k + 1], atlas.color[4 * k + 2]);
      sum += dvec3(rules::albedoFromCode(code / 255.0f)) * static_cast<double>(atlas.shape[2 * k]);
      covered += static_cast<double>(atlas.shape[2 * k]);
    }
  return covered > 0 ? vec3(sum / covered) : vec3(1);
}

}  // namespace

Result<uint32_t> addGrainShape(World& world, std::string name, const GrainMesh& grain, ImpostorAtlas atlas) {
  MaterialStore& materials = world.singleton<MaterialStore>();
  GrainShape shape;
  shape.name = std::move(name);
  shape.center = atlas.center;
  shape.outer_radius = atlas.outer;
  shape.inner_radius = atlas.inner * atlas.outer;
  shape.bound = atlas.bound;
  std::vector<uint32_t> handles;
  for (MaterialData data : grain.materials) {
    for (TextureUse* use : {&data.base_color_map, &data.metallic_roughness_map, &data.normal_map, &data.emissive_map})
      if (use->image >= 0) use->image = materials.addImage(grain.images[static_cast<size_t>(use->image)]);
    handles.push_back(materials.add(std::move(data)));
  }
  std::vector<MeshData> parts = grain.parts;
  for (MeshData& part : parts)
    if (part.material >= 0) part.material = static_cast<int>(handles[static_cast<size_t>(part.material)]);
  if (Status added = addLevels(world.singleton<MeshStore>(), shape, parts); !added.ok()) return added.takeError();
  setMeanLook(materials, shape, parts);
  shape.albedo = albedoSeen(atlas);
  if (atlas.errors.directions > 0) {
    shape.impostor = sizeErrors(atlas);
    shape.point_outline = atlas.errors.outlines.point;
  }
  const uint32_t handle = world.singleton<SwarmStore>().addShape(std::move(shape));
  world.singleton<ImpostorStore>().set(handle, std::move(atlas));
  return handle;
}

Result<uint32_t> loadGrainShape(World& world, const std::filesystem::path& mesh, const BakeParameters& parameters,
                                const std::filesystem::path& cache, const BakeProgress& progress) {
  if (Status fine = checkParameters(parameters); !fine.ok()) return fine.takeError();
  Result<GrainMesh> grain = grainOf(mesh);
  if (!grain.ok()) return grain.takeError();
  Result<ImpostorAtlas> atlas = atlasOf(*grain, parameters, cache, progress);
  if (!atlas.ok()) return Error{fmt::format("{}: {}", mesh.string(), atlas.error()), atlas.errorKind()};
  return addGrainShape(world, mesh.stem().string(), *grain, std::move(atlas).value());
}

}  // namespace scree
