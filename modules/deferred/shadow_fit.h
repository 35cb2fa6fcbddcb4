// Fits the shadow map's view around what casts.
#pragma once

#include <span>

#include "modules/deferred/deferred.h"

namespace scree {

// Empty texels kept around the casters, so that the filter never leaves the map where it matters.
inline constexpr int kShadowBorderTexels = 3;

// The view of a map with a used part of `map_size`^2 texels that contains all casters as far as they reach into the
// square of half side `max_distance_m` around the camera, seen along the light. Texels lie on a grid
// that is fixed in the world, and their size moves in steps of 2^(1/8), so that shadows of what
// stands still do not crawl while other casters move. Computed in double precision, rounded once.
// `to_sun` is a unit vector. Without casters in reach: enabled = 0, the rest is zero.
rules::ShadowViewBlock fitShadowView(std::span<const ShadowCasters::Sphere> casters,
                                     const dvec3& camera, const vec3& to_sun, int map_size,
                                     float max_distance_m);

}  // namespace scree
