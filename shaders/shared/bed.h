// Rules of light from a bed of balls of which none is seen by itself: which sides of them are seen, what these
// receive, and the normal that receives as much. Their gloss: shared/bed_gloss.h.
//
// Model: balls at random, their centres below a plane whose normal is `up`. A side with normal n is seen if no
// other centre lies within a radius of the ray from there to the eye; the volume of that tube grows with the depth
// of the side, so that the share of sides seen is exp(steepness n.up) of those that face the eye. Directions are
// unit vectors; means are over what the eye sees.
#pragma once
#include "shared/brdf.h"
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

// Mean of the cosine to the light, 0 where a side faces away from it. Both cosines are above 0 in a lune, in whose
// coordinates the integrals over powers of n.up separate. With equal shares: Schoenberg 1929.
RULE float bedTowards(vec3 to_eye, vec3 to_light, vec3 up, vec3 shares) {
  float c = clamp(dot(to_eye, to_light), -1.0f, 1.0f), a = 0.5f * acos(-c);  // half the lune's width
  vec3 sum = to_eye + to_light, apart = to_light - to_eye;
  float middle = dot(up, sum) / sqrt(max(dot(sum, sum), 1e-12f));
  float aside = dot(up, apart) / sqrt(max(dot(apart, apart), 1e-12f));
  float across2 = max(1.0f - middle * middle - aside * aside, 0.0f);
  float s1 = sin(a), c1 = cos(a), s2 = 2.0f * s1 * c1, c2 = c1 * c1 - s1 * s1;
  float even = 0.5f * (s2 + 2.0f * a * c);
  float first = 0.5f * s1 * (2.0f - (4.0f / 3.0f) * s1 * s1 + 2.0f * c);
  float square = a + 0.5f * s2 * c2, linear = s2 + 2.0f * a * c;
  float along2 = 0.25f * (linear + square + c * s2), aside2 = 0.25f * (linear - square - c * s2);
  float light = shares.x * (4.0f / 3.0f) * even + shares.y * (3.0f / 8.0f) * kPi * middle * first +
                shares.z * ((16.0f / 15.0f) * (middle * middle * along2 + aside * aside * aside2) +
                            (4.0f / 15.0f) * across2 * even);
  return clamp(light / (kPi * bedSeen(shares, dot(to_eye, up))), 0.0f, 1.0f);
}

// Mean of n.y and of its square.
RULE vec2 bedHeights(vec3 to_eye, vec3 up, vec3 shares) {
  float facing = dot(to_eye, up), v = to_eye.y, u = up.y;
  float first = shares.x * (2.0f / 3.0f) * v + shares.y * 0.25f * (u + facing * v) +
                shares.z * (2.0f / 15.0f) * (v + 2.0f * facing * u);
  float second = shares.x * 0.25f * (1.0f + v * v) + shares.y * (2.0f / 15.0f) * (facing + 2.0f * u * v) +
                 shares.z * (1.0f / 24.0f) *
                     (1.0f + 2.0f * u * u + facing * facing + v * v + 4.0f * u * v * facing - v * v * facing * facing);
  return vec2(first, second) * (1.0f / bedSeen(shares, facing));
}

// The height y of the normal of one surface with linear y + square y^2 as the mean of both, the nearest to heights.x.
RULE float bedHeight(vec2 heights, float linear, float square) {
  float wanted = linear * heights.x + square * heights.y, slope = linear + 2.0f * square * heights.x;
  // About heights.x: square d^2 + slope d = rest.
  float rest = wanted - linear * heights.x - square * heights.x * heights.x;
  float root = slope * slope + 4.0f * square * rest;
  if (!(root > 0.0f)) return heights.x;
  float below = abs(slope) + sqrt(root);
  float d = below > 1e-9f ? 2.0f * rest / below * (slope < 0.0f ? -1.0f : 1.0f) : 0.0f;
  return clamp(heights.x + d, -1.0f, 1.0f);
}

// The normal with this cosine to the light and, as far as that allows, this height; on the eye's side.
RULE vec3 bedNormal(vec3 to_eye, vec3 to_light, float cosine, float height) {
  float c = to_light.y, rest = sqrt(max(1.0f - cosine * cosine, 0.0f));
  vec3 side = vec3(0.0f, 1.0f, 0.0f) - to_light * c;
  float s2 = dot(side, side);
  if (s2 < 1e-6f) {  // from above: the height is given
    side = to_eye - to_light * dot(to_eye, to_light);
    s2 = dot(side, side);
    if (s2 < 1e-6f) side = vec3(1.0f, 0.0f, 0.0f), s2 = 1.0f;
    return to_light * cosine + side * (rest / sqrt(s2));
  }
  side = side * (1.0f / sqrt(s2));
  float along = clamp((height - cosine * c) / sqrt(s2), -rest, rest);
  vec3 across = vec3(to_light.y * side.z - to_light.z * side.y, to_light.z * side.x - to_light.x * side.z,
                     to_light.x * side.y - to_light.y * side.x);
  float last = sqrt(max(rest * rest - along * along, 0.0f));
  return to_light * cosine + side * along + across * (dot(across, to_eye) < 0.0f ? -last : last);
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
