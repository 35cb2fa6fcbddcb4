// Error measures between two finite images of one size.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/assets/image_pixels.h"

namespace scree::images {

// One number a pixel.
using Plane = std::vector<double>;

// Per pixel, the largest absolute difference of its three channels.
Plane pixelDifferences(const Image& a, const Image& b);
// The smallest value that at least `fraction` of all values do not exceed (nearest rank).
double percentile(std::vector<double> values, double fraction);

struct Means {
  double absolute = 0;  // mean of all channels' absolute differences
  double bias = 0;      // largest of the three channels' |mean signed difference|
};
Means meanDifferences(const Image& a, const Image& b);

// Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004): Gaussian window of 11x11 pixels
// with sigma 1.5, K1 = 0.01, K2 = 0.03, dynamic range 1, windows that lie wholly inside, on each of
// the encoded channels. 1 = equal.
inline constexpr int kSsimWindow = 11;
struct Similarity {
  double mean = 1;   // over windows and channels
  double local = 1;  // the smallest: one window of one channel
};
// Both sides at least kSsimWindow pixels.
Similarity ssim(const Image& a, const Image& b);

// Separable filtering with the edge pixels repeated; odd kernel lengths, centred.
Plane filtered(const Plane& plane, int width, int height, const std::vector<double>& along_x,
               const std::vector<double>& along_y);

}  // namespace scree::images
