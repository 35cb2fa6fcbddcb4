// Tests of SSIM and FLIP: against slow direct implementations, known values, and properties.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engine/assets/image_flip.h"
#include "engine/assets/image_metrics.h"
#include "tests/image_gate/pictures.h"

namespace scree::images {
namespace {

// The oracles below follow the papers pixel by pixel: full two-dimensional windows, long double or
// double, no code shared with what they check.
double at(const Image& image, int x, int y, int c) {
  x = std::clamp(x, 0, image.width - 1);
  y = std::clamp(y, 0, image.height - 1);
  return image.rgb[(static_cast<size_t>(y) * image.width + x) * 3 + c];
}

// Wang et al. 2004, section III.B and equation 13, moments about the mean.
std::pair<double, double> slowSsim(const Image& a, const Image& b) {
  double total = 0, lowest = 1;
  int windows = 0;
  for (int c = 0; c < 3; ++c) {
    for (int cy = 5; cy < a.height - 5; ++cy) {
      for (int cx = 5; cx < a.width - 5; ++cx) {
        long double weights = 0, mx = 0, my = 0, sxx = 0, syy = 0, sxy = 0;
        for (int pass = 0; pass < 2; ++pass) {
          for (int j = -5; j <= 5; ++j) {
            for (int i = -5; i <= 5; ++i) {
              const long double w = std::exp(-(i * i + j * j) / (2.0L * 1.5L * 1.5L));
              const long double x = at(a, cx + i, cy + j, c), y = at(b, cx + i, cy + j, c);
              if (pass == 0) {
                weights += w;
                mx += w * x;
                my += w * y;
              } else {
                sxx += w * (x - mx) * (x - mx);
                syy += w * (y - my) * (y - my);
                sxy += w * (x - mx) * (y - my);
              }
            }
          }
          if (pass == 0) {
            mx /= weights;
            my /= weights;
          }
        }
        const long double luminance = (2 * mx * my + 1e-4L) / (mx * mx + my * my + 1e-4L);
        const long double structure =
            (2 * sxy / weights + 9e-4L) / (sxx / weights + syy / weights + 9e-4L);
        const double value = static_cast<double>(luminance * structure);
        total += value;
        lowest = std::min(lowest, value);
        ++windows;
      }
    }
  }
  return {total / windows, lowest};
}

// FLIP as in sections 4.1 to 4.4 of the paper, with every filter as a two-dimensional sum a pixel.
using V = std::array<double, 3>;
V slowLinear(const Image& image, int x, int y) {
  V out;
  for (int c = 0; c < 3; ++c) {
    const double s = at(image, x, y, c);
    out[c] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return out;
}
V slowXyz(const V& rgb) {
  // Nine digits of the sRGB primaries' matrix (Lindbloom), instead of exact quotients.
  return {0.412386564 * rgb[0] + 0.357591491 * rgb[1] + 0.180450489 * rgb[2],
          0.212636821 * rgb[0] + 0.715182981 * rgb[1] + 0.072180198 * rgb[2],
          0.019330620 * rgb[0] + 0.119197164 * rgb[1] + 0.950372587 * rgb[2]};
}
V slowRgb(const V& xyz) {
  return {3.241003275 * xyz[0] - 1.537398934 * xyz[1] - 0.498615861 * xyz[2],
          -0.969224334 * xyz[0] + 1.875930071 * xyz[1] + 0.041554224 * xyz[2],
          0.055639423 * xyz[0] - 0.204011202 * xyz[1] + 1.057148933 * xyz[2]};
}
constexpr double kXn = 0.950428545, kZn = 1.088900371;
V slowLabHunt(const V& rgb) {
  const V xyz = slowXyz(rgb);
  const auto f = [](double t) {
    return t > 216.0 / 24389.0 ? std::pow(t, 1.0 / 3.0) : (24389.0 / 27.0 * t + 16) / 116;
  };
  const double L = 116 * f(xyz[1]) - 16;
  return {L, L / 100 * 500 * (f(xyz[0] / kXn) - f(xyz[1])),
          L / 100 * 200 * (f(xyz[1]) - f(xyz[2] / kZn))};
}
double slowHyab(const V& a, const V& b) {
  return std::fabs(a[0] - b[0]) +
         std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}
V slowFiltered(const Image& image, int x, int y, double ppd) {
  const double pi = std::acos(-1.0);
  const int r = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
  const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}},
               b[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
  V sum{}, weights{};
  for (int j = -r; j <= r; ++j) {
    for (int i = -r; i <= r; ++i) {
      const V xyz = slowXyz(slowLinear(image, x + i, y + j));
      const V opponent{116 * xyz[1] - 16, 500 * (xyz[0] / kXn - xyz[1]),
                       200 * (xyz[1] - xyz[2] / kZn)};
      const double d2 = (i * i + j * j) / (ppd * ppd);
      for (int c = 0; c < 3; ++c) {
        const double w = a[c][0] * std::sqrt(pi / b[c][0]) * std::exp(-pi * pi * d2 / b[c][0]) +
                         a[c][1] * std::sqrt(pi / b[c][1]) * std::exp(-pi * pi * d2 / b[c][1]);
        sum[c] += w * opponent[c];
        weights[c] += w;
      }
    }
  }
  for (int c = 0; c < 3; ++c) sum[c] /= weights[c];
  const double yn = (sum[0] + 16) / 116;
  V rgb = slowRgb({kXn * (sum[1] / 500 + yn), yn, kZn * (yn - sum[2] / 200)});
  for (double& channel : rgb) channel = std::min(1.0, std::max(0.0, channel));
  return slowLabHunt(rgb);
}
// {edge, point} strength.
std::pair<double, double> slowFeatures(const Image& image, int x, int y, double ppd) {
  const double sigma = 0.5 * 0.082 * ppd;
  const int r = static_cast<int>(std::ceil(3 * sigma));
  double value[2][2] = {}, plus[2] = {}, minus[2] = {};
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = -r; j <= r; ++j) {
      for (int i = -r; i <= r; ++i) {
        const double g = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
        const double kernels[2] = {-i * g, (i * i / (sigma * sigma) - 1) * g};
        for (int k = 0; k < 2; ++k) {
          if (pass == 0) {
            (kernels[k] > 0 ? plus[k] : minus[k]) += std::fabs(kernels[k]);
          } else {
            const double w = kernels[k] > 0 ? kernels[k] / plus[k] : kernels[k] / minus[k];
            value[k][0] += w * slowXyz(slowLinear(image, x + i, y + j))[1];
            value[k][1] += w * slowXyz(slowLinear(image, x + j, y + i))[1];
          }
        }
      }
    }
  }
  return {std::sqrt(value[0][0] * value[0][0] + value[0][1] * value[0][1]),
          std::sqrt(value[1][0] * value[1][0] + value[1][1] * value[1][1])};
}
double slowFlip(const Image& a, const Image& b, int x, int y, double ppd) {
  const double largest = std::pow(slowHyab(slowLabHunt({0, 1, 0}), slowLabHunt({0, 0, 1})), 0.7);
  const double e = std::pow(slowHyab(slowFiltered(a, x, y, ppd), slowFiltered(b, x, y, ppd)), 0.7);
  const double knee = 0.4 * largest;
  const double colour = e < knee ? 0.95 * e / knee : 0.95 + 0.05 * (e - knee) / (largest - knee);
  const auto fa = slowFeatures(a, x, y, ppd), fb = slowFeatures(b, x, y, ppd);
  const double difference =
      std::max(std::fabs(fa.first - fb.first), std::fabs(fa.second - fb.second));
  return std::pow(colour, 1 - std::sqrt(difference / std::sqrt(2.0)));
}

Image smallScene(uint64_t seed) {
  return discScene(40, 33, strewnDiscs(40, 33, 6, 4, seed));
}

TEST(Percentile, NearestRank) {
  EXPECT_EQ(percentile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(percentile({3, 1, 2}, 1.0), 3);
  EXPECT_EQ(percentile({3, 1, 2}, 0.0), 1);
  std::vector<double> values(1000, 0.0);
  values[17] = 5;
  EXPECT_EQ(percentile(values, 0.999), 0) << "one in a thousand is above the 99.9th";
  values[18] = 4;
  EXPECT_EQ(percentile(values, 0.999), 4);
}

TEST(Means, BiasIsOfTheWorstChannelAndSigned) {
  const Image grey = flatImage(16, 16, 0.5f, 0.5f, 0.5f);
  Image moved = grey;
  for (size_t i = 0; i < moved.rgb.size(); ++i)
    moved.rgb[i] += i % 3 == 1 ? 0.25f : (i / 3 % 2 ? 0.1f : -0.1f);
  const Means means = meanDifferences(moved, grey);
  EXPECT_NEAR(means.absolute, (0.25 + 0.1 + 0.1) / 3, 1e-6);
  EXPECT_NEAR(means.bias, 0.25, 1e-6);
}

TEST(Ssim, AgreesWithTheDirectSum) {
  const Image scene = smallScene(1);
  const Image others[] = {
      withNoise(scene, 2), smallScene(3), randomImage(40, 33, 4),
      recoloured(scene, [](int, float r, float g, float b) { return (r + g + b) / 3; })};
  for (const Image& other : others) {
    const Similarity fast = ssim(scene, other);
    const auto [mean, local] = slowSsim(scene, other);
    EXPECT_NEAR(fast.mean, mean, 1e-9);
    EXPECT_NEAR(fast.local, local, 1e-9);
    EXPECT_LT(fast.mean, 1);
  }
}

TEST(Ssim, KnownValues) {
  // Flat pictures have no structure: (2 a b + C1) / (a^2 + b^2 + C1).
  const Similarity flat =
      ssim(flatImage(16, 12, 0.2f, 0.2f, 0.2f), flatImage(16, 12, 0.6f, 0.6f, 0.6f));
  const double a = 0.2f, b = 0.6f;
  EXPECT_NEAR(flat.mean, (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-9);
  const Image scene = smallScene(1);
  EXPECT_DOUBLE_EQ(ssim(scene, scene).mean, 1);
  EXPECT_DOUBLE_EQ(ssim(scene, scene).local, 1);
  const Image negative = recoloured(scene, [](int c, float r, float g, float bl) {
    return 1 - (c == 0 ? r : c == 1 ? g : bl);
  });
  EXPECT_LT(ssim(scene, negative).local, 0) << "opposed structure is negative";
}

TEST(Ssim, SymmetricAndFallsWithNoise) {
  const Image scene = smallScene(5);
  double last = 1;
  for (float strength : {0.02f, 0.1f, 0.4f}) {
    Image noisy = scene;
    for (size_t i = 0; i < noisy.rgb.size(); ++i)
      noisy.rgb[i] += strength * (randomUnit(6, i, 0, 0) - 0.5f);
    const double value = ssim(scene, noisy).mean;
    EXPECT_DOUBLE_EQ(value, ssim(noisy, scene).mean);
    EXPECT_LT(value, last);
    last = value;
  }
}

TEST(Flip, AgreesWithTheDirectSum) {
  for (double ppd : {67.0, 30.0}) {
    const Image scene = smallScene(1);
    for (const Image& other : {smallScene(3), withNoise(scene, 2), randomImage(40, 33, 4)}) {
      const Flip fast = flip(scene, other, ppd);
      // Corners, edges, and some of the inside: the direct sum takes 800 terms a pixel.
      for (const auto& [x, y] : {std::pair{0, 0},
                                 {39, 0},
                                 {0, 32},
                                 {39, 32},
                                 {20, 0},
                                 {0, 16},
                                 {20, 16},
                                 {7, 29},
                                 {31, 11},
                                 {13, 22},
                                 {26, 5},
                                 {18, 9}}) {
        EXPECT_NEAR(fast.map[static_cast<size_t>(y) * 40 + x], slowFlip(scene, other, x, y, ppd),
                    2e-6)
            << x << ", " << y << " at " << ppd;
      }
    }
  }
}

TEST(Flip, KnownValuesOfFlatColours) {
  // By hand: CIE L*a*b* (D65) of sRGB green is (87.735, -86.183, 83.180) and of blue
  // (32.297, 79.188, -107.860). Hunt: a, b times L / 100. HyAB = 55.438 +
  // hypot(75.613 + 25.575, 72.978 + 34.836) = 203.30, to the power 0.7: 41.27, which is the
  // largest.
  EXPECT_NEAR(flipColourError({0, 1, 0}, {0, 0, 1}), 1, 1e-12);
  // Black and white: 100^0.7 = 25.119; knee at 0.4 * 41.27 = 16.508.
  const double largest = 41.27;
  EXPECT_NEAR(flipColourError({0, 0, 0}, {1, 1, 1}),
              0.95 + 0.05 * (std::pow(100, 0.7) - 0.4 * largest) / (0.6 * largest), 1e-4);
  // Greys of L* = 50 and 51 (Y = ((L + 16) / 116)^3): distance 1.
  const double g50 = std::pow(66.0 / 116, 3), g51 = std::pow(67.0 / 116, 3);
  EXPECT_NEAR(flipColourError({g50, g50, g50}, {g51, g51, g51}), 0.95 / (0.4 * largest), 1e-4);
  // An even picture has no features, so the whole pipeline gives the same.
  const Flip flat = flip(flatImage(20, 14, 0, 0, 0), flatImage(20, 14, 1, 1, 1));
  EXPECT_NEAR(flat.mean, flipColourError({0, 0, 0}, {1, 1, 1}), 1e-9);
  EXPECT_NEAR(flat.local, flat.mean, 1e-9);
  EXPECT_NEAR(flip(flatImage(20, 14, 0, 1, 0), flatImage(20, 14, 0, 0, 1)).mean, 1, 1e-9);
}

TEST(Flip, ZeroForEqualWithinRangeAndSymmetric) {
  const Image pictures[] = {smallScene(1),
                            smallScene(2),
                            randomImage(40, 33, 3),
                            flatImage(40, 33, 0, 0, 0),
                            flatImage(40, 33, 1, 1, 1),
                            flatImage(40, 33, 0, 0, 1)};
  for (const Image& a : pictures) {
    for (const Image& b : pictures) {
      const Flip ab = flip(a, b), ba = flip(b, a);
      for (size_t i = 0; i < ab.map.size(); ++i) {
        ASSERT_GE(ab.map[i], 0);
        ASSERT_LE(ab.map[i], 1);
        ASSERT_NEAR(ab.map[i], ba.map[i], 1e-12);
      }
      EXPECT_EQ(ab.mean == 0, a.rgb == b.rgb);
    }
  }
}

TEST(Flip, GrowsWithTheDifference) {
  const Image scene = smallScene(7);
  double last = 0;
  for (float offset : {0.01f, 0.03f, 0.1f, 0.3f}) {
    const Image darker = recoloured(scene, [&](int c, float r, float g, float b) {
      return std::max(0.0f, (c == 0 ? r : c == 1 ? g : b) - offset);
    });
    const double value = flip(scene, darker).mean;
    EXPECT_GT(value, last);
    last = value;
  }
}

TEST(Flip, SeesALostDotMoreFromNearAndAnEdgeMoreThanAnEvenShift) {
  Image dot = flatImage(64, 64, 0.5f, 0.5f, 0.5f);
  setPixel(dot, 32, 32, 0.9f, 0.9f, 0.9f);
  const Image grey = flatImage(64, 64, 0.5f, 0.5f, 0.5f);
  EXPECT_GT(flip(grey, dot, 20).local, flip(grey, dot, 67).local);
  // Where a feature vanishes the same colour error counts more: colour^(1 - feature).
  Image edge = flatImage(64, 64, 0.5f, 0.5f, 0.5f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 32; x < 64; ++x) setPixel(edge, x, y, 0.6f, 0.6f, 0.6f);
  }
  const Flip seen = flip(grey, edge);
  EXPECT_GT(seen.map[32 * 64 + 34], seen.map[32 * 64 + 60]);
}

}  // namespace
}  // namespace scree::images
