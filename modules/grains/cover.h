// Which parts of the picture grains may cover, so that only these are resolved.
#pragma once

#include <cstdint>
#include <vector>

#include "modules/scene/scene.h"

namespace scree::grains {

// A grid of square tiles over the picture, marked by the spheres seen in it.
class Cover {
 public:
  // Unmarks all tiles of the view's picture.
  void reset(const View& view);
  // Marks every tile that a sphere in front of the eye may touch: no pixel of its silhouette lies
  // outside; the bound is the sphere's box along the view's axes. A sphere that reaches behind the
  // eye marks all. `center`: relative to the camera.
  void add(const vec3& center, float radius);
  // The marked tiles, neighbours of a row joined: rules::packCoverSpan().
  void spans(std::vector<uint32_t>& out) const;

 private:
  ivec2 tiles_{0, 0};
  vec2 tiles_per_ndc_{0, 0};  // half the picture's size, in tiles
  vec4 row_x_{0}, row_y_{0}, row_w_{0};  // of clip_from_relative
  float length_x_ = 0, length_y_ = 0;    // of their normals
  std::vector<uint8_t> marked_;
};

}  // namespace scree::grains
