// The sky where nothing was drawn.
#include "shared/gbuffer.h"
#include "shared/lighting.h"

in vec3 ray;
layout(location = 0) out vec4 radiance;

void main() {
  radiance = vec4(min(skyRadiance(lighting.sky, normalize(ray).y), vec3(kMaxRadiance)), 1.0);
}
