// The marked tiles of the picture, six vertices each, at depth 0: call placeTile(). `ray` as in lib/full_screen.glsl.
#include "shared/bindings.h"
#include "shared/tiles.h"
#include "shared/view.h"

layout(std430, binding = kTilesBinding) readonly buffer Tiles {
  TileCommands tile_commands;
  uint marked[];
};

out vec3 ray;

void placeTile() {
  int tile = gl_VertexID / 6, columns = tileCount(ivec2(view.size_px)).x;
  vec2 px = tileCorner(ivec2(tile % columns, tile / columns), uint(gl_VertexID % 6));
  vec2 ndc = ndcFromPixel(view.size_px, px);
  ray = rayFromNdc(view.relative_from_clip, ndc);
  gl_Position = marked[tile] != 0u ? vec4(ndc, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
