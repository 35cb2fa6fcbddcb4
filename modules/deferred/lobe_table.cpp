// Builds the lobe table by quasi-random integration.
#include "modules/deferred/lobe_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/parallel.h"
#include "shaders/shared/spread.h"

namespace scree {
namespace {

constexpr int kSize = rules::kLobeTableSize;
constexpr int kSamples = 512;
constexpr double kTwoPi = 6.283185307179586;

// 1 + 2 Lambda of Smith's masking function for GGX.
double smithRoot(double cosine, double alpha2) {
  return std::sqrt(1 + alpha2 * (1 - cosine * cosine) / (cosine * cosine));
}

// Midpoints over which a beta distribution of n.v is summed up, as far as it reaches.
constexpr int kCosines = 64;
struct Cosines {
  std::array<double, kCosines> cosine, weight;
  double sum = 0;
};

Cosines cosinesOf(float n_v, float spread) {
  const double mean = std::clamp((1 - static_cast<double>(spread)) * static_cast<double>(n_v), 1e-4, 1 - 1e-6);
  const double variance = std::max(static_cast<double>(rules::spreadVariance(n_v, spread)), 1e-12);
  // No wider than one that falls from an end, or rises to it.
  const double both = std::max({mean * (1 - mean) / variance - 1, 1 / mean, 1 / (1 - mean)});
  const double up = mean * both - 1, down = (1 - mean) * both - 1;
  const double reach = 5 * std::sqrt(mean * (1 - mean) / (both + 1));
  const double low = std::max(mean - reach, 0.0), high = std::min(mean + reach, 1.0);
  Cosines c;
  double most = -1e300;
  for (size_t k = 0; k < kCosines; ++k) {
    c.cosine[k] = low + (high - low) * (static_cast<double>(k) + 0.5) / kCosines;
    c.weight[k] = up * std::log(c.cosine[k]) + down * std::log(1 - c.cosine[k]);
    most = std::max(most, c.weight[k]);
  }
  for (double& weight : c.weight) c.sum += weight = std::exp(weight - most);
  return c;
}

rules::LobeTerms spreadLobe(std::span<const vec4> table, const Cosines& cosines, float n_v, float roughness, float spread) {
  double a = 0, b = 0;
  for (size_t k = 0; k < kCosines; ++k) {
    const rules::LobeTerms t = sampleLobeTable(table, static_cast<float>(cosines.cosine[k]), roughness);
    a += cosines.weight[k] * static_cast<double>(t.a);
    b += cosines.weight[k] * static_cast<double>(t.b);
  }
  const float alpha = rules::alphaFromRoughness(roughness);
  const rules::LobeTerms wide =
      sampleLobeTable(table, n_v, std::sqrt(std::sqrt(rules::spreadAlpha2(alpha * alpha, spread))));
  return {static_cast<float>(a / cosines.sum), static_cast<float>(b / cosines.sum), wide.tangent, wide.normal};
}

}  // namespace

rules::LobeTerms integrateLobe(double n_v, double alpha, int samples) {
  // The view direction lies in the xz plane; the lobe is symmetric about it, so only y >= 0 is
  // sampled. n_v = 1 is approached, not reached: tangent has a limit there but no value.
  const double vz = std::min(n_v, 0.999999);
  const double vx = std::sqrt(1 - vz * vz);
  const double stretch = 1 / std::hypot(alpha * vx, vz);
  const double hx = alpha * vx * stretch, hz = vz * stretch;  // stretched view direction
  const double alpha2 = alpha * alpha;
  const double view_root = smithRoot(vz, alpha2);
  const double shadowed = 0.5 * (1 + hz);

  double a = 0, b = 0, mean_x = 0, mean_z = 0;
  for (int i = 0; i < samples; ++i) {
    // Pairs mirrored about the plane that v makes with y, so that at n_v = 1 the mean is exactly n.
    const int pair = i / 2;
    const double radius = std::sqrt((pair + 0.5) / (samples / 2));
    const double quarter = std::fmod(pair * 0.6180339887498949 + 0.5, 1.0) * 0.25;
    const double turn = i % 2 == 0 ? quarter : -quarter;
    const double p1 = radius * std::cos(kTwoPi * turn);
    const double p2 = (1 - shadowed) * std::sqrt(std::max(0.0, 1 - p1 * p1)) +
                      shadowed * radius * std::sin(kTwoPi * turn);
    const double p3 = std::sqrt(std::max(0.0, 1 - p1 * p1 - p2 * p2));
    double mx = alpha * (p3 * hx - p2 * hz), my = alpha * p1;
    double mz = std::max(0.0, p3 * hz + p2 * hx);
    const double length = std::sqrt(mx * mx + my * my + mz * mz);
    mx /= length;
    mz /= length;
    const double v_m = vx * mx + vz * mz;
    const double lx = 2 * v_m * mx - vx, lz = 2 * v_m * mz - vz;
    if (lz <= 0 || v_m <= 0) continue;
    // f (n.l) / pdf = G2 / G1 for height-correlated Smith.
    const double weight = (1 + view_root) / (view_root + smithRoot(lz, alpha2));
    const double m = 1 - v_m;
    const double fresnel = m * m * m * m * m;
    a += weight * (1 - fresnel);
    b += weight * fresnel;
    mean_x += weight * lx;
    mean_z += weight * lz;
  }
  const double total = std::max(a + b, 1e-30);
  // n (n.v) - v points along -x with length vx.
  return {static_cast<float>(a / samples), static_cast<float>(b / samples),
          static_cast<float>(-mean_x / (total * vx)), static_cast<float>(mean_z / total)};
}

std::vector<vec4> makeLobeTable() {
  std::vector<vec4> table(kSize * kSize);
  parallelChunks(kSize, 1, [&](size_t, size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const double alpha = rules::alphaFromRoughness(static_cast<float>(y) / (kSize - 1));
      for (int x = 0; x < kSize; ++x) {
        const double root = static_cast<double>(x) / (kSize - 1);
        const rules::LobeTerms t = integrateLobe(std::max(root * root, 1e-4), alpha, kSamples);
        table[y * kSize + x] = vec4(t.a, t.b, t.tangent, t.normal);
      }
    }
  });
  return table;
}

rules::LobeTerms sampleLobeTable(std::span<const vec4> table, float n_v, float roughness) {
  const vec2 texel = rules::lobeTableUv(n_v, roughness) * static_cast<float>(kSize) - vec2(0.5f);
  const int x = std::clamp(static_cast<int>(texel.x), 0, kSize - 2);
  const int y = std::clamp(static_cast<int>(texel.y), 0, kSize - 2);
  const float fx = texel.x - x, fy = texel.y - y;
  const vec4* row = &table[static_cast<size_t>(y * kSize + x)];
  const vec4 v = (row[0] * (1 - fx) + row[1] * fx) * (1 - fy) +
                 (row[kSize] * (1 - fx) + row[kSize + 1] * fx) * fy;
  return {v.x, v.y, v.z, v.w};
}

std::vector<vec4> makeSpreadLobeTables(std::span<const vec4> table) {
  std::vector<vec4> tables(table.begin(), table.end());
  tables.resize(table.size() * (rules::kSpreadSteps + 1));
  parallelChunks(rules::kSpreadSteps, 1, [&](size_t, size_t begin, size_t end) {
    for (size_t step = begin + 1; step <= end; ++step) {
      const float spread = rules::spreadFromCode(static_cast<int>(step));
      for (int x = 0; x < kSize; ++x) {
        const float root = static_cast<float>(x) / (kSize - 1), n_v = std::max(root * root, 1e-4f);
        const Cosines cosines = cosinesOf(n_v, spread);
        for (int y = 0; y < kSize; ++y) {
          const rules::LobeTerms t = spreadLobe(table, cosines, n_v, static_cast<float>(y) / (kSize - 1), spread);
          tables[step * table.size() + static_cast<size_t>(y * kSize + x)] = vec4(t.a, t.b, t.tangent, t.normal);
        }
      }
    }
  });
  return tables;
}

}  // namespace scree
