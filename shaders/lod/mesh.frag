// Surface of a grain's mesh into the G-buffer: the shape's material, tinted. OVERDRAW: the attachment that counts.
#include "lib/gbuffer.glsl"
#include "shared/swarm.h"

layout(location = 0) uniform vec4 base_color;
layout(location = 1) uniform vec2 roughness_metallic;
layout(location = 2) uniform bool double_sided;
layout(binding = kBaseColorUnit) uniform sampler2D base_color_map;
layout(binding = kMetallicRoughnessUnit) uniform sampler2D metallic_roughness_map;

in vec3 normal_ws;
in vec2 uv_out;
flat in uint look;
flat in uint id;
flat in uint number;

layout(location = 4) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

#ifdef MOTION
in vec3 previous_clip;
#endif

void main() {
  vec2 map = texture(metallic_roughness_map, uv_out).gb;
  Surface s;
  s.albedo = base_color.rgb * texture(base_color_map, uv_out).rgb * tintOf(look);
  s.metallic = roughness_metallic.y * map.y;
  s.spread = 0.0;
  s.normal_ws = double_sided && !gl_FrontFacing ? -normal_ws : normal_ws;
  s.roughness = roughness_metallic.x * map.x * roughnessOf(look);
#ifdef MOTION
  s.motion_px = motionFromPrevious(previous_clip, gl_FragCoord.z);
#else
  s.motion_px = vec2(0.0);
#endif
  s.id = id;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
  writeGbuffer(s);
}
