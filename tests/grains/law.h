// What the tests of granular laws share: fits and packing measures; plots are in law_plot.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <unordered_map>
#include <vector>

#include "tests/grains/field.h"
#include "tests/support/law_plot.h"

namespace scree::grains::test {

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
