// What the tests of granular laws share: fits, packing measures, and a plot of what was measured.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/assets/image.h"
#include "tests/grains/field.h"

namespace scree::grains::test {

struct Point {
  double x, y;
};

struct Fit {
  double slope = 0, offset = 0, r2 = 0;
};
inline Fit fitLine(const std::vector<Point>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const Point& p : points) {
    n += 1;
    x += p.x;
    y += p.y;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
  }
  const double vx = n * xx - x * x, vy = n * yy - y * y, c = n * xy - x * y;
  return {c / vx, (y - c / vx * x) / n, c * c / (vx * vy)};
}

inline double r2Of(const std::vector<Point>& measured, const std::vector<Point>& law) {
  double mean = 0, left = 0, all = 0;
  for (const Point& p : measured) mean += p.y / static_cast<double>(measured.size());
  for (size_t k = 0; k < measured.size(); ++k) {
    left += (measured[k].y - law[k].y) * (measured[k].y - law[k].y);
    all += (measured[k].y - mean) * (measured[k].y - mean);
  }
  return 1 - left / all;
}

// Takes row k out; the last row takes its place.
inline void removeRow(Field& field, size_t k) {
  const auto take = [k](auto& rows) {
    rows[k] = rows.back();
    rows.pop_back();
  };
  take(field.entity);
  take(field.grain);
  take(field.velocity);
  take(field.spin);
  take(field.orientation);
  take(field.previous);
  take(field.material);
}

// Draws measured points as squares over the law's line, and writes the numbers beside them:
// laws/NAME.png and laws/NAME.csv in the build folder.
inline void plotLaw(const std::string& name, const std::string& x_name, const std::string& y_name,
                    const std::vector<Point>& measured, const std::vector<Point>& law) {
  constexpr int kWidth = 640, kHeight = 400, kEdge = 30;
  double x0 = 1e300, x1 = -1e300, y0 = 0, y1 = -1e300;
  for (const auto* points : {&measured, &law})
    for (const Point& p : *points) {
      x0 = std::min(x0, p.x);
      x1 = std::max(x1, p.x);
      y0 = std::min(y0, p.y);
      y1 = std::max(y1, p.y);
    }
  std::vector<uint8_t> rgb(size_t{kWidth} * kHeight * 3, 255);
  const auto put = [&](double x, double y, int half, vec3 color) {
    for (int j = -half; j <= half; ++j)
      for (int i = -half; i <= half; ++i) {
        const int px = static_cast<int>(x) + i, py = static_cast<int>(y) + j;
        if (px < 0 || py < 0 || px >= kWidth || py >= kHeight) continue;
        for (int c = 0; c < 3; ++c)
          rgb[(static_cast<size_t>(py) * kWidth + static_cast<size_t>(px)) * 3 +
              static_cast<size_t>(c)] = static_cast<uint8_t>(255 * color[c]);
      }
  };
  const auto atX = [&](double x) { return kEdge + (x - x0) / (x1 - x0) * (kWidth - 2 * kEdge); };
  const auto atY = [&](double y) {
    return kHeight - kEdge - (y - y0) / (y1 - y0) * (kHeight - 2 * kEdge);
  };
  for (int x = kEdge; x < kWidth - kEdge; ++x) put(x, kHeight - kEdge, 0, vec3(0));
  for (int y = kEdge; y < kHeight - kEdge; ++y) put(kEdge, y, 0, vec3(0));
  for (size_t k = 0; k + 1 < law.size(); ++k)
    for (int s = 0; s <= 1000; ++s) {
      const double t = s / 1000.0;
      put(atX(law[k].x + t * (law[k + 1].x - law[k].x)),
          atY(law[k].y + t * (law[k + 1].y - law[k].y)), 1, {0.12f, 0.47f, 0.71f});
    }
  for (const Point& p : measured) put(atX(p.x), atY(p.y), 4, {0.84f, 0.15f, 0.16f});
  const std::filesystem::path folder = std::filesystem::path(SCREE_BINARY_DIR) / "laws";
  std::filesystem::create_directories(folder);
  const Status written = writePng(folder / (name + ".png"), kWidth, kHeight, 3, rgb);
  EXPECT_TRUE(written.ok());
  std::ofstream csv(folder / (name + ".csv"));
  csv << x_name << ',' << y_name << ",kind\n";
  for (const Point& p : measured) csv << p.x << ',' << p.y << ",measured\n";
  for (const Point& p : law) csv << p.x << ',' << p.y << ",law\n";
}

// Of the grains whose centre is inside the box [low, high]; all grains count as neighbours.
struct Packing {
  double fraction = 0;  // of the box that is inside a grain, by points r/6 apart
  double contacts = 0;  // mean of the grains that have at least `least` of them (no rattlers)
  double rattlers = 0;  // share of the others
};
using GrainPairs = std::vector<std::pair<uint32_t, uint32_t>>;

// Pairs that are closer than 1e-3 radii.
inline GrainPairs touchingPairs(const Field& field, float radius) {
  GrainPairs touching;
  for (const auto& [a, b] : field.solver.neighbourPairs()) {
    const Grain &i = field.grain[a], &j = field.grain[b];
    if (glm::length(i.position - j.position) <= (i.radius + j.radius) + 1e-3f * radius)
      touching.emplace_back(a, b);
  }
  return touching;
}

inline Packing packingOf(const Field& field, const GrainPairs& pairs, vec3 low, vec3 high, float radius,
                         int least) {
  const float step = radius / 6;
  const auto cells = [&](float extent) { return static_cast<size_t>(extent / step); };
  const vec3 extent = high - low;
  const size_t nx = cells(extent.x), ny = cells(extent.y), nz = cells(extent.z);
  std::vector<uint8_t> filled(nx * ny * nz);
  for (const Grain& g : field.grain) {
    const vec3 from = (g.position - low - g.radius) / step, to = (g.position - low + g.radius) / step;
    const auto first = [](float f) { return static_cast<size_t>(std::max(0.0f, f)); };
    const auto last = [](float t, size_t n) {
      return t <= 0 ? size_t{0} : std::min(n, static_cast<size_t>(t) + 1);
    };
    for (size_t z = first(from.z); z < last(to.z, nz); ++z)
      for (size_t y = first(from.y); y < last(to.y, ny); ++y)
        for (size_t x = first(from.x); x < last(to.x, nx); ++x) {
          const vec3 d = low + (vec3(x, y, z) + 0.5f) * step - g.position;
          if (glm::dot(d, d) < g.radius * g.radius) filled[(z * ny + y) * nx + x] = 1;
        }
  }
  Packing packing;
  for (const uint8_t f : filled) packing.fraction += f;
  packing.fraction /= static_cast<double>(filled.size());

  // Rattlers have too few contacts; without them others may have too.
  std::vector<std::vector<uint32_t>> touching(field.grain.size());
  for (const auto& [a, b] : pairs) {
    touching[a].push_back(b);
    touching[b].push_back(a);
  }
  std::vector<uint8_t> carries(field.grain.size(), 1);
  const auto count = [&](size_t k) {
    int n = 0;
    for (const uint32_t other : touching[k]) n += carries[other];
    return n;
  };
  for (int round = 0; round < 5; ++round)
    for (size_t k = 0; k < carries.size(); ++k) {
      const vec3 p = field.grain[k].position;
      const bool inside = glm::all(glm::greaterThan(p, low - 2 * radius)) &&
                          glm::all(glm::lessThan(p, high + 2 * radius));
      if (inside && count(k) < least) carries[k] = 0;
    }
  double grains = 0;
  for (size_t k = 0; k < carries.size(); ++k) {
    const vec3 p = field.grain[k].position;
    if (!glm::all(glm::greaterThan(p, low)) || !glm::all(glm::lessThan(p, high))) continue;
    packing.rattlers += !carries[k];
    if (!carries[k]) continue;
    packing.contacts += count(k);
    grains += 1;
  }
  packing.rattlers /= std::max(grains + packing.rattlers, 1.0);
  packing.contacts /= std::max(grains, 1.0);
  return packing;
}

}  // namespace scree::grains::test
