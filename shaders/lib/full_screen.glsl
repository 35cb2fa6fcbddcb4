// A triangle that covers the screen at depth 0, the farthest; draws what passes compute per pixel.
// `ray`: from the camera through the pixel, 1 m along the view axis; relative space.
#include "shared/view.h"

out vec3 ray;

void coverScreen() {
  vec2 ndc = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 4.0 - 1.0;
  ray = rayFromNdc(view.relative_from_clip, ndc);
  gl_Position = vec4(ndc, 0.0, 1.0);
}
