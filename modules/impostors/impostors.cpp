// A file's impostor: from the cache, or baked.
#include "modules/impostors/impostors.h"

#include "engine/core/log.h"

namespace scree {

Result<ImpostorAtlas> impostorOf(const std::filesystem::path& mesh, const BakeParameters& parameters,
                                 const std::filesystem::path& cache, const BakeProgress& progress) {
  if (Status fine = checkParameters(parameters); !fine.ok()) return fine.takeError();
  Result<SceneData> scene = loadGltf(mesh);
  if (!scene.ok()) return scene.takeError();
  Result<GrainMesh> grain = grainFromScene(std::move(scene).value());
  if (!grain.ok()) return grain.takeError();
  std::error_code ignored;
  if (std::filesystem::exists(cache, ignored)) {
    Result<ImpostorAtlas> kept = readAtlas(cache);
    if (kept.ok() && kept->key == bakeKey(*grain, parameters)) return kept;
    if (!kept.ok()) logWarning("{}; baking anew", kept.error());
  }
  Result<ImpostorAtlas> atlas = bake(*grain, parameters, progress);
  if (atlas.ok())
    if (const Status written = writeAtlas(cache, *atlas); !written.ok()) logWarning("{}", written.error());
  return atlas;
}

}  // namespace scree
