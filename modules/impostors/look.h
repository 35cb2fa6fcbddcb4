// An impostor drawn on the CPU by the shared rules, and the mesh beside it: what is measured.
#pragma once

#include <vector>

#include "engine/assets/image_pixels.h"
#include "modules/impostors/atlas.h"
#include "modules/impostors/cast.h"

namespace scree::impostors {

// One grain in the middle of a square picture, from an eye at infinity.
struct Scene {
  vec3 axis{0, 0, 1};  // unit, to the eye; right x up = axis
  vec3 right{1, 0, 0};
  vec3 up{0, 1, 0};
  float diameter_px = 64;  // of the outer sphere
  int side_px = 76;

  // Half the picture's side, in outer radii.
  double extent() const { return static_cast<double>(side_px) / static_cast<double>(diameter_px); }
  Shot shot(int samples_a_pixel) const {
    return {dvec3(axis), dvec3(right), dvec3(up), extent(), side_px * samples_a_pixel};
  }
};

// Picture of the atlas as a renderer draws it: one sample a pixel, opaque where the views' coverage
// is half.
images::Image drawImpostor(const ImpostorAtlas& atlas, ImpostorScheme scheme, const Scene& scene);
// Picture of the mesh with samples x samples a pixel.
images::Image drawMesh(const UnitGrain& grain, const Scene& scene, int samples_a_pixel);
// Where the impostor is opaque, and where the mesh is, at samples x samples points of each pixel.
std::vector<uint8_t> impostorMask(const ImpostorAtlas& atlas, ImpostorScheme scheme,
                                  const Scene& scene, int samples_a_pixel);
std::vector<uint8_t> meshMask(const UnitGrain& grain, const Scene& scene, int samples_a_pixel);

// Linear radiance of a surface under the lamp of the pictures: over the viewer's left shoulder,
// with even light from everywhere.
vec3 litSurface(const Surface& surface, const Scene& scene);

}  // namespace scree::impostors
