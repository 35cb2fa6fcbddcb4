// No tile is marked: a group a tile.
#include "lib/empty_tiles.glsl"

layout(local_size_x = 1) in;

void main() { emptyTile(); }
