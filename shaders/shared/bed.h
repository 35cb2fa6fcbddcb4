// Which sides are seen of a bed of balls of which none is told apart: the mean of their normals, which the G-buffer
// keeps as a direction and a spread (shared/spread.h).
//
// Model: balls at random, their centres below a plane whose normal is `up`. A side with normal n is seen if no
// other centre lies within a radius of the ray from there to the eye; the volume of that tube grows with the depth
// of the side, so that the share of sides seen is exp(steepness n.up) of those that face the eye. Directions are
// unit vectors; means are over what the eye sees.
#pragma once
#include "shared/points.h"
#include "shared/prelude.h"
RULES_BEGIN

// Balls / volume of a bed poured at random, at its loosest: Onoda and Liniger 1990.
const float kBedPacking = 0.56f;
// What is seen of a bed at a lower angle than this (its sine) depends on where its single grains lie.
const float kLeastFacing = 0.1f;

// Change of the logarithm of the share that is seen over one radius of depth. The tube's cross section with the
// plane: half of a disc and of an ellipse where it begins, all of the ellipse from a depth of sqrt(1 - facing^2).
// In between it is taken to grow evenly, and its mean is weighted by what is seen there.
RULE float bedSteepness(float facing, float packing) {
  float f = max(facing, kLeastFacing), deep = 0.75f * packing / f, slant = sqrt(max(1.0f - f * f, 0.0f));
  float top = 0.5f * (0.75f * packing + deep), reach = deep * slant;
  float mean = reach > 1e-3f ? (1.0f - exp(-reach)) / reach : 1.0f;
  return top + (deep - top) * mean;
}

// exp(steepness x) for x in [-1, 1], as x.x + x.y x + x.z x^2: its Chebyshev series to the second order.
RULE vec3 bedShares(float steepness) {
  float q = 0.25f * steepness * steepness, h = 0.5f * steepness;
  // Modified Bessel functions of order 0 to 2, to six terms: exact to 1e-5 up to a steepness of 4.
  float i0 = 1.0f + q * (1.0f + q * (0.25f + q * (1.0f / 36.0f + q * (1.0f / 576.0f + q * (1.0f / 14400.0f + q / 518400.0f)))));
  float i1 = h * (1.0f + q * (0.5f + q * (1.0f / 12.0f + q * (1.0f / 144.0f + q * (1.0f / 2880.0f + q / 86400.0f)))));
  float i2 = q * (0.5f + q * (1.0f / 6.0f + q * (1.0f / 48.0f + q * (1.0f / 720.0f + q * (1.0f / 17280.0f + q / 604800.0f)))));
  return vec3(i0 - 2.0f * i2, 2.0f * i1, 4.0f * i2);
}

// Sum of the shares over the sides that face the eye, / pi.
RULE float bedSeen(vec3 shares, float facing) {
  return shares.x + shares.y * (2.0f / 3.0f) * facing + shares.z * (0.25f + 0.25f * facing * facing);
}

// How deep what is seen in a pixel lies behind the mean front of its foremost ball, pixels: sun and eye reach the deeper
// between the balls the looser they lie, and of many the foremost is nearer than most. But where the bed recedes, it is
// the foremost because it lies near the pixel's nearest edge, somewhere in a wedge that holds about one ball. `packing`:
// balls / volume; radii_px: outer, and of a ball with its mean shadow; `receded`: of the bed in the pixel's middle behind
// the foremost, pixels. Fitted to the shadows on beds and heaps: modules/points/README.md. Bounded, so that what a layer
// lies on does not hide it.
RULE float bedSeenDepth(float packing, vec2 radii_px, float receded) {
  float loose = -log(clamp(packing, 0.1f, 1.0f)), n = pointsAPixel(radii_px.y);
  float deep = min(1.8f * radii_px.y * loose, 1.6f * radii_px.x), in_wedge = 1.4f * sqrt(radii_px.y * max(receded, 0.0f) / n);
  return (deep - in_wedge) * (1.0f - 1.0f / n);
}

// Of a ball that covers the pixel's middle, so much of that.
const float kCoveredDepth = 0.87f;

// Mean of their normals: integrals of one to three normals over the half sphere, weighted by the cosine to the eye.
RULE vec3 bedMeanNormal(vec3 to_eye, vec3 up, vec3 shares) {
  float facing = dot(to_eye, up);
  vec3 sum = to_eye * (shares.x * (2.0f / 3.0f)) + (up + to_eye * facing) * (shares.y * 0.25f) +
             (to_eye + up * (2.0f * facing)) * (shares.z * (2.0f / 15.0f));
  return sum * (1.0f / bedSeen(shares, facing));
}

// The normal of a plane, towards the eye, from how 1 / (distance along the view axis) changes from pixel to pixel,
// which on a plane it does evenly. `ray`: with 1 along the view axis; ray_x, ray_y: its change over a pixel.
RULE vec3 planeNormal(vec3 ray, vec3 ray_x, vec3 ray_y, vec3 forward, float inverse, vec2 change) {
  vec3 n = ray_x * (change.x / dot(ray_x, ray_x)) + ray_y * (change.y / dot(ray_y, ray_y));
  n = n + forward * (inverse - dot(n, ray));
  float length2 = dot(n, n);
  return length2 > 0.0f ? n * (-1.0f / sqrt(length2)) : forward * -1.0f;
}

RULES_END
