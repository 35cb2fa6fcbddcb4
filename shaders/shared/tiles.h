// Square tiles of the picture, marked by programs that draw into them, drawn and emptied by those that follow: what
// nothing was drawn in costs nothing, and where nothing was drawn at all, nothing runs.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

const int kTilePx = 32;

// std430, before the marks: what draws the tiles and what empties them; nothing of both until a tile is marked.
struct TileCommands {
  uint vertices;  // six a tile
  uint instances;
  uint first;
  uint base_instance;
  uint groups[3];  // a tile each
  uint unused;
};

RULE ivec2 tileCount(ivec2 size_px) { return (size_px + (kTilePx - 1)) / kTilePx; }

// Corner 0 to 5 of a tile's two triangles, pixels.
RULE vec2 tileCorner(ivec2 tile, uint corner) {
  bool right = corner == 1u || corner == 2u || corner == 4u;
  bool upper = corner == 2u || corner == 4u || corner == 5u;
  return vec2(float(right ? tile.x + 1 : tile.x), float(upper ? tile.y + 1 : tile.y)) * float(kTilePx);
}

RULES_END
