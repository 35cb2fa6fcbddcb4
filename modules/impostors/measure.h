// How far an impostor is from its mesh: the table that decides between them.
#pragma once

#include <functional>

#include "modules/impostors/atlas.h"
#include "modules/impostors/look.h"

namespace scree::impostors {

// From `directions` random views, the same for every atlas, all schemes, all sizes. Equal on every
// machine up to the last digits of the C library's exp and pow, which FLIP and display colours use.
ImpostorErrors measure(const UnitGrain& grain, const ImpostorAtlas& atlas, int directions,
                       const std::function<void(double)>& progress);

// Mean FLIP of one scheme at one diameter alone.
float flipAt(const UnitGrain& grain, const ImpostorAtlas& atlas, ImpostorScheme scheme,
             float diameter_px, int directions);

// Random view number k, at a size.
Scene randomScene(int k, float diameter_px);

// Area of the difference of two masks over the length of the second's silhouette, in pixels. The
// length is Crofton's: pi / 4 of the crossings along rows and columns.
double silhouetteError(const std::vector<uint8_t>& mask, const std::vector<uint8_t>& truth,
                       int side, int samples_a_pixel);

}  // namespace scree::impostors
