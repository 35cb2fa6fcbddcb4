// Impostors of grains: what a mesh looks like from many sides, baked into an atlas, so that a grain
// costs a few texel fetches, however many triangles it has.
//
// Michel and Boubekeur, "Real Time Multiscale Rendering of Dense Dynamic Stackings", 2020, sections
// 4 to 6. In: a closed triangle mesh with glTF materials. Out: an ImpostorAtlas (atlas.h), with the
// error that drawing it makes, measured. Cost: baking takes seconds (README.md); the atlas
// 10 bytes a texel; a pixel three views of one fetch each (shared/impostor.h).
#pragma once

#include <filesystem>

#include "modules/impostors/atlas.h"
#include "modules/impostors/bake.h"
#include "modules/impostors/cache.h"
#include "modules/impostors/choose.h"
#include "modules/impostors/grain_mesh.h"

namespace scree {

// The atlas of a glTF file: from `cache` if that holds what these parameters would make of the file as it
// is now, else baked and written there. A cache that cannot be read or written costs one warning.
Result<ImpostorAtlas> impostorOf(const std::filesystem::path& mesh, const BakeParameters& parameters,
                                 const std::filesystem::path& cache, const BakeProgress& progress = {});

}  // namespace scree
