// Which small grain a pixel shows: coverage in one view. OVERDRAW: the attachment that counts.
#include "impostors/atlas.glsl"

flat in vec4 middle_px;
flat in vec3 inside;
flat in vec4 uv_of_px;
flat in vec2 layer_level;
flat in uint number;

layout(location = 0) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

void main() {
  vec2 off = gl_FragCoord.xy - middle_px.zw, from_grain = gl_FragCoord.xy - middle_px.xy;
  if (dot(inside, vec3(off.x * off.x, off.x * off.y, off.y * off.y)) > 1.0) discard;
  vec2 uv = uv_of_px.xy * from_grain.x + uv_of_px.zw * from_grain.y + 0.5;
  if (textureLod(atlas_shape, vec3(uv, layer_level.x), layer_level.y).r < 0.5) discard;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
}
