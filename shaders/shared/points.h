// Rules of grains that are smaller than a pixel: which are seen, and what they cover. Their light: shared/bed.h.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
RULES_BEGIN

// The map of candidates is of no use here.
const int kPointCarriesBinding = kCandidateMapBinding;
// Nor are the runs' counts.
const int kPointRadiiBinding = kSwarmCountsBinding;

// Sums are kept in whole numbers, whose order of addition does not matter: areas in this part of a pixel.
// Colours of up to 255 times 2,056 pixels of area fit in 32 bits, and 1,024 times that with ten bits of carries;
// so does the area itself with two: 668,000 of the largest grains in the middle of one pixel, a million between four.
// Of more, colours are wrong, and nothing else.
const float kPointAreaSteps = 8192.0f;

// No point is larger: of one made larger, nothing but its middle is drawn. Radius, pixels.
const float kLargestPointPx = 1.0f;

// Mean height of a ball's near side above its centre, in radii: over its disc of sqrt(1 - x^2 - y^2).
const float kMeanFront = 2.0f / 3.0f;

// Nearer is greater. `along`: distance along the view axis.
RULE uint pointKey(float along) { return floatBitsToUint(1.0f / max(along, 1e-30f)); }
RULE float alongOf(uint key) { return 1.0f / uintBitsToFloat(key); }

// The bit of a pixel's key that says that some grain shows there, however little it covers: no distance has it. A grain
// shows in as many of the 2 x 2 pixels around its centre as its area is, in the mean over grains, the nearest first, and
// of how many it is stays the same wherever it moves: one that is alone neither vanishes nor blinks.
const uint kPointMark = 1u << 31u;
// `own`: a number of the grain's own, [0, 1).
RULE uint pointPixels(float area, float own) { return uint(area + own); }
// How many of the 2 x 2 pixels are nearer to the centre than this one, x + 2 y from the lower left one.
RULE uint pointRank(vec2 fraction, uint pixel) {
  uint x = fraction.x < 0.5f ? 0u : 1u, y = fraction.y < 0.5f ? 0u : 1u;
  bool other_x = (pixel & 1u) != x, other_y = pixel >> 1u != y;
  bool x_first = abs(fraction.x - 0.5f) <= abs(fraction.y - 0.5f);
  return other_x && other_y ? 3u : other_x ? (x_first ? 1u : 2u) : other_y ? (x_first ? 2u : 1u) : 0u;
}
// A pixel with at most this many centres in the 3 x 3 pixels around, and less than this area, is not of a bed: it shows
// only if it is marked. More area than that in a pixel without a mark is not of one grain.
const int kLonePoints = 2;
const float kLoneArea = 1.0f;

// How far behind the foremost grain of its pixel one may be and still be seen: what lies between the grains of
// a surface, and how far a surface seen at 45 degrees recedes within a pixel. m.
RULE float pointBand(float radius, float pixel_m) { return 2.5f * radius + pixel_m; }

// The radii of a pixel's foremost point, in pixels: outer, and that of a ball with its mean shadow.
RULE uint packPointRadii(vec2 radii_px) { return packHalf2x16(radii_px); }
RULE vec2 unpackPointRadii(uint code) { return unpackHalf2x16(code); }

// How many points fill a pixel.
RULE float pointsAPixel(float radius_px) { return max(1.0f / (3.14159265f * max(radius_px * radius_px, 1e-6f)), 1.0f); }

// 1 / distance of the surface in the middle of a pixel, from that of its foremost point: where the surface recedes
// within the pixel, the foremost of many points lies near its nearest edge, which shadows fall behind. Of n at random
// on [0, 1] the greatest is n / (n + 1) in the mean. `change`: from pixel to pixel; n: as many as fill the pixel.
RULE float middleInverse(float foremost, vec2 change, float radius_px) {
  float n = pointsAPixel(radius_px);
  float nearer = 0.5f * (n - 1.0f) / (n + 1.0f) * (abs(change.x) + abs(change.y));
  return max(foremost - nearer, 0.5f * foremost);
}

// Points around belong to the same surface up to this change of distance, pixels a pixel: it is seen at 5 degrees.
const float kMostSlope = 12.0f;

// Shares of a point among the 2 x 2 pixels whose centres are around it: x and y from the lower left one.
RULE vec4 pointShares(vec2 fraction) {
  vec2 g = vec2(1.0f, 1.0f) - fraction;
  return vec4(g.x * g.y, fraction.x * g.y, g.x * fraction.y, fraction.x * fraction.y);
}

RULES_END
