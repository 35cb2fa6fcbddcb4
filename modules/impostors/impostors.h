// Impostors of grains: what a mesh looks like from many sides, baked into an atlas, so that a grain
// costs a few texel fetches, however many triangles it has.
//
// Michel and Boubekeur, "Real Time Multiscale Rendering of Dense Dynamic Stackings", 2020, sections
// 4 to 6. In: a closed triangle mesh with glTF materials. Out: an ImpostorAtlas (atlas.h), with the
// error that drawing it makes, measured. Cost: baking takes seconds (README.md); the atlas 24 bytes
// a texel of its finest level on the GPU, and 13.3 in memory; a pixel one fetch a view while it is decided who shows it, then
// six for each of three views (shaders/impostors/surface.glsl).
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "modules/impostors/atlas.h"
#include "modules/impostors/bake.h"
#include "modules/impostors/cache.h"
#include "modules/impostors/choose.h"
#include "modules/impostors/grain_mesh.h"

namespace scree {

class App;
class World;

// ---- Atlases ------------------------------------------------------------------------------------

// The atlas of a glTF file: from `cache` if that holds what these parameters would make of the file as it
// is now, else baked and written there. A cache that cannot be read or written costs one warning;
// a file that is no atlas is not replaced.
Result<ImpostorAtlas> impostorOf(const std::filesystem::path& mesh, const BakeParameters& parameters,
                                 const std::filesystem::path& cache, const BakeProgress& progress = {});

// ---- Drawing ------------------------------------------------------------------------------------

// Atlases by the shapes (handles of modules/lod's SwarmStore) that they are of. World singleton.
class ImpostorStore {
 public:
  ImpostorStore();
  ~ImpostorStore();
  ImpostorStore(ImpostorStore&&) noexcept;
  ImpostorStore& operator=(ImpostorStore&&) noexcept;

  void set(uint32_t shape, ImpostorAtlas atlas);
  // Null: the shape has none.
  const ImpostorAtlas* find(uint32_t shape) const;
  // Binds the shape's constants and images for shaders/impostors; uploads them at the first call.
  void bind(uint32_t shape);
  // Also the textures that they were packed from, for programs that are compared with those.
  void bindTextures(uint32_t shape);

 private:
  struct Entry;
  std::map<uint32_t, std::unique_ptr<Entry>> entries_;
};

// Makes a shape for swarms of a grain's mesh and its atlas: levels of the mesh, radii, the errors by which the
// router decides. Refuses what addLevels() does.
Result<uint32_t> addGrainShape(World& world, std::string name, const GrainMesh& grain, ImpostorAtlas atlas);
// The same from a glTF file; the atlas is kept in `cache` (see impostorOf).
Result<uint32_t> loadGrainShape(World& world, const std::filesystem::path& mesh, const BakeParameters& parameters,
                                const std::filesystem::path& cache, const BakeProgress& progress = {});

// Registers impostors.give_back (Prepare), impostors.visible (Geometry), impostors.visible_late and impostors.resolve
// (GeometryLate). Needs addLod.
void addImpostors(App& app);

}  // namespace scree
