// Differences, percentiles and structural similarity.
#include "engine/assets/image_metrics.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"

namespace scree::images {
namespace {

constexpr size_t kRowsAtOnce = 16;

std::vector<double> gaussianWindow() {
  constexpr double kSigma = 1.5;
  std::vector<double> window(kSsimWindow);
  double sum = 0;
  for (int i = 0; i < kSsimWindow; ++i) {
    const double d = i - kSsimWindow / 2;
    window[i] = std::exp(-d * d / (2 * kSigma * kSigma));
    sum += window[i];
  }
  for (double& w : window) w /= sum;
  return window;
}

}  // namespace

Plane pixelDifferences(const Image& a, const Image& b) {
  Plane differences(a.pixels());
  for (size_t i = 0; i < differences.size(); ++i) {
    double largest = 0;
    for (size_t c = 0; c < 3; ++c) {
      largest = std::max(largest, std::abs(double{a.rgb[i * 3 + c]} - double{b.rgb[i * 3 + c]}));
    }
    differences[i] = largest;
  }
  return differences;
}

double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double rank = std::ceil(fraction * static_cast<double>(values.size()));
  const size_t at = static_cast<size_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

Means meanDifferences(const Image& a, const Image& b) {
  double absolute = 0, signed_sum[3] = {};
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    const double difference = double{a.rgb[i]} - double{b.rgb[i]};
    absolute += std::abs(difference);
    signed_sum[i % 3] += difference;
  }
  Means means{absolute / static_cast<double>(a.rgb.size()), 0};
  for (double sum : signed_sum) {
    means.bias = std::max(means.bias, std::abs(sum) / static_cast<double>(a.pixels()));
  }
  return means;
}

Plane filtered(const Plane& plane, int width, int height, const std::vector<double>& along_x,
               const std::vector<double>& along_y) {
  Plane rows(plane.size()), out(plane.size());
  const int x_radius = static_cast<int>(along_x.size()) / 2;
  const int y_radius = static_cast<int>(along_y.size()) / 2;
  parallelChunks(height, kRowsAtOnce, [&](size_t, size_t begin, size_t end) {
    std::vector<double> padded(width + 2 * static_cast<size_t>(x_radius));
    for (size_t y = begin; y < end; ++y) {
      const double* from = &plane[y * width];
      for (int x = -x_radius; x < width + x_radius; ++x) {
        padded[x + x_radius] = from[std::clamp(x, 0, width - 1)];
      }
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (size_t k = 0; k < along_x.size(); ++k) sum += along_x[k] * padded[x + k];
        rows[y * width + x] = sum;
      }
    }
  });
  parallelChunks(height, kRowsAtOnce, [&](size_t, size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      double* to = &out[y * width];
      for (int k = -y_radius; k <= y_radius; ++k) {
        const int source = std::clamp(static_cast<int>(y) + k, 0, height - 1);
        const double* from = &rows[static_cast<size_t>(source) * width];
        const double weight = along_y[k + y_radius];
        for (int x = 0; x < width; ++x) to[x] += weight * from[x];
      }
    }
  });
  return out;
}

Similarity ssim(const Image& a, const Image& b) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  constexpr int kMargin = kSsimWindow / 2;
  const std::vector<double> window = gaussianWindow();
  const size_t pixels = a.pixels();
  double sum = 0, local = 1;
  Plane pa(pixels), pb(pixels), aa(pixels), bb(pixels), ab(pixels);
  for (size_t c = 0; c < 3; ++c) {
    for (size_t i = 0; i < pixels; ++i) {
      pa[i] = a.rgb[i * 3 + c];
      pb[i] = b.rgb[i * 3 + c];
      aa[i] = pa[i] * pa[i];
      bb[i] = pb[i] * pb[i];
      ab[i] = pa[i] * pb[i];
    }
    const auto mean = [&](const Plane& plane) {
      return filtered(plane, a.width, a.height, window, window);
    };
    const Plane mean_a = mean(pa), mean_b = mean(pb);
    const Plane mean_aa = mean(aa), mean_bb = mean(bb), mean_ab = mean(ab);
    for (int y = kMargin; y < a.height - kMargin; ++y) {
      for (int x = kMargin; x < a.width - kMargin; ++x) {
        const size_t i = static_cast<size_t>(y) * a.width + x;
        const double ma = mean_a[i], mb = mean_b[i];
        const double va = mean_aa[i] - ma * ma, vb = mean_bb[i] - mb * mb,
                     vab = mean_ab[i] - ma * mb;
        const double value =
            (2 * ma * mb + kC1) * (2 * vab + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
        sum += value;
        local = std::min(local, value);
      }
    }
  }
  const double windows = 3.0 * (a.width - 2 * kMargin) * (a.height - 2 * kMargin);
  return {sum / windows, local};
}

}  // namespace scree::images
