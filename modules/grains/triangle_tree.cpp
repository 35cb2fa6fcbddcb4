// Building a tree of boxes around triangles.
#include "modules/grains/triangle_tree.h"

#include <glm/common.hpp>

#include <algorithm>
#include <numeric>

namespace scree::grains {

void TriangleTree::build(std::span<const vec3> corners) {
  const uint32_t count = static_cast<uint32_t>(corners.size() / 3);
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  node_.clear();
  if (count == 0) return;
  node_.reserve(size_t{count});
  std::vector<vec3> middle(count);
  for (size_t k = 0; k < count; ++k)
    middle[k] = (corners[3 * k] + corners[3 * k + 1] + corners[3 * k + 2]) * (1.0f / 3);

  struct Task {
    uint32_t node, begin, end;
  };
  std::vector<Task> tasks{{0, 0, count}};
  node_.emplace_back();
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    vec3 low(corners[3 * size_t{order_[task.begin]}]), high(low);
    vec3 from(middle[order_[task.begin]]), to(from);
    for (uint32_t k = task.begin; k < task.end; ++k) {
      const size_t triangle = order_[k];
      for (size_t corner = 0; corner < 3; ++corner) {
        low = glm::min(low, corners[3 * triangle + corner]);
        high = glm::max(high, corners[3 * triangle + corner]);
      }
      from = glm::min(from, middle[triangle]);
      to = glm::max(to, middle[triangle]);
    }
    node_[task.node].low = low;
    node_[task.node].high = high;
    if (task.end - task.begin <= kLeaf) {
      // The halves are sets that do not depend on the library; the order in a leaf shall not either.
      std::sort(order_.begin() + task.begin, order_.begin() + task.end);
      node_[task.node].first = task.begin;
      node_[task.node].count = task.end - task.begin;
      continue;
    }
    const vec3 size = to - from;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t half = task.begin + (task.end - task.begin) / 2;
    std::nth_element(order_.begin() + task.begin, order_.begin() + half, order_.begin() + task.end,
                     [&](uint32_t a, uint32_t b) {
                       return middle[a][axis] != middle[b][axis] ? middle[a][axis] < middle[b][axis]
                                                                 : a < b;
                     });
    const uint32_t children = static_cast<uint32_t>(node_.size());
    node_[task.node].first = children;
    node_.resize(node_.size() + 2);
    tasks.push_back({children + 1, half, task.end});
    tasks.push_back({children, task.begin, half});
  }
}

}  // namespace scree::grains
