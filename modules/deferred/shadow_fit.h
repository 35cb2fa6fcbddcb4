// Fits the shadow map's view around what casts.
#pragma once

#include <span>

#include "modules/deferred/deferred.h"

namespace scree {

// Empty texels kept around the casters, so that the filter never leaves the map where it matters.
inline constexpr int kShadowBorderTexels = 3;
// The view's sides move in steps of this fraction of the map, and its near and far plane of the
// depth, so that a caster on its way outwards changes the fit, and has the still casters drawn anew,
// once in a while instead of in every frame. Up to as much of the map stays unused.
inline constexpr int kShadowSteps = 32;

// Where the map lies in the world, in double precision. Equal fits draw equal maps of casters that
// stand still, wherever the camera is.
struct ShadowFit {
  bool enabled = false;  // false: no caster in reach, and the rest is zero
  int side = 0;          // texels of the used part
  dvec3 axis_x{0}, axis_y{0}, axis_z{0};  // unit; z points to the sun
  double texel = 0;         // m
  double left = 0, bottom = 0;  // of the map along x and y, m
  double far = 0, depth = 0;    // along z: where depth is 0, and from there to where it is 1, m

  bool operator==(const ShadowFit&) const = default;
};

// Fits a map with a used part of `map_size`^2 texels that contains all casters as far as they reach into the
// square of half side `max_distance_m` around the camera, seen along the light. Texels lie on a grid
// that is fixed in the world, and their size moves in steps of 2^(1/8), so that shadows of what
// stands still do not crawl while other casters move. `to_sun` is a unit vector. Depends on nothing
// but its arguments: a frame looks the same whichever frames were drawn before.
ShadowFit fitShadow(std::span<const ShadowCasters::Sphere> casters, const dvec3& camera,
                    const vec3& to_sun, int map_size, float max_distance_m);

// What programs see of a fit, rounded once. Without casters in reach: enabled = 0, the rest is zero.
rules::ShadowViewBlock shadowViewBlock(const ShadowFit& fit, const dvec3& camera);

// Rows of clip_from_local of a caster, rounded once: independent of the camera.
void writeCasterRows(vec4* rows, const ShadowFit& fit, const Transform& placed);

// Both steps.
rules::ShadowViewBlock fitShadowView(std::span<const ShadowCasters::Sphere> casters,
                                     const dvec3& camera, const vec3& to_sun, int map_size,
                                     float max_distance_m);

}  // namespace scree
