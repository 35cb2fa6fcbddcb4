// The picture that a failing comparison leaves: image, golden and difference side by side.
#include <algorithm>
#include <cmath>

#include "tests/support/image_gate.h"

namespace scree::images {
namespace {

constexpr int kGap = 4;  // pixels between the three

bool finite(const float* rgb) {
  return std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]);
}

void place(const Image& image, int left, Image& out) {
  for (int y = 0; y < image.height; ++y) {
    std::copy_n(&image.rgb[static_cast<size_t>(y) * image.width * 3],
                static_cast<size_t>(image.width) * 3,
                &out.rgb[(static_cast<size_t>(y) * out.width + left) * 3]);
  }
}

}  // namespace

Image differencePicture(const Image& actual, const Image& golden) {
  const int width = std::min(actual.width, golden.width),
            height = std::min(actual.height, golden.height);
  Image difference{width, height, {}, {}};
  difference.rgb.resize(difference.pixels() * 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t a = static_cast<size_t>(y) * actual.width + x;
      const size_t g = static_cast<size_t>(y) * golden.width + x;
      float* to = &difference.rgb[(static_cast<size_t>(y) * width + x) * 3];
      const bool other_id =
          a < actual.ids.size() && g < golden.ids.size() && actual.ids[a] != golden.ids[g];
      if (other_id || !finite(&actual.rgb[a * 3]) || !finite(&golden.rgb[g * 3])) {
        to[0] = to[2] = 1;
        continue;
      }
      for (size_t c = 0; c < 3; ++c) {
        // A square root, so that one step of 8 bits can be seen: 1/255 is shown as 16/255.
        to[c] = std::sqrt(std::min(std::abs(actual.rgb[a * 3 + c] - golden.rgb[g * 3 + c]), 1.0f));
      }
    }
  }
  Image out{actual.width + golden.width + width + 2 * kGap,
            std::max(actual.height, golden.height),
            {},
            {}};
  out.rgb.assign(out.pixels() * 3, 0.5f);
  place(actual, 0, out);
  place(golden, actual.width + kGap, out);
  place(difference, actual.width + golden.width + 2 * kGap, out);
  return out;
}

}  // namespace scree::images
