// Which small grain a pixel shows: coverage in one view. OVERDRAW: the attachment that counts.
#include "impostors/coverage.glsl"

flat in vec4 middle_px;
flat in vec3 inside;
flat in vec4 at_of_px;
flat in vec3 from_steps;
flat in uint number;

layout(location = 0) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

void main() {
  vec2 off = gl_FragCoord.xy - middle_px.zw, from_grain = gl_FragCoord.xy - middle_px.xy;
  if (dot(inside, vec3(off.x * off.x, off.x * off.y, off.y * off.y)) > 1.0) discard;
  vec2 at = at_of_px.xy * from_grain.x + at_of_px.zw * from_grain.y + 0.5 * from_steps.z;
  if (coverageAt(at, from_steps.z, from_steps.xy) < 0.5) discard;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
}
