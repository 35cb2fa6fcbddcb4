// The G-buffer: the one place that writes and reads its targets. Formats and meaning: see
// shared/gbuffer.h.
//
// A fragment shader that draws a surface includes this file and calls writeGbuffer() once; depth is
// gl_FragCoord.z or, for analytic surfaces, gl_FragDepth. One that also writes emission, in the pass
// for that, defines EMISSION before the include. One that shades defines GBUFFER_READ before the
// include and calls readGbuffer().
#include "shared/bindings.h"
#include "shared/gbuffer.h"
#include "shared/octahedral.h"
#include "shared/view.h"

struct Surface {
  vec3 albedo;       // base colour, linear, [0, 1]
  float metallic;    // [0, 1]
  vec3 normal_ws;    // towards the viewer's side of the surface; any length
  float roughness;   // perceptual, [0, 1]; without what spread adds
  float spread;      // of the normals under the pixel, shared/spread.h; not 0: the pass writes gbuffer.spread
  vec3 emissive;     // radiance, >= 0; written by EMISSION only
  vec2 motion_px;    // motionFromPrevious()
  uint id;           // entity index + 1
};

#ifdef GBUFFER_READ
layout(binding = kGbufferAlbedoUnit) uniform sampler2D gbuffer_albedo;
layout(binding = kGbufferNormalUnit) uniform sampler2D gbuffer_normal;
layout(binding = kGbufferEmissiveUnit) uniform sampler2D gbuffer_emissive;
layout(binding = kGbufferDepthUnit) uniform sampler2D gbuffer_depth;
#ifdef GBUFFER_READ_MOTION
layout(binding = kGbufferMotionUnit) uniform sampler2D gbuffer_motion;
#endif
#ifdef GBUFFER_READ_ID
layout(binding = kGbufferIdUnit) uniform usampler2D gbuffer_id;
#endif

float gbufferDepth(ivec2 pixel) { return texelFetch(gbuffer_depth, pixel, 0).r; }

// Motion and id are zero unless GBUFFER_READ_MOTION, GBUFFER_READ_ID are defined: what is not
// needed is not fetched, and its sampler need not be bound. GBUFFER_READ_SPREAD: some surface may have
// a spread.
Surface readGbuffer(ivec2 pixel) {
  vec4 albedo = texelFetch(gbuffer_albedo, pixel, 0);
  vec4 normal = texelFetch(gbuffer_normal, pixel, 0);
  Surface s;
  s.albedo = albedoFromCode(albedo.rgb);
#ifdef GBUFFER_READ_SPREAD
  MetallicSpread code = metallicSpreadFromCode(albedo.a);
  s.metallic = code.metallic;
  s.spread = spreadFromCode(code.spread);
#else
  s.metallic = metallicFromCode(albedo.a);
  s.spread = 0.0;
#endif
  s.normal_ws = octDecode(octUnpack24(normal.rgb));
  s.roughness = normal.a;
  s.emissive = texelFetch(gbuffer_emissive, pixel, 0).rgb;
  s.motion_px = vec2(0.0);
  s.id = 0u;
#ifdef GBUFFER_READ_MOTION
  s.motion_px = texelFetch(gbuffer_motion, pixel, 0).rg;
#endif
#ifdef GBUFFER_READ_ID
  s.id = texelFetch(gbuffer_id, pixel, 0).r;
#endif
  return s;
}
#else
layout(location = 0) out vec4 gbuffer_albedo;
layout(location = 1) out vec4 gbuffer_normal;
layout(location = 2) out vec2 gbuffer_motion;
layout(location = 3) out uint gbuffer_id;
#ifdef EMISSION
layout(location = 4) out vec3 gbuffer_emissive;
#endif

// Motion of this fragment. `previous_clip`: clip-space x, y, w of the same surface point one frame
// ago, by view.previous_clip_from_relative (interpolated; it need not be in front of the camera).
// `depth`: what is written as this fragment's depth.
vec2 motionFromPrevious(vec3 previous_clip, float depth) {
  return motionPx(gl_FragCoord.xy + view.jitter_px, view.near_m / max(depth, 1e-30), previous_clip,
                  view.size_px, view.near_m);
}

// Writes the color targets. Values out of range are clamped, so that no later pass meets a NaN.
void writeGbuffer(Surface s) {
  gbuffer_albedo = vec4(albedoCode(s.albedo), metallicSpreadCode(s.metallic, s.spread));
  gbuffer_normal = vec4(octPack24(octEncode(s.normal_ws)), clamp(s.roughness, 0.0, 1.0));
  gbuffer_motion = s.motion_px;
  gbuffer_id = s.id;
#ifdef EMISSION
  // min and max of a NaN are undefined, comparisons are not.
  gbuffer_emissive = mix(vec3(0.0), min(s.emissive, vec3(kMaxEmissive)), greaterThan(s.emissive, vec3(0.0)));
#endif
}
#endif
