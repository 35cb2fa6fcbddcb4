// Takes the mark of the tile of this work group back, and with the first tile what the commands say.
#include "shared/bindings.h"
#include "shared/tiles.h"

layout(std430, binding = kTilesBinding) buffer Tiles {
  TileCommands tile_commands;
  uint marked[];
};

void emptyTile() {
  if (gl_LocalInvocationIndex != 0u) return;
  uint tile = gl_WorkGroupID.x;
  if (marked[tile] != 0u) marked[tile] = 0u;
  if (tile != 0u) return;
  tile_commands.vertices = 0u;
  tile_commands.groups[0] = 0u;
}
