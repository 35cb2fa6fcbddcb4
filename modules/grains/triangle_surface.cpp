// Building surfaces of triangles, and their distance queries.
#include "modules/grains/triangle_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace scree::grains {
namespace {

constexpr float kMostCoordinate = 1e6f;  // m

dvec3 unit(dvec3 v) {
  const double square = glm::dot(v, v);
  return square > 0 ? v / std::sqrt(square) : dvec3(0);
}

bool before(vec3 a, vec3 b) {
  return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

// A millionth: below that the regions of nearestOnTriangle are lost in rounding.
bool hasArea(dvec3 a, dvec3 b, dvec3 c) {
  const dvec3 cross = glm::cross(b - a, c - a);
  const double longest =
      std::max({glm::dot(b - a, b - a), glm::dot(c - a, c - a), glm::dot(c - b, c - b)});
  return glm::dot(cross, cross) > 1e-12 * longest * longest;
}

// By triangle: whether one before it has the same corners in the same turn.
std::vector<uint8_t> repeats(std::span<const vec3> corners) {
  struct Turned {
    std::array<vec3, 3> corner;  // the lowest first
    uint32_t triangle;
  };
  std::vector<Turned> all(corners.size() / 3);
  for (uint32_t t = 0; t < all.size(); ++t) {
    const vec3* p = &corners[3 * size_t{t}];
    size_t first = before(p[1], p[0]) ? 1 : 0;
    if (before(p[2], p[first])) first = 2;
    all[t] = {{p[first], p[(first + 1) % 3], p[(first + 2) % 3]}, t};
  }
  std::sort(all.begin(), all.end(), [](const Turned& a, const Turned& b) {
    for (size_t c = 0; c < 3; ++c)
      if (a.corner[c] != b.corner[c]) return before(a.corner[c], b.corner[c]);
    return a.triangle < b.triangle;
  });
  std::vector<uint8_t> repeated(all.size(), 0);
  for (size_t k = 1; k < all.size(); ++k) repeated[all[k].triangle] = all[k].corner == all[k - 1].corner;
  return repeated;
}

}  // namespace

std::string TriangleSurface::build(std::span<const vec3> corners) {
  *this = {};
  if (corners.size() / 3 > kMostTriangles)
    return fmt::format("it has {} triangles; allowed are {}", corners.size() / 3, kMostTriangles);
  for (size_t k = 0; k < corners.size(); ++k)
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(corners[k][axis]) <= kMostCoordinate))
        return fmt::format("a corner of triangle {} is at {} m, scaled; allowed is up to {} m", k / 3,
                           corners[k][axis], kMostCoordinate);
  const std::vector<uint8_t> repeated = repeats(corners);
  std::vector<vec3> kept, needles;
  kept.reserve(corners.size());
  for (size_t k = 0; k + 3 <= corners.size(); k += 3) {
    const vec3 a = corners[k], b = corners[k + 1], c = corners[k + 2];
    if (repeated[k / 3] != 0) continue;
    if (hasArea(a, b, c)) {
      kept.insert(kept.end(), {a, b, c});
      continue;
    }
    ++skipped_;
    if (a != b && b != c && c != a) needles.insert(needles.end(), {a, b, c});
  }
  if (kept.empty())
    return skipped_ == 0 ? "it has no triangles"
                         : fmt::format("none of its {} triangles has an area", corners.size() / 3);
  tree_.build(kept);
  triangles_ = kept.size() / 3;
  corner_.reserve(kept.size() + needles.size());
  for (const uint32_t from : tree_.order())
    for (size_t c = 0; c < 3; ++c) corner_.push_back(kept[3 * size_t{from} + c]);
  corner_.insert(corner_.end(), needles.begin(), needles.end());
  weld();
  connect();
  normals();
  return {};
}

// Triangles in one place are side by side in the tree's order, or nearly: some of them are looked at.
std::string TriangleSurface::crowded() const {
  for (size_t t = 0; t < triangles_; t += kMostInOnePlace / 4) {
    const vec3 middle = (corner_[3 * t] + corner_[3 * t + 1] + corner_[3 * t + 2]) / 3.0f;
    uint32_t here = 0;
    tree_.near(middle, std::numeric_limits<double>::min(), [&](uint32_t, double&) { ++here; },
               [&](vec3, vec3) { return here > kMostInOnePlace; });
    if (here > kMostInOnePlace)
      return fmt::format("more than {} of its triangles are around ({}, {}, {}) m, scaled; allowed are {}", kMostInOnePlace,
                         middle.x, middle.y, middle.z, kMostInOnePlace);
  }
  return {};
}

void TriangleSurface::weld() {
  std::vector<uint32_t> order(corner_.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return before(corner_[a], corner_[b]) || (corner_[a] == corner_[b] && a < b);
  });
  vertex_of_.resize(corner_.size());
  for (const uint32_t corner : order) {
    if (vertex_.empty() || vertex_.back() != corner_[corner]) vertex_.push_back(corner_[corner]);
    vertex_of_[corner] = static_cast<uint32_t>(vertex_.size() - 1);
  }
}

void TriangleSurface::connect() {
  struct Side {
    uint32_t low, high, corner;  // vertices of the edge; the corner where it begins
    bool forward;
  };
  std::vector<Side> sides(vertex_of_.size());
  for (uint32_t k = 0; k < sides.size(); ++k) {
    const uint32_t a = vertex_of_[k], b = vertex_of_[k / 3 * 3 + (k + 1) % 3];
    sides[k] = {std::min(a, b), std::max(a, b), k, a < b};
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.corner < b.corner;
  });
  edge_of_.resize(sides.size());
  opposite_.reserve(sides.size());
  other_begin_.assign(vertex_.size() + 1, 0);
  closed_ = true;
  std::vector<std::array<uint32_t, 2>> ends;
  for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    int balance = 0;
    opposite_begin_.push_back(static_cast<uint32_t>(opposite_.size()));
    for (; end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high;
         ++end) {
      const uint32_t corner = sides[end].corner;
      edge_of_[corner] = static_cast<uint32_t>(opposite_begin_.size() - 1);
      opposite_.push_back(vertex_of_[corner / 3 * 3 + (corner + 2) % 3]);
      balance += sides[end].forward ? 1 : -1;
    }
    closed_ = closed_ && end - begin == 2 && balance == 0;
    ends.push_back({sides[begin].low, sides[begin].high});
    ++other_begin_[sides[begin].low + 1];
    ++other_begin_[sides[begin].high + 1];
  }
  opposite_begin_.push_back(static_cast<uint32_t>(opposite_.size()));
  std::partial_sum(other_begin_.begin(), other_begin_.end(), other_begin_.begin());
  other_.resize(other_begin_.back());
  std::vector<uint32_t> at(other_begin_.begin(), other_begin_.end() - 1);
  for (const auto& [a, b] : ends) {
    other_[at[a]++] = b;
    other_[at[b]++] = a;
  }
}

void TriangleSurface::normals() {
  const size_t all = corner_.size() / 3;
  std::vector<dvec3> face(all, dvec3(0)), edge(opposite_begin_.size() - 1, dvec3(0)),
      vertex(vertex_.size(), dvec3(0));
  for (size_t t = 0; t < triangles_; ++t) {
    const dvec3 a(corner_[3 * t]), b(corner_[3 * t + 1]), c(corner_[3 * t + 2]);
    face[t] = unit(glm::cross(b - a, c - a));
    for (size_t e = 0; e < 3; ++e) edge[edge_of_[3 * t + e]] += face[t];
  }
  // A needle's own normal is chance: it stands for the triangles at its sides, and so do its sides.
  // A fan of needles takes as many rounds as there are between it and a triangle.
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds && triangles_ < all; ++round)
    for (size_t t = triangles_; t < all; ++t) {
      dvec3 sum(0);  // by length: the longest side is as long as the others together
      for (size_t e = 0; e < 3; ++e)
        sum += edge[edge_of_[3 * t + e]] *
               glm::length(dvec3(corner_[3 * t + e]) - dvec3(corner_[3 * t + (e + 1) % 3]));
      face[t] = unit(sum);
      for (size_t e = 0; e < 3; ++e) edge[edge_of_[3 * t + e]] = face[t];
    }
  for (size_t t = 0; t < all; ++t) {
    const dvec3 p[3] = {corner_[3 * t], corner_[3 * t + 1], corner_[3 * t + 2]};
    for (size_t c = 0; c < 3; ++c) {
      const dvec3 a = unit(p[(c + 1) % 3] - p[c]), b = unit(p[(c + 2) % 3] - p[c]);
      vertex[vertex_of_[3 * t + c]] += face[t] * std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
    }
  }
  // Where normals cancel (a fold closed on itself) any of them does.
  const auto shorten = [](const std::vector<dvec3>& sums, size_t count, std::vector<vec3>& out) {
    out.resize(count);
    for (size_t k = 0; k < count; ++k)
      out[k] = glm::dot(sums[k], sums[k]) > 1e-12 ? vec3(unit(sums[k])) : vec3(0);
  };
  shorten(face, triangles_, face_normal_);
  shorten(edge, edge.size(), edge_normal_);
  shorten(vertex, vertex.size(), vertex_normal_);
}

dvec3 TriangleSurface::outwardAt(uint32_t triangle, TriangleFeature feature) const {
  const size_t f = static_cast<size_t>(feature), at = 3 * size_t{triangle};
  vec3 outward = face_normal_[triangle];
  if (f >= 4) {
    outward = vertex_normal_[vertex_of_[at + f - 4]];
  } else if (f >= 1) {
    outward = edge_normal_[edge_of_[at + f - 1]];
  }
  return outward == vec3(0) ? face_normal_[triangle] : outward;
}

// How far from a point of the face its border is.
float TriangleSurface::flatAt(uint32_t triangle, const OnTriangle& on) const {
  if (on.feature != TriangleFeature::Face) return 0;
  const dvec3 normal(face_normal_[triangle]);
  double flat = std::numeric_limits<float>::max();
  for (size_t c = 0; c < 3; ++c) {
    const dvec3 a(corner_[3 * size_t{triangle} + c]), b(corner_[3 * size_t{triangle} + (c + 1) % 3]);
    flat = std::min(flat, glm::dot(unit(glm::cross(normal, b - a)), on.point - a));
  }
  return static_cast<float>(std::max(flat, 0.0));
}

TriangleSurface::Nearest TriangleSurface::nearest(vec3 p, double most) const {
  Nearest best{.square = std::numeric_limits<double>::infinity()};
  uint32_t found = 0;
  OnTriangle nearest;
  tree_.near(p, most * most, [&](uint32_t k, double& square) {
    const vec3* corner = &corner_[3 * size_t{k}];
    const OnTriangle on = nearestOnTriangle(p, corner[0], corner[1], corner[2]);
    const dvec3 d = dvec3(p) - on.point;
    const double now = glm::dot(d, d);
    if (!(now < square)) return;
    square = best.square = now;
    nearest = on;
    found = k;
  }, [](vec3, vec3) { return false; });
  if (best.square < std::numeric_limits<double>::infinity()) {
    best.point = nearest.point;
    best.outward = outwardAt(found, nearest.feature);
    best.flat = flatAt(found, nearest);
  }
  return best;
}

// Whether the distance grows from a point of a border, where p is `d` away, into all that meets there.
bool TriangleSurface::leastAround(uint32_t triangle, TriangleFeature feature, dvec3 d) const {
  constexpr double kAlong = 1e-6;  // sine of the angle that still counts as across
  const size_t f = static_cast<size_t>(feature), at = 3 * size_t{triangle};
  const auto towards = [&](dvec3 way) {
    return glm::dot(d, way) > kAlong * std::sqrt(glm::dot(d, d) * glm::dot(way, way));
  };
  if (f >= 4) {
    const uint32_t vertex = vertex_of_[at + f - 4];
    for (uint32_t k = other_begin_[vertex]; k < other_begin_[vertex + 1]; ++k)
      if (towards(dvec3(vertex_[other_[k]]) - dvec3(vertex_[vertex]))) return false;
  } else if (f >= 1) {
    const dvec3 a(corner_[at + f - 1]), b(corner_[at + f % 3]);
    const dvec3 along = unit(b - a);
    const uint32_t edge = edge_of_[at + f - 1];
    for (uint32_t k = opposite_begin_[edge]; k < opposite_begin_[edge + 1]; ++k) {
      const dvec3 into = dvec3(vertex_[opposite_[k]]) - a;
      if (towards(into - along * glm::dot(into, along))) return false;
    }
  }
  return true;
}

uint32_t TriangleSurface::touches(vec3 p, double reach, bool front, std::span<Nearest> out) const {
  constexpr double kSame = 0.9998;  // cosine of one degree: the same direction
  constexpr double kOnPlane = 1e-4;  // height over a plane that is none, as a share of the distance
  struct Touch {
    dvec3 direction;  // from the surface to p
    double square;
    uint32_t triangle;
    OnTriangle on;
  };
  constexpr uint32_t kMost = 16;
  Touch touch[kMost];
  uint32_t count = 0;
  tree_.near(p, reach * reach, [&](uint32_t k, double& most) {
    const vec3* corner = &corner_[3 * size_t{k}];
    const OnTriangle on = nearestOnTriangle(p, corner[0], corner[1], corner[2]);
    const dvec3 d = dvec3(p) - on.point;
    const double square = glm::dot(d, d);
    if (!(square < most) || !leastAround(k, on.feature, d)) return;
    if (front && glm::dot(d, outwardAt(k, on.feature)) < 0) return;
    const dvec3 direction = square > 0 ? unit(d) : dvec3(face_normal_[k]);
    // Kept nearest first; what follows from a nearer one goes.
    const Touch now{direction, square, k, on};
    const auto follows = [&](const Touch& farther, const Touch& nearer) {
      const double height = glm::dot(nearer.direction, farther.on.point - nearer.on.point);
      return height < kOnPlane * std::sqrt(farther.square) ||
             glm::dot(nearer.direction, farther.direction) > kSame;
    };
    uint32_t place = count;
    while (place > 0 && square < touch[place - 1].square) --place;
    if (place == kMost) return;
    for (uint32_t t = 0; t < place; ++t)
      if (follows(now, touch[t])) return;
    uint32_t stay = place;
    for (uint32_t t = place; t < count; ++t)
      if (!follows(touch[t], now)) touch[stay++] = touch[t];
    count = std::min(stay, kMost - 1);
    for (uint32_t t = count; t > place; --t) touch[t] = touch[t - 1];
    touch[place] = now;
    ++count;
  }, [&](vec3 low, vec3 high) {
    // All of the box lies behind the plane through the nearest touch.
    if (count == 0) return false;
    const Touch& first = touch[0];
    const dvec3 n = first.direction;
    const dvec3 top(n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y, n.z > 0 ? high.z : low.z);
    return glm::dot(n, top - first.on.point) < kOnPlane * std::sqrt(first.square);
  });
  count = std::min(count, static_cast<uint32_t>(out.size()));
  for (uint32_t t = 0; t < count; ++t)
    out[t] = {.point = touch[t].on.point,
              .square = touch[t].square,
              .outward = outwardAt(touch[t].triangle, touch[t].on.feature),
              .flat = flatAt(touch[t].triangle, touch[t].on)};
  return count;
}

size_t TriangleSurface::memoryBytes() const {
  return tree_.memoryBytes() +
         sizeof(vec3) * (corner_.capacity() + vertex_.capacity() + face_normal_.capacity() +
                         edge_normal_.capacity() + vertex_normal_.capacity()) +
         4 * (vertex_of_.capacity() + edge_of_.capacity() + opposite_begin_.capacity() +
              opposite_.capacity() + other_begin_.capacity() + other_.capacity());
}

}  // namespace scree::grains
