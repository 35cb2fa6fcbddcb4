// Which triangle of a grain each sample of an orthographic picture sees: an exact rasteriser.
#pragma once

#include <span>
#include <vector>

#include "modules/impostors/unit_grain.h"

namespace scree::impostors {

// Where a picture is taken from: sample (0, 0) is the lower left one; the square of the half side
// `extent` around the centre fills the picture.
struct Shot {
  dvec3 axis{0, 0, 1};  // unit, to the eye
  dvec3 right{1, 0, 0};
  dvec3 up{0, 1, 0};
  double extent = 1;
  int samples = 0;  // along each side, at most kMostSamples
};
// Corners are rounded to 1/256 of a sample, and edges taken exactly, in 64 bits: two triangles
// that share an edge share no sample and leave none out.
inline constexpr int kMostSamples = 8192;

struct Seen {
  int triangle = -1;     // -1: nothing
  float b = 0, c = 0;    // barycentric weights of corners 1 and 2
  float height = 0;      // along the axis, from the centre
  bool flipped = false;  // its back, of a double-sided material
};

// Rows from the bottom. Back faces are seen only of double-sided materials. Of two at one height
// the one that comes first in the mesh is seen.
void cast(const UnitGrain& grain, const Shot& shot, std::vector<Seen>& seen);
// The same of a grain whose vertices are elsewhere.
void cast(const UnitGrain& grain, std::span<const dvec3> positions, const Shot& shot, std::vector<Seen>& seen);

}  // namespace scree::impostors
