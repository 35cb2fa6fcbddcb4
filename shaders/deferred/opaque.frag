// Metallic-roughness surfaces of glTF 2.0 into the G-buffer.
// Defines: BASE_COLOR_MAP, METALLIC_ROUGHNESS_MAP, NORMAL_MAP, EMISSIVE_MAP (what the material has;
// any of them: TEXTURED), EMISSION, ALPHA_MASK, DOUBLE_SIDED; MOTION: somebody reads it.
#include "lib/gbuffer.glsl"
#include "shared/mesh_instance.h"

layout(std140, binding = kDrawBinding) uniform MaterialUniforms { MaterialConstants material; };
#ifdef BASE_COLOR_MAP
layout(binding = kBaseColorUnit) uniform sampler2D base_color_map;
#endif
#ifdef METALLIC_ROUGHNESS_MAP
layout(binding = kMetallicRoughnessUnit) uniform sampler2D metallic_roughness_map;
#endif
#ifdef NORMAL_MAP
layout(binding = kNormalMapUnit) uniform sampler2D normal_map;
#endif
#ifdef EMISSIVE_MAP
layout(binding = kEmissiveMapUnit) uniform sampler2D emissive_map;
#endif

in vec3 normal_ws;
#ifdef MOTION
in vec3 previous_clip;
#endif
#ifdef NORMAL_MAP
in vec4 tangent_ws;
#endif
#ifdef TEXTURED
in vec2 uv_out;
#endif
flat in uint id;
flat in uint mirrored;

void main() {
  Surface s;
  vec4 base_color = material.base_color;
#ifdef BASE_COLOR_MAP
  base_color *= texture(base_color_map, uv_out);
#endif
#ifdef ALPHA_MASK
  if (base_color.a < material.alpha_cutoff) discard;
#endif
  s.albedo = base_color.rgb;
  s.metallic = material.metallic;
  s.roughness = material.roughness;
#ifdef METALLIC_ROUGHNESS_MAP
  vec2 roughness_metallic = texture(metallic_roughness_map, uv_out).gb;
  s.roughness *= roughness_metallic.x;
  s.metallic *= roughness_metallic.y;
#endif
#ifdef EMISSION
  s.emissive = material.emissive.rgb;
#ifdef EMISSIVE_MAP
  s.emissive *= texture(emissive_map, uv_out).rgb;
#endif
#endif
  vec3 n = normal_ws;
#ifdef NORMAL_MAP
  // The basis is not normalised again after interpolation (MikkTSpace).
  vec3 bitangent = tangent_ws.w * cross(normal_ws, tangent_ws.xyz);
  vec3 m = texture(normal_map, uv_out).xyz * 2.0 - 1.0;
  m.xy *= material.normal_scale;
  n = m.x * tangent_ws.xyz + m.y * bitangent + m.z * normal_ws;
#endif
#ifdef DOUBLE_SIDED
  // The rasteriser sees a mirrored mesh's triangles wound the other way round.
  if (gl_FrontFacing == (mirrored != 0u)) n = -n;
#endif
  s.spread = 0.0;
  s.normal_ws = n;
#ifdef MOTION
  s.motion_px = motionFromPrevious(previous_clip, gl_FragCoord.z);
#else
  s.motion_px = vec2(0.0);
#endif
  s.id = id;
  writeGbuffer(s);
}
