// Quickhull in double precision.
#include "modules/grains/hull.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace scree::grains {
namespace {

constexpr uint32_t kNone = 0xffffffffu;

struct Face {
  std::array<uint32_t, 3> vertex{};
  std::array<uint32_t, 3> across{};  // the face at the edge from vertex k to vertex k + 1
  dvec3 normal{0};
  double offset = 0;
  std::vector<uint32_t> outside;  // points in front of this face that no face before it has
  uint32_t farthest = kNone;
  double distance = 0;  // of the farthest
  bool gone = false;
  uint32_t seen = 0;  // the round in which it was last looked at
};

class Quickhull {
 public:
  explicit Quickhull(std::span<const vec3> points) : point_(points.begin(), points.end()) {}

  bool run() {
    if (!start()) return false;
    while (!pending_.empty()) {
      const uint32_t face = pending_.back();
      pending_.pop_back();
      if (!face_[face].gone && face_[face].farthest != kNone) addPoint(face);
    }
    return true;
  }

  void write(std::vector<vec3>& corners) const {
    for (const Face& face : face_)
      if (!face.gone)
        for (const uint32_t vertex : face.vertex) corners.push_back(vec3(point_[vertex]));
  }

 private:
  // A tetrahedron of points far from each other; false if there is none.
  bool start() {
    if (point_.size() < 4) return false;
    dvec3 most(0);
    std::array<uint32_t, 6> extreme{};
    for (uint32_t k = 0; k < point_.size(); ++k) {
      most = glm::max(most, glm::abs(point_[k]));
      for (int axis = 0; axis < 3; ++axis) {
        const size_t at = 2 * static_cast<size_t>(axis);
        if (point_[k][axis] < point_[extreme[at]][axis]) extreme[at] = k;
        if (point_[k][axis] > point_[extreme[at + 1]][axis]) extreme[at + 1] = k;
      }
    }
    // Of a plane's offset by three points of this size, with some room.
    tolerance_ = 16 * std::numeric_limits<double>::epsilon() * (most.x + most.y + most.z);
    std::array<uint32_t, 4> v{};
    double best = 0;
    for (const uint32_t a : extreme)
      for (const uint32_t b : extreme) {
        const double square = glm::dot(point_[a] - point_[b], point_[a] - point_[b]);
        if (square > best) {
          best = square;
          v[0] = a;
          v[1] = b;
        }
      }
    const double size = std::sqrt(best);
    // Thinner than float coordinates can tell is flat.
    const double thin = 1e-6 * size;
    if (!(size > 0)) return false;
    const dvec3 along = (point_[v[1]] - point_[v[0]]) / size;
    best = 0;
    for (uint32_t k = 0; k < point_.size(); ++k) {
      const double away = glm::length(glm::cross(point_[k] - point_[v[0]], along));
      if (away > best) {
        best = away;
        v[2] = k;
      }
    }
    if (!(best > thin)) return false;
    const dvec3 normal = glm::normalize(glm::cross(along, point_[v[2]] - point_[v[0]]));
    best = 0;
    for (uint32_t k = 0; k < point_.size(); ++k) {
      const double away = std::abs(glm::dot(point_[k] - point_[v[0]], normal));
      if (away > best) {
        best = away;
        v[3] = k;
      }
    }
    if (!(best > thin)) return false;
    if (glm::dot(point_[v[3]] - point_[v[0]], normal) > 0) std::swap(v[0], v[1]);
    // The fourth is behind the face of the first three.
    constexpr std::array<std::array<uint32_t, 3>, 4> kFaces{{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
    for (const auto& f : kFaces) addFace({v[f[0]], v[f[1]], v[f[2]]});
    face_[0].across = {1, 2, 3};
    face_[1].across = {3, 2, 0};
    face_[2].across = {1, 3, 0};
    face_[3].across = {2, 1, 0};
    for (uint32_t k = 0; k < point_.size(); ++k) give(k, 0, 4);
    for (uint32_t f = 0; f < 4; ++f) pending_.push_back(f);
    return true;
  }

  uint32_t addFace(std::array<uint32_t, 3> vertex) {
    Face face;
    face.vertex = vertex;
    const dvec3 a = point_[vertex[0]], b = point_[vertex[1]], c = point_[vertex[2]];
    const dvec3 cross = glm::cross(b - a, c - a);
    const double length = glm::length(cross);
    face.normal = length > 0 ? cross / length : dvec3(0);  // a sliver that sees nothing
    face.offset = glm::dot(face.normal, (a + b + c) / 3.0);
    face_.push_back(std::move(face));
    return static_cast<uint32_t>(face_.size() - 1);
  }

  double above(const Face& face, uint32_t k) const {
    return glm::dot(face.normal, point_[k]) - face.offset;
  }

  // Gives a point to the face of [begin, end) that it is farthest in front of.
  void give(uint32_t k, uint32_t begin, uint32_t end) {
    uint32_t to = kNone;
    double most = tolerance_;
    for (uint32_t f = begin; f < end; ++f) {
      const double height = above(face_[f], k);
      if (height > most) {
        most = height;
        to = f;
      }
    }
    if (to == kNone) return;
    Face& face = face_[to];
    face.outside.push_back(k);
    if (most > face.distance) {
      face.distance = most;
      face.farthest = k;
    }
  }

  // The faces that the point sees, from `face` on, and their border, in its order around them.
  void findHorizon(uint32_t face, uint32_t point) {
    struct Step {
      uint32_t face, edge, left;
    };
    visible_.clear();
    horizon_.clear();
    ++round_;
    std::vector<Step> steps{{face, 0, 3}};
    face_[face].seen = round_;
    face_[face].gone = true;
    visible_.push_back(face);
    while (!steps.empty()) {
      Step& step = steps.back();
      if (step.left == 0) {
        steps.pop_back();
        continue;
      }
      const uint32_t from = step.face, edge = step.edge;
      step.edge = (step.edge + 1) % 3;
      --step.left;
      const uint32_t next = face_[from].across[edge];
      if (face_[next].gone && face_[next].seen == round_) continue;
      if (above(face_[next], point) <= tolerance_) {
        horizon_.push_back({from, edge});
        continue;
      }
      face_[next].seen = round_;
      face_[next].gone = true;
      visible_.push_back(next);
      uint32_t back = 0;
      while (face_[next].across[back] != from ||
             face_[next].vertex[back] != face_[from].vertex[(edge + 1) % 3])
        ++back;
      steps.push_back({next, (back + 1) % 3, 2});
    }
  }

  void addPoint(uint32_t face) {
    const uint32_t point = face_[face].farthest;
    findHorizon(face, point);
    const uint32_t begin = static_cast<uint32_t>(face_.size());
    const uint32_t count = static_cast<uint32_t>(horizon_.size());
    for (uint32_t k = 0; k < count; ++k) {
      const auto [from, edge] = horizon_[k];
      const uint32_t a = face_[from].vertex[edge], b = face_[from].vertex[(edge + 1) % 3];
      const uint32_t beyond = face_[from].across[edge];
      const uint32_t made = addFace({a, b, point});
      face_[made].across = {beyond, begin + (k + 1) % count, begin + (k + count - 1) % count};
      for (uint32_t e = 0; e < 3; ++e)
        if (face_[beyond].across[e] == from && face_[beyond].vertex[e] == b) face_[beyond].across[e] = made;
    }
    for (const uint32_t gone : visible_) {
      std::vector<uint32_t> homeless;
      homeless.swap(face_[gone].outside);
      for (const uint32_t k : homeless)
        if (k != point) give(k, begin, begin + count);
    }
    for (uint32_t k = 0; k < count; ++k) pending_.push_back(begin + k);
  }

  std::vector<dvec3> point_;
  std::vector<Face> face_;
  std::vector<uint32_t> pending_, visible_;
  std::vector<std::pair<uint32_t, uint32_t>> horizon_;  // face, edge
  double tolerance_ = 0;
  uint32_t round_ = 0;
};

}  // namespace

std::string convexHull(std::span<const vec3> points, std::vector<vec3>& corners) {
  corners.clear();
  for (const vec3 p : points)
    if (!std::isfinite(p.x + p.y + p.z)) return "a point is not finite";
  std::vector<vec3> distinct(points.begin(), points.end());
  const auto before = [](vec3 a, vec3 b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::sort(distinct.begin(), distinct.end(), before);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  if (distinct.size() > kMostHullPoints)
    return fmt::format("it has {} points; allowed are {}", distinct.size(), kMostHullPoints);
  Quickhull hull(distinct);
  if (!hull.run())
    return fmt::format("its {} points lie in a plane, or nearly: a hull needs a volume", distinct.size());
  hull.write(corners);
  return {};
}

}  // namespace scree::grains
