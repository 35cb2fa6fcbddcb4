// Marks the tiles that what is drawn may touch: see shared/tiles.h.
#include "shared/bindings.h"
#include "shared/tiles.h"
#include "shared/view.h"

layout(std430, binding = kTilesBinding) buffer Tiles {
  TileCommands tile_commands;
  uint marked[];
};

// Pixels first_px to last_px; what lies beyond the picture is left out.
void markTiles(ivec2 first_px, ivec2 last_px) {
  ivec2 size = ivec2(view.size_px), columns = tileCount(size);
  ivec2 first = max(first_px, ivec2(0)) / kTilePx, last = min(last_px, size - 1);
  if (any(lessThan(last, ivec2(0)))) return;
  last /= kTilePx;
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      int at = y * columns.x + x;
      if (marked[at] != 0u) continue;
      marked[at] = 1u;
      // The same by all who write it.
      uint tiles = uint(columns.x * columns.y);
      tile_commands.vertices = 6u * tiles;
      tile_commands.groups[0] = tiles;
    }
}
