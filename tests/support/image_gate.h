// The one gate for image comparisons: compareImages, and gate against a golden file.
//
// Checks in this order, and the first that fails names the failure: size, finite, content, id, max,
// p999, ssim, flip, mean. Goldens are PNG files (with NAME.id.png where there are ids) that only
// tests/run.sh --update-goldens writes (SCREE_UPDATE_GOLDENS=1): a missing golden fails.
#pragma once

#include <filesystem>
#include <string>

#include "engine/assets/image_flip.h"
#include "engine/assets/image_metrics.h"
#include "engine/assets/image_pixels.h"

namespace scree::images {

// What a comparison allows. Colours are 0 to 1, so one step of 8 bits is 1 / 255.
struct GateBounds {
  // Of each image, the least share of pixels that differ by more than 2 / 255 from the image's
  // median colour: black, empty and uniform pictures fail.
  double min_content = 0.001;
  // Stray pixels: whose id differs, or whose colour differs by more than max_difference. As many
  // are allowed, if they lie in (8-connected) groups of at most max_stray_group; the other checks
  // leave them out. For silhouettes, which another machine's rounding may move.
  int max_stray_pixels = 0;
  int max_stray_group = 2;
  double max_difference = 0;       // largest difference of one channel of one pixel
  double max_p999 = 0;             // 99.9th percentile of the pixels' differences
  double min_ssim = 1;             // mean
  double min_local_ssim = 1;       // of one window: what a mean forgives
  double max_flip = 0;             // mean
  double max_local_flip = 0;       // of one pixel
  double max_mean_difference = 0;  // mean absolute difference
  double max_bias = 0;             // mean signed difference of a channel
  double pixels_per_degree = kPixelsPerDegree;
};

// Every pixel equal: the same binary on the same machine.
GateBounds exactBounds();
// Rounding of one step of 8 bits anywhere, and `stray_pixels` moved silhouette pixels: the same
// pictures from another machine, thread count or context.
GateBounds crossMachineBounds(int stray_pixels = 0);

struct GateResult {
  bool passed = false;
  std::string check;    // the first that failed: "finite", ...; "golden" if it cannot be read
  std::string message;  // one line: what failed, where, by how much, and the figures
  // Figures that were reached; -1: not reached.
  double content = -1;  // of the image with less of it
  int stray_pixels = -1, largest_stray_group = -1, different_ids = -1;
  double max_difference = -1, p999 = -1;
  Similarity similarity{-1, -1};
  double mean_flip = -1, local_flip = -1;
  Means means{-1, -1};
  std::filesystem::path picture;  // image | golden | difference, if it was written
};

// The comparison alone: writes nothing. Both images as given, so that exact bounds compare floats.
GateResult compareImages(const Image& actual, const Image& golden, const GateBounds& bounds = {});

// Compares `actual`, rounded to 8 bits, with the golden at `golden`. A failure writes
// NAME.actual.png, NAME.golden.png and the three side by side, NAME.difference.png, into
// failureFolder(); a success removes these. With SCREE_UPDATE_GOLDENS=1 writes the golden instead,
// but not from an image that is not finite or has no content.
GateResult gate(const Image& actual, const std::filesystem::path& golden,
                const GateBounds& bounds = crossMachineBounds());

// "grains/heap" -> <source>/tests/grains/golden/heap.png
std::filesystem::path goldenPath(const std::string& name);
// $SCREE_FAILURES, else failures/ in the build folder.
std::filesystem::path failureFolder();

// Side by side: actual, golden, difference (brighter = more; stray pixels magenta). The sizes may
// differ.
Image differencePicture(const Image& actual, const Image& golden);

}  // namespace scree::images
