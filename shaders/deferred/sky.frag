// The sky where nothing was drawn. Defines: DISPLAY (see lib/shaded.glsl).
#include "lib/shaded.glsl"
#include "shared/lighting.h"

in vec3 ray;

void main() { writeShaded(skyRadiance(lighting.sky, normalize(ray).y)); }
