// The marked tiles of the picture.
#include "lib/tiles.glsl"

void main() { placeTile(); }
