// FLIP: the difference that a viewer sees when two images alternate (Andersson, Nilsson,
// Akenine-Moeller, Oskarsson, Astroem and Fairchild 2020), for low-dynamic-range images.
#pragma once

#include "engine/assets/image_metrics.h"

namespace scree::images {

// A monitor 0.7 m wide with 3840 pixels, seen from 0.7 m.
inline constexpr double kPixelsPerDegree = 67.0;

struct Flip {
  double mean = 0;   // 0 = equal, 1 = the largest difference that the model knows
  double local = 0;  // the largest of all pixels
  Plane map;         // one value a pixel, 0 to 1
};

// Both finite and of one size; values outside 0..1 are clamped. Symmetric in its arguments.
Flip flip(const Image& a, const Image& b, double pixels_per_degree = kPixelsPerDegree);

// How far, in pixels, a pixel's value depends on others.
int flipReach(double pixels_per_degree);

// The colour pipeline's last step for two linear colours of wide, even areas: HyAB distance of
// Hunt-adjusted L*a*b*, compressed and redistributed to 0..1 (equations 6 to 8 of the paper).
double flipColourError(const double (&a)[3], const double (&b)[3]);

}  // namespace scree::images
