// The pixels that points cover, into the G-buffer; their sums are emptied.
#include "lib/gbuffer.glsl"
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kPointSumsBinding) buffer Sums { uvec4 sums[]; };
#ifdef SURFACES
layout(std430, binding = kPointSurfacesBinding) buffer Surfaces { uvec2 surfaces[]; };
#endif
#ifdef IDS
layout(std430, binding = kPointIdsBinding) readonly buffer Ids { uint ids[]; };
#endif

layout(location = 0) uniform vec2 surface;      // roughness, metalness
layout(location = 1) uniform vec3 to_sun;       // 0: there is none
layout(location = 2) uniform float least_area;  // share of a pixel

in vec3 ray;

uint at(ivec2 pixel) {
  ivec2 p = clamp(pixel, ivec2(0), ivec2(view.size_px) - 1);
  return uint(p.y) * uint(view.size_px.x) + uint(p.x);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint here = at(pixel);
  uvec4 sum = sums[here];
  // Zero again for the next frame: nothing is added beyond the tiles that are drawn here.
  if (sum.w != 0u) sums[here] = uvec4(0u);
#ifdef SURFACES
  uvec2 surface_sum = surfaces[here];
  if (sum.w != 0u) surfaces[here] = uvec2(0u);
#endif
  float area = float(sum.w) / kPointAreaSteps;
  if (area < least_area) discard;
  uint key = keys[here];
  uint id_at = here;
  // No point has its centre in this pixel: those around it cover it.
  if (key == 0u)
    for (int k = 0; k < 9; ++k) {
      uint there = at(pixel + ivec2(k % 3 - 1, k / 3 - 1));
      if (keys[there] > key) {
        key = keys[there];
        id_at = there;
      }
    }
  if (key == 0u) discard;
  float along = alongOf(key);
  gl_FragDepth = view.near_m / along;

  Surface s;
  s.albedo = vec3(sum.rgb) / (255.0 * float(sum.w));
#ifdef SURFACES
  vec2 look = vec2(surface_sum) / (255.0 * float(sum.w));
#else
  vec2 look = surface;
#endif
  s.metallic = look.y;
  vec3 to_eye = -normalize(ray);
  s.normal_ws = dot(to_sun, to_sun) > 0.5 ? ballNormal(to_eye, to_sun) : to_eye;
  s.roughness = look.x;
#ifdef MOTION
  vec3 previous = ray * along + view.camera_delta.xyz;
  s.motion_px = motionFromPrevious((view.previous_clip_from_relative * vec4(previous, 1.0)).xyw, gl_FragDepth);
#else
  s.motion_px = vec2(0.0);
#endif
#ifdef IDS
  s.id = ids[id_at];
#else
  s.id = 0u;
#endif
  writeGbuffer(s);
}
