// A tree of boxes around the triangles of a surface: which of them are near a point.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/math.h"

namespace scree::grains {

// Binary, each half of its node's triangles by the longest axis of their middles; 32 bytes a node.
// Which nodes are visited in which order depends on the point alone.
class TriangleTree {
 public:
  // Corners, three a triangle. Sets order(): triangle k of the tree is the order()[k]th given.
  void build(std::span<const vec3> corners);
  std::span<const uint32_t> order() const { return order_; }

  // Calls visit(k, most) for triangles k of the tree whose boxes are nearer to p than the root of
  // `most`, the nearest box first; visit may lower `most`, m^2. Boxes for which skip(low, high) holds
  // when their turn comes are passed over.
  template <class Visit, class Skip>
  void near(vec3 p, double most, const Visit& visit, const Skip& skip) const;

  vec3 low() const { return node_.empty() ? vec3(0) : node_[0].low; }
  vec3 high() const { return node_.empty() ? vec3(0) : node_[0].high; }
  size_t memoryBytes() const { return node_.capacity() * sizeof(Node) + 4 * order_.capacity(); }

 private:
  struct Node {
    vec3 low{0};
    uint32_t first = 0;  // triangle of a leaf; else the first of two children side by side
    vec3 high{0};
    uint32_t count = 0;  // triangles of a leaf; 0: not a leaf
  };
  static constexpr uint32_t kLeaf = 4;
  // Halving 2^32 triangles down to leaves of one takes 32 levels.
  static constexpr int kDepth = 40;

  // The square of the distance, or a little less: for its rounding.
  static double squareTo(const Node& node, vec3 p) {
    const auto away = [](float below, float above) { return std::max(std::max(below, above), 0.0f); };
    const float x = away(node.low.x - p.x, p.x - node.high.x), y = away(node.low.y - p.y, p.y - node.high.y),
                z = away(node.low.z - p.z, p.z - node.high.z);
    return static_cast<double>(0.999999f * (x * x + y * y + z * z));
  }

  std::vector<Node> node_;
  std::vector<uint32_t> order_;
};

template <class Visit, class Skip>
void TriangleTree::near(vec3 p, double most, const Visit& visit, const Skip& skip) const {
  if (node_.empty()) return;
  struct Entry {
    uint32_t node;
    double square;
  };
  Entry stack[kDepth + 1];
  int depth = 0;
  stack[depth++] = {0, squareTo(node_[0], p)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    const Node& node = node_[entry.node];
    if (!(entry.square < most) || skip(node.low, node.high)) continue;
    if (node.count > 0) {
      for (uint32_t k = 0; k < node.count; ++k) visit(node.first + k, most);
      continue;
    }
    const double a = squareTo(node_[node.first], p), b = squareTo(node_[node.first + 1], p);
    const uint32_t nearer = b < a ? 1 : 0;
    stack[depth++] = {node.first + 1 - nearer, nearer == 0 ? b : a};
    stack[depth++] = {node.first + nearer, nearer == 0 ? a : b};
  }
}

}  // namespace scree::grains
