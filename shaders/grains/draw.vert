// The tiles that grains may cover, at depth 0. `ray` as in lib/full_screen.glsl.
#include "shared/bindings.h"
#include "shared/cover.h"
#include "shared/view.h"

layout(std430, binding = kVisibleBinding) readonly buffer Spans { uint spans[]; };

out vec3 ray;

void main() {
  vec2 ndc = ndcFromPixel(view.size_px, coverCorner(spans[gl_VertexID / 6], uint(gl_VertexID % 6)));
  ray = rayFromNdc(view.relative_from_clip, ndc);
  gl_Position = vec4(ndc, 0.0, 1.0);
}
