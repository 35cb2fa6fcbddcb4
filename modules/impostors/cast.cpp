// Edge functions on integers, with the top-left rule.
#include "modules/impostors/cast.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace scree::impostors {
namespace {

constexpr int64_t kSubsamples = 256;

struct Point {
  int64_t x, y;
};

// Twice the signed area of a, b, p: positive where p is to the left of a to b.
int64_t edge(const Point& a, const Point& b, const Point& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}
// Of a sample on an edge itself: it belongs to the triangle whose edge leads down, or left.
int64_t bias(const Point& a, const Point& b) {
  const bool owns = b.y < a.y || (b.y == a.y && b.x < a.x);
  return owns ? 0 : -1;
}

struct Corner {
  Point at;
  double height;
};

class Canvas {
 public:
  Canvas(const UnitGrain& grain, std::span<const dvec3> positions, const Shot& shot, std::vector<Seen>& seen)
      : grain_(grain), positions_(positions), shot_(shot), seen_(seen) {}

  Corner corner(const dvec3& p) const {
    const double scale = 0.5 * static_cast<double>(shot_.samples * kSubsamples) / shot_.extent;
    const auto snapped = [&](double x) {
      return static_cast<int64_t>(std::floor((x + shot_.extent) * scale + 0.5));
    };
    return {{snapped(glm::dot(p, shot_.right)), snapped(glm::dot(p, shot_.up))},
            glm::dot(p, shot_.axis)};
  }

  void draw(int index) {
    const UnitTriangle& triangle = grain_.triangles[static_cast<size_t>(index)];
    Corner k[3];
    for (int i = 0; i < 3; ++i) k[i] = corner(positions_[triangle.v[i]]);
    int64_t area = edge(k[0].at, k[1].at, k[2].at);
    const bool flipped = area < 0;
    if (area == 0 || (flipped && !triangle.double_sided)) return;
    if (flipped) std::swap(k[1], k[2]);
    area = std::abs(area);
    const auto [x0, x1] = range(k[0].at.x, k[1].at.x, k[2].at.x);
    const auto [y0, y1] = range(k[0].at.y, k[1].at.y, k[2].at.y);
    const int64_t bias_a = bias(k[1].at, k[2].at), bias_b = bias(k[2].at, k[0].at),
                  bias_c = bias(k[0].at, k[1].at);
    for (int64_t y = y0; y <= y1; ++y) {
      for (int64_t x = x0; x <= x1; ++x) {
        const Point p{x * kSubsamples + kSubsamples / 2, y * kSubsamples + kSubsamples / 2};
        const int64_t a = edge(k[1].at, k[2].at, p), b = edge(k[2].at, k[0].at, p),
                      c = edge(k[0].at, k[1].at, p);
        if (a + bias_a < 0 || b + bias_b < 0 || c + bias_c < 0) continue;
        const double inverse = 1 / static_cast<double>(area);
        const double wb = static_cast<double>(b) * inverse, wc = static_cast<double>(c) * inverse;
        const double height =
            k[0].height + (k[1].height - k[0].height) * wb + (k[2].height - k[0].height) * wc;
        Seen found{index, static_cast<float>(flipped ? wc : wb),
                   static_cast<float>(flipped ? wb : wc), static_cast<float>(height), flipped};
        Seen& old = seen_[static_cast<size_t>(y * shot_.samples + x)];
        if (old.triangle >= 0 && !(found.height > old.height)) continue;
        if (triangle.masked && !opaqueAt(grain_, triangle, found.b, found.c)) continue;
        old = found;
      }
    }
  }

 private:
  // First and last sample whose centre may lie between.
  std::pair<int64_t, int64_t> range(int64_t a, int64_t b, int64_t c) const {
    const int64_t low = std::min({a, b, c}), high = std::max({a, b, c});
    return {std::max<int64_t>(low / kSubsamples - 1, 0),
            std::min<int64_t>(high / kSubsamples, shot_.samples - 1)};
  }

  const UnitGrain& grain_;
  std::span<const dvec3> positions_;
  const Shot& shot_;
  std::vector<Seen>& seen_;
};

}  // namespace

void cast(const UnitGrain& grain, const Shot& shot, std::vector<Seen>& seen) { cast(grain, grain.positions, shot, seen); }

void cast(const UnitGrain& grain, std::span<const dvec3> positions, const Shot& shot, std::vector<Seen>& seen) {
  seen.assign(static_cast<size_t>(shot.samples) * static_cast<size_t>(shot.samples), {});
  Canvas canvas(grain, positions, shot, seen);
  for (size_t i = 0; i < grain.triangles.size(); ++i) canvas.draw(static_cast<int>(i));
}

}  // namespace scree::impostors
