// What the drawing of grains keeps between frames, and what the upload hands to the passes.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/ecs/query.h"
#include "engine/gpu/stream.h"
#include "modules/grains/cover.h"
#include "modules/grains/grains.h"

namespace scree::grains {

// Target of grains.visible: index + 1 of the record that a pixel shows.
inline constexpr const char* kVisibleTarget = "grains.visible";
// Up to this many grains cast shadows as spheres of their own; of more, groups of
// kCasterGroup neighbours in the table share one.
inline constexpr size_t kLoneCasters = 8192, kCasterGroup = 64;

using DrawnQuery = Query<const Grain, const GrainPrevious, const GrainOrientation, const GrainSpin,
                         const GrainLook>;

// What the depths that grains.shadow draws depend on, beside the map's place.
struct Cast {
  Version records = 0;
  size_t count = 0;
  dvec3 origin{0}, camera{0};
  float alpha = 1;  // 1 if no grain moves
  bool operator==(const Cast&) const = default;
};

struct DrawState {
  DrawnQuery drawn;
  Version uploaded = 0;  // of the columns in `records`
  gpu::StreamBuffer record_stream{"grains.records", 1 << 20};  // moves on only when grains moved
  gpu::StreamBuffer frame_stream{"grains.frame", 64 * 1024};
  gpu::StreamSlice records, frame, visible, spans;
  Cast cast;
  uint64_t cast_version = 0;  // goes up when it changes
  Cover cover;                          // of the grains in view
  std::vector<uint32_t> covered_spans;  // its tiles: what grains.draw looks at
  uint32_t count = 0;          // grains
  uint32_t visible_count = 0;  // grains in view
  uint32_t near_count = 0;     // of these, the last ones in `visible`: may cross the near plane
  // Working memory: the grains in view, nearest first.
  std::vector<uint32_t> in_view, at_near_plane, ordered, bucket;
  std::vector<float> distance;
};

}  // namespace scree::grains
