// The baseline of the bench lod: impostors as published in 2020, in one draw, without lists, culling or a
// visibility pass.
//
// Michel and Boubekeur 2020, section 4: a GL_POINTS sprite a grain; the fragment shader samples all attributes
// of the views around the grain's direction and writes the G-buffer at raster time, or discards. Depth is that
// of the grain's centre. Differs from them in what is not compared: three views of the lattice of
// shared/impostor.h, looked up at the ellipsoid. With two of their limits: a sprite is at most as large as the
// driver allows (255 px), and one whose centre is off the screen is not drawn. Casts no shadows.
#pragma once

#include <filesystem>

#include "tests/bench/bean_heap.h"

namespace scree::bench {

// Draws the heap in a bare scene. `folder`: an empty one, for the shaders and what they include.
void addRasterImpostors(HeapScene& scene, const Heap& heap, const std::filesystem::path& folder);

}  // namespace scree::bench
