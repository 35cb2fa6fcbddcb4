// The one output of a pass that shades: the radiance target or, with DISPLAY, the display at once.
#include "lib/display.glsl"
#include "shared/gbuffer.h"

layout(location = 0) out vec4 shaded;

void writeShaded(vec3 radiance) {
  radiance = min(radiance, vec3(kMaxRadiance));
#ifdef DISPLAY
  shaded = displayed(radiance);
#else
  shaded = vec4(radiance, 1.0);
#endif
}
