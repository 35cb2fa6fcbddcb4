// Rules of grains that are smaller than a pixel: which are seen, and what they cover. Their light: shared/bed.h.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
RULES_BEGIN

// The map of candidates is of no use here.
const int kPointCarriesBinding = kCandidateMapBinding;
// Nor are the runs' counts.
const int kPointForemostBinding = kSwarmCountsBinding;

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
RULE uint shownInOrder(vec2 fraction, uint pixel) {
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

// What a pixel knows of its foremost point.
struct Foremost {
  float outer_px;  // outer radius, within 0.8 %
  float shown_px;  // that of a ball with its mean shadow, no larger; within 0.8 % and a 500th of the outer one
  vec2 place_px;   // where in the pixel its centre is, [0, 1), within a 128th
};
RULE uint packForemost(Foremost point) {
  float outer = clamp(point.outer_px, 1e-4f, 6e4f);
  uint share = uint(clamp(point.shown_px / outer, 0.0f, 1.0f) * 255.0f + 0.5f);
  uint x = uint(clamp(point.place_px.x, 0.0f, 0.999f) * 64.0f), y = uint(clamp(point.place_px.y, 0.0f, 0.999f) * 64.0f);
  return (packHalf2x16(vec2(outer, 0.0f)) + 4u) >> 3u << 20u | share << 12u | x << 6u | y;
}
RULE Foremost unpackForemost(uint code) {
  Foremost point;
  point.outer_px = unpackHalf2x16(code >> 20u << 3u).x;
  point.shown_px = point.outer_px * (float(code >> 12u & 255u) * (1.0f / 255.0f));
  point.place_px = (vec2(float(code >> 6u & 63u), float(code & 63u)) + vec2(0.5f, 0.5f)) * (1.0f / 64.0f);
  return point;
}

// Where more points than this fill a pixel, some stand for all, their areas the larger (stochastic simplification: Cook,
// Halstead, Planck and Ryu 2007, section 3): which ones is a matter of their ranks. Who leaves or joins as the camera moves
// has no area then, and lies a band behind where it is, so that the foremost are others.
const float kMostPointsAPixel = 10.0f;

// How many points that are drawn fill a pixel.
RULE float pointsAPixel(float radius_px) { return clamp(1.0f / (3.14159265f * max(radius_px * radius_px, 1e-6f)), 1.0f, kMostPointsAPixel); }

// Points of ranks below this are drawn; all, if it is 1 or more. Ranks: [0, 1), evenly spread.
const float kPointFade = 0.2f;  // share of the ranks that are drawn whose points are not yet full
RULE float leastHiddenRank(float radius_px) {
  return min(kMostPointsAPixel * 3.14159265f * radius_px * radius_px, 1.0f) * (1.0f / (1.0f - kPointFade));
}
// 0: not drawn, 1: in full.
RULE float pointFullness(float rank, float least_hidden) {
  float s = max(least_hidden, 1e-12f);
  return clamp((s - rank) / (kPointFade * s), 0.0f, 1.0f);
}
// What a full point's area is multiplied by, so that the mean over all ranks is 1; 1 where all are drawn.
RULE float pointWeight(float least_hidden) {
  float s = max(least_hidden, 1e-12f), beyond = max(s - 1.0f, 0.0f);
  return 1.0f / (s * (1.0f - 0.5f * kPointFade) - beyond * beyond / (2.0f * kPointFade * s));
}
// Ranks of a run's grains: by their places in it, so that those of neighbours in space are far apart (van der Corput 1935),
// but in each run and swarm in another way, so that no order in which grains are given has a part in who is drawn.
struct RunRanks {
  uint flipped;  // bits of a grain's place
  float first;
};
RULE RunRanks ranksOfRun(uint run, uint seed) {
  uint h = (run * 0x9e3779b1u ^ seed * 0x85ebca6bu) + 0x7f4a7c15u;
  h = (h ^ h >> 15u) * 0x2c1b3c6du;
  h = (h ^ h >> 12u) * 0x297a2d39u;
  h = h ^ h >> 15u;
  RunRanks ranks;
  ranks.flipped = h & 63u;
  ranks.first = float(h >> 8u) * (1.0f / (64.0f * 16777216.0f));
  return ranks;
}
RULE uint reversed3(uint k) { return (k & 1u) << 2u | (k & 2u) | k >> 2u; }
RULE float rankOf(uint grain_in_run, RunRanks ranks) {
  uint k = grain_in_run ^ ranks.flipped;
  return float(reversed3(k & 7u) << 3u | reversed3(k >> 3u)) * (1.0f / 64.0f) + ranks.first;
}
// Bit k: whether that one of eight grains, those of word w of a run, may have a rank below this.
RULE uint ranksBelow(float least_hidden, RunRanks ranks, uint w) {
  uint below = uint(clamp(ceil((least_hidden - ranks.first) * 64.0f), 0.0f, 64.0f));
  uint m = (below + 7u - reversed3(w ^ ranks.flipped >> 3u)) >> 3u;  // of the eight, the first in the order 0 4 2 6 1 5 3 7
  uint bits = (m > 7u ? 0xffu : m > 3u ? 0x7f775755u >> 8u * (m - 4u) : 0x15110100u >> 8u * m) & 255u;
  if ((ranks.flipped & 1u) != 0u) bits = (bits & 0x55u) << 1u | (bits >> 1u & 0x55u);
  if ((ranks.flipped & 2u) != 0u) bits = (bits & 0x33u) << 2u | (bits >> 2u & 0x33u);
  if ((ranks.flipped & 4u) != 0u) bits = (bits & 0x0fu) << 4u | bits >> 4u;
  return bits;
}

// Points around belong to the same surface up to this change of distance, pixels a pixel: it is seen at 5 degrees.
const float kMostSlope = 12.0f;

// The plane through points: their places, pixels, and 1 / distance along the view axis, which is even on a plane.
struct PlaneSums {
  float count;
  float inverse;
  vec2 place;
  vec3 places;  // xx, yy, xy
  vec2 both;
};
RULE PlaneSums addToPlane(PlaneSums sums, vec2 place, float inverse) {
  sums.count += 1.0f;
  sums.inverse += inverse;
  sums.place = sums.place + place;
  sums.places = sums.places + vec3(place.x * place.x, place.y * place.y, place.x * place.y);
  sums.both = sums.both + place * inverse;
  return sums;
}
// How it changes from pixel to pixel; where points lie in a line, across it not at all.
RULE vec2 planeChange(PlaneSums sums) {
  float n = 1.0f / max(sums.count, 1.0f);
  float xx = sums.places.x - sums.place.x * sums.place.x * n + 0.05f, yy = sums.places.y - sums.place.y * sums.place.y * n + 0.05f;
  float xy = sums.places.z - sums.place.x * sums.place.y * n;
  vec2 both = sums.both - sums.place * (sums.inverse * n);
  return vec2(both.x * yy - both.y * xy, both.y * xx - both.x * xy) * (1.0f / (xx * yy - xy * xy));
}

// Shares of a point among the 2 x 2 pixels whose centres are around it: x and y from the lower left one.
RULE vec4 pointShares(vec2 fraction) {
  vec2 g = vec2(1.0f, 1.0f) - fraction;
  return vec4(g.x * g.y, fraction.x * g.y, g.x * fraction.y, fraction.x * fraction.y);
}

RULES_END
