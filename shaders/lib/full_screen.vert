// The triangle of full_screen.glsl, and nothing else.
#include "lib/full_screen.glsl"

void main() { coverScreen(); }
