// Forgets what the frame knew by pixel in the marked tiles, and their marks: a group a tile. IDS: the ids, too.
#include "lib/empty_tiles.glsl"
#include "shared/points.h"
#include "shared/view.h"

layout(local_size_x = kTilePx, local_size_y = 8) in;

layout(std430, binding = kPointKeysBinding) writeonly buffer Keys { uint keys[]; };
layout(std430, binding = kPointForemostBinding) writeonly buffer ForemostPoints { uint foremost[]; };
#ifdef IDS
layout(std430, binding = kPointIdsBinding) writeonly buffer Ids { uint ids[]; };
#endif

void main() {
  ivec2 size = ivec2(view.size_px);
  int tile = int(gl_WorkGroupID.x), columns = tileCount(size).x;
  ivec2 pixel = ivec2(tile % columns, tile / columns) * kTilePx + ivec2(gl_LocalInvocationID.xy);
  int end = marked[tile] != 0u && pixel.x < size.x ? min((tile / columns + 1) * kTilePx, size.y) : 0;
  for (; pixel.y < end; pixel.y += int(gl_WorkGroupSize.y)) {
    uint at = uint(pixel.y) * uint(size.x) + uint(pixel.x);
    keys[at] = 0u;
    foremost[at] = 0u;
#ifdef IDS
    ids[at] = 0u;
#endif
  }
  barrier();
  emptyTile();
}
