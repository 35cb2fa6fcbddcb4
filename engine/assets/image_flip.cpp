// FLIP's colour and feature pipelines, section by section of the paper.
#include "engine/assets/image_flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"

namespace scree::images {
namespace {

using Colour = std::array<double, 3>;
using std::numbers::pi;
constexpr size_t kPixelsAtOnce = 16384;

// Linear sRGB to CIE XYZ, D65, as exact quotients from the primaries' chromaticities.
constexpr double kXyzFromRgb[3][3] = {
    {10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};

struct Inverse {
  double m[3][3];
};

constexpr Inverse inverse(const double (&m)[3][3]) {
  Inverse out{};
  double determinant = 0;
  for (int c = 0; c < 3; ++c) {
    determinant +=
        m[0][c] * (m[1][(c + 1) % 3] * m[2][(c + 2) % 3] - m[1][(c + 2) % 3] * m[2][(c + 1) % 3]);
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const int r1 = (c + 1) % 3, r2 = (c + 2) % 3, c1 = (r + 1) % 3, c2 = (r + 2) % 3;
      out.m[r][c] = (m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]) / determinant;
    }
  }
  return out;
}
constexpr Inverse kRgbFromXyz = inverse(kXyzFromRgb);

constexpr Colour times(const double (&m)[3][3], const Colour& v) {
  Colour out{};
  for (int r = 0; r < 3; ++r) out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
  return out;
}
// XYZ of white, so that white has X/Xn = Y/Yn = Z/Zn = 1.
constexpr Colour kWhite = times(kXyzFromRgb, {1, 1, 1});

Colour relativeXyz(const Colour& linear) {
  Colour xyz = times(kXyzFromRgb, linear);
  for (int c = 0; c < 3; ++c) xyz[c] /= kWhite[c];
  return xyz;
}

// The linearised L*a*b* in which contrast sensitivity was measured (section 4.1).
Colour opponentFromLinear(const Colour& linear) {
  const Colour xyz = relativeXyz(linear);
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

Colour linearFromOpponent(const Colour& ycxcz) {
  const double y = (ycxcz[0] + 16) / 116;
  const Colour xyz{(y + ycxcz[1] / 500) * kWhite[0], y * kWhite[1],
                   (y - ycxcz[2] / 200) * kWhite[2]};
  return times(kRgbFromXyz.m, xyz);
}

// L*a*b* with the Hunt effect: colour differences count less in the dark (section 4.2).
Colour huntLab(const Colour& linear) {
  const auto f = [](double t) {
    constexpr double kDelta = 6.0 / 29.0;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29.0;
  };
  const Colour xyz = relativeXyz(linear);
  const double fx = f(xyz[0]), fy = f(xyz[1]), fz = f(xyz[2]);
  const double lightness = 116 * fy - 16;
  return {lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)};
}

double hyab(const Colour& a, const Colour& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Compresses large differences and maps to 0..1, most of the range to the smaller ones (eq. 7, 8).
double redistributed(double distance) {
  constexpr double kCompress = 0.7, kKnee = 0.4, kAtKnee = 0.95;
  static const double largest = std::pow(hyab(huntLab({0, 1, 0}), huntLab({0, 0, 1})), kCompress);
  const double error = std::pow(distance, kCompress);
  const double knee = kKnee * largest;
  if (error < knee) return kAtKnee / knee * error;
  return kAtKnee + (error - knee) / (largest - knee) * (1 - kAtKnee);
}

std::array<Plane, 3> linearPlanes(const Image& image) {
  std::array<Plane, 3> planes;
  for (size_t c = 0; c < 3; ++c) {
    planes[c].resize(image.pixels());
    parallelChunks(image.pixels(), kPixelsAtOnce, [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        planes[c][i] = linearFromSrgb(std::clamp(double{image.rgb[i * 3 + c]}, 0.0, 1.0));
      }
    });
  }
  return planes;
}

// Contrast sensitivity of one opponent channel: a sum of Gaussians a sqrt(pi / b) exp(-pi^2 d^2 /
// b) of the distance d in degrees (eq. 4, table 1).
struct Sensitivity {
  struct Term {
    double a, b;
  };
  std::array<Term, 2> terms;  // the second with a = 0: absent
};
constexpr std::array<Sensitivity, 3> kSensitivities{
    {{{{{1, 0.0047}, {0, 1}}}}, {{{{1, 0.0053}, {0, 1}}}}, {{{{34.1, 0.04}, {13.5, 0.025}}}}}};
constexpr double kWidest = 0.04;

// Three standard deviations of the widest Gaussian, pixels; all channels share it.
int sensitivityRadius(double ppd) {
  return static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * pi * pi)) * ppd));
}

// The sum's weights over the square window add up to 1. Each Gaussian is separable.
Plane sensed(const Plane& plane, int width, int height, const Sensitivity& sensitivity,
             double ppd) {
  const int radius = sensitivityRadius(ppd);
  std::vector<std::vector<double>> kernels;
  std::vector<double> scales;
  double total = 0;
  for (const auto& [a, b] : sensitivity.terms) {
    if (a == 0) continue;
    std::vector<double> kernel;
    double sum = 0;
    for (int i = -radius; i <= radius; ++i) {
      kernel.push_back(std::exp(-pi * pi * (i / ppd) * (i / ppd) / b));
      sum += kernel.back();
    }
    scales.push_back(a * std::sqrt(pi / b));
    total += scales.back() * sum * sum;
    kernels.push_back(std::move(kernel));
  }
  Plane out(plane.size());
  for (size_t term = 0; term < kernels.size(); ++term) {
    std::vector<double> scaled = kernels[term];
    for (double& weight : scaled) weight *= scales[term] / total;
    const Plane part = filtered(plane, width, height, scaled, kernels[term]);
    for (size_t i = 0; i < out.size(); ++i) out[i] += part[i];
  }
  return out;
}

// Per pixel the Hunt-adjusted L*a*b* of what the eye resolves.
std::vector<Colour> perceived(const std::array<Plane, 3>& linear, int width, int height,
                              double ppd) {
  std::array<Plane, 3> opponent;
  for (Plane& plane : opponent) plane.resize(linear[0].size());
  for (size_t i = 0; i < linear[0].size(); ++i) {
    const Colour colour = opponentFromLinear({linear[0][i], linear[1][i], linear[2][i]});
    for (size_t c = 0; c < 3; ++c) opponent[c][i] = colour[c];
  }
  for (size_t c = 0; c < 3; ++c)
    opponent[c] = sensed(opponent[c], width, height, kSensitivities[c], ppd);
  std::vector<Colour> lab(linear[0].size());
  parallelChunks(lab.size(), kPixelsAtOnce, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Colour colour = linearFromOpponent({opponent[0][i], opponent[1][i], opponent[2][i]});
      for (double& channel : colour) channel = std::clamp(channel, 0.0, 1.0);
      lab[i] = huntLab(colour);
    }
  });
  return lab;
}

// Strength of edges and of points: norms of first and second derivatives of a Gaussian as wide as
// the eye's edge detectors (section 4.3). Positive and negative weights each add up to one.
struct Features {
  Plane edges, points;
};

// Standard deviation in pixels: half the width of the eye's edge detectors, 0.082 degrees.
double featureSigma(double ppd) {
  return 0.5 * 0.082 * ppd;
}
int featureRadius(double ppd) {
  return static_cast<int>(std::ceil(3 * featureSigma(ppd)));
}

Features features(const std::array<Plane, 3>& linear, int width, int height, double ppd) {
  const double sigma = featureSigma(ppd);
  const int radius = featureRadius(ppd);
  std::vector<double> smooth, edge, point;
  double smooth_sum = 0, edge_sum = 0, positive = 0, negative = 0;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-i * i / (2 * sigma * sigma));
    smooth.push_back(g);
    edge.push_back(-i * g);
    point.push_back((i * i / (sigma * sigma) - 1) * g);
    smooth_sum += g;
    edge_sum += std::max(edge.back(), 0.0);
    (point.back() > 0 ? positive : negative) += std::abs(point.back());
  }
  for (double& weight : smooth) weight /= smooth_sum;
  for (double& weight : edge) weight /= edge_sum;
  for (double& weight : point) weight /= weight > 0 ? positive : negative;

  Plane luminance(linear[0].size());
  for (size_t i = 0; i < luminance.size(); ++i) {
    luminance[i] = relativeXyz({linear[0][i], linear[1][i], linear[2][i]})[1];
  }
  const auto norm = [&](const std::vector<double>& kernel) {
    Plane x = filtered(luminance, width, height, kernel, smooth);
    const Plane y = filtered(luminance, width, height, smooth, kernel);
    for (size_t i = 0; i < x.size(); ++i) x[i] = std::hypot(x[i], y[i]);
    return x;
  };
  return {norm(edge), norm(point)};
}

}  // namespace

int flipReach(double pixels_per_degree) {
  return std::max(sensitivityRadius(pixels_per_degree), featureRadius(pixels_per_degree));
}

double flipColourError(const double (&a)[3], const double (&b)[3]) {
  return redistributed(hyab(huntLab({a[0], a[1], a[2]}), huntLab({b[0], b[1], b[2]})));
}

Flip flip(const Image& a, const Image& b, double pixels_per_degree) {
  const std::array<Plane, 3> linear_a = linearPlanes(a), linear_b = linearPlanes(b);
  const auto lab_a = perceived(linear_a, a.width, a.height, pixels_per_degree);
  const auto lab_b = perceived(linear_b, a.width, a.height, pixels_per_degree);
  const Features features_a = features(linear_a, a.width, a.height, pixels_per_degree);
  const Features features_b = features(linear_b, a.width, a.height, pixels_per_degree);
  Flip result;
  result.map.resize(a.pixels());
  parallelChunks(a.pixels(), kPixelsAtOnce, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const double colour = redistributed(hyab(lab_a[i], lab_b[i]));
      const double difference = std::max(std::abs(features_a.edges[i] - features_b.edges[i]),
                                         std::abs(features_a.points[i] - features_b.points[i]));
      const double feature = std::sqrt(difference / std::numbers::sqrt2);
      result.map[i] = std::pow(colour, 1 - feature);  // eq. 10
    }
  });
  for (double value : result.map) {
    result.mean += value;
    result.local = std::max(result.local, value);
  }
  result.mean /= static_cast<double>(result.map.size());
  return result;
}

}  // namespace scree::images
