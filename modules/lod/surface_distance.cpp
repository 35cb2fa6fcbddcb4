// Triangles are halved until the most that a point of one can be off is known.
#include "modules/lod/surface_distance.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/assets/nearest_on_triangle.h"

namespace scree {
namespace {

using Triangle = std::array<dvec3, 3>;

struct Ball {
  dvec3 middle{0};
  double radius = 0;
};
Ball ballOf(const Triangle& t) {
  Ball ball{(t[0] + t[1] + t[2]) / 3.0, 0};
  for (const dvec3& corner : t) ball.radius = std::max(ball.radius, glm::length(corner - ball.middle));
  return ball;
}
struct Target {
  Triangle corners;
  Ball ball;
};
// Triangles that follow each other lie together, mostly: a block is passed over as a whole.
constexpr size_t kBlock = 24;

std::vector<Triangle> trianglesOf(std::span<const MeshData> parts) {
  std::vector<Triangle> triangles;
  for (const MeshData& part : parts)
    for (size_t k = 0; k + 2 < part.indices.size(); k += 3) {
      const auto corner = [&](size_t at) { return dvec3(part.vertices[part.indices[k + at]].position); };
      triangles.push_back({corner(0), corner(1), corner(2)});
    }
  return triangles;
}

std::vector<Target> targetsOf(std::span<const MeshData> parts) {
  std::vector<Target> targets;
  for (const Triangle& t : trianglesOf(parts)) {
    if (glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) < 1e-30) continue;
    targets.push_back({t, ballOf(t)});
  }
  return targets;
}

std::vector<Ball> blocksOf(std::span<const Target> targets) {
  std::vector<Ball> blocks;
  for (size_t first = 0; first < targets.size(); first += kBlock) {
    const auto block = targets.subspan(first, std::min(kBlock, targets.size() - first));
    Ball ball;
    for (const Target& t : block) ball.middle += t.ball.middle / static_cast<double>(block.size());
    for (const Target& t : block) ball.radius = std::max(ball.radius, glm::length(t.ball.middle - ball.middle) + t.ball.radius);
    blocks.push_back(ball);
  }
  return blocks;
}

struct Search {
  std::vector<Target> targets;
  std::vector<Ball> blocks = blocksOf(targets);
  double found = 0;  // a distance that some point has
  double bound = 0;  // what none exceeds
  double least = 0;  // halves of what is known so well are of no use

  struct Nearest {
    double distance;
    const Target* target;
  };
  static double distance2(const dvec3& p, const Target& t) {
    const dvec3 off = p - nearestOnTriangle(p, t.corners[0], t.corners[1], t.corners[2]).point;
    return glm::dot(off, off);
  }
  Nearest nearest(const dvec3& p, const Target* guess) const {
    const Target* best = guess;
    double least2 = distance2(p, *guess), room = std::sqrt(least2);
    const auto reaches = [&](const Ball& ball) {
      const dvec3 to = p - ball.middle;
      const double reach = room + ball.radius;
      return glm::dot(to, to) <= reach * reach;
    };
    for (size_t block = 0; block < blocks.size(); ++block) {
      if (!reaches(blocks[block])) continue;
      for (size_t k = block * kBlock; k < std::min((block + 1) * kBlock, targets.size()); ++k) {
        if (!reaches(targets[k].ball)) continue;
        if (const double d2 = distance2(p, targets[k]); d2 < least2) {
          least2 = d2;
          room = std::sqrt(d2);
          best = &targets[k];
        }
      }
    }
    return {std::sqrt(least2), best};
  }
  void visit(const Triangle& t, int halvings, const Target* guess) {
    const auto [here, target] = nearest((t[0] + t[1] + t[2]) / 3.0, guess);
    found = std::max(found, here);
    // The distance from one triangle is convex, so that it is largest at a corner.
    double most = 0;
    for (const dvec3& corner : t) most = std::max(most, std::sqrt(distance2(corner, *target)));
    if (most <= std::max({bound, found * 1.05, found + least}) || halvings == 0) {
      bound = std::max(bound, most);
      return;
    }
    size_t longest = 0;
    for (size_t k = 1; k < 3; ++k)
      if (glm::length(t[(k + 1) % 3] - t[k]) > glm::length(t[(longest + 1) % 3] - t[longest])) longest = k;
    const size_t a = longest, b = (longest + 1) % 3, c = (longest + 2) % 3;
    const dvec3 cut = 0.5 * (t[a] + t[b]);
    visit({t[a], cut, t[c]}, halvings - 1, target);
    visit({cut, t[b], t[c]}, halvings - 1, target);
  }
};

double oneWay(std::span<const MeshData> from, std::span<const MeshData> to, double least) {
  constexpr int kHalvings = 24;
  const std::vector<Triangle> triangles = trianglesOf(from);
  Search search{.targets = targetsOf(to), .least = least};
  if (search.targets.empty() || triangles.empty()) return 0;
  const double pairs = static_cast<double>(triangles.size()) * static_cast<double>(search.targets.size());
  if (pairs > kMostPairs) {
    const auto stride = static_cast<size_t>(pairs / kMostPairs) + 1;
    for (size_t k = 0; k < triangles.size(); k += stride)
      for (const dvec3& p : {triangles[k][0], (triangles[k][0] + triangles[k][1] + triangles[k][2]) / 3.0})
        search.found = std::max(search.found, search.nearest(p, search.targets.data()).distance);
    return 1.25 * search.found;
  }
  const Target* guess = search.targets.data();
  for (const Triangle& t : triangles) {
    const Search::Nearest middle = search.nearest((t[0] + t[1] + t[2]) / 3.0, guess);
    search.found = std::max(search.found, middle.distance);
    guess = middle.target;
  }
  for (const Triangle& t : triangles) search.visit(t, kHalvings, guess);
  return search.bound;
}

}  // namespace

double surfaceDistance(std::span<const MeshData> a, std::span<const MeshData> b) {
  dvec3 low(1e300), high(-1e300);
  for (const Triangle& t : trianglesOf(a))
    for (const dvec3& p : t) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  const double least = 1e-4 * std::max({high.x - low.x, high.y - low.y, high.z - low.z, 0.0});
  return std::max(oneWay(a, b, least), oneWay(b, a, least));
}

}  // namespace scree
