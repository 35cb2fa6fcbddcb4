// Spheres near a small part of space, for the question whether a place there is free.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/math.h"

namespace scree::grains {

class Crowd {
 public:
  // Empties it. Places will be asked for in the box [low, high], of radii up to `largest`.
  void reset(vec3 low, vec3 high, float largest);
  // Takes a sphere in, unless it is too far to be met by any that is asked for.
  void add(vec3 position, float radius);
  // Whether a sphere in the box would overlap none.
  bool free(vec3 position, float radius) const;

 private:
  // Cells of the box along an axis, at most.
  static constexpr int kMostCells = 32;
  struct Node {
    vec3 position;
    float radius;
    uint32_t next;
  };
  int cellAlong(int axis, float x) const;

  vec3 low_{0}, high_{0}, inverse_cell_{0};
  float largest_ = 0;
  int cells_[3] = {1, 1, 1};
  std::vector<uint32_t> first_;  // by cell, node
  std::vector<Node> node_;       // of each sphere one a cell that it reaches, with `largest_` around it
};

}  // namespace scree::grains
