// Surface of the grain that each pixel shows, into the G-buffer, with its exact depth. Define MOTION
// where somebody reads it.
#include "lib/gbuffer.glsl"
#include "shared/grain.h"
#include "shared/sphere.h"
#include "shared/swarm.h"

layout(binding = kPassTextureUnit) uniform usampler2D visible_grains;

in vec3 ray;

void main() {
  uint index = texelFetch(visible_grains, ivec2(gl_FragCoord.xy), 0).r;
  if (index == 0u) discard;
  GrainRecord grain = grains[index - 1u];
  vec3 center = grainCenter(grain, frame.origin.xyz, frame.alpha);
  SphereHit hit = hitSphere(ray, center, grain.radius, true);
  gl_FragDepth = view.near_m / max(hit.t, view.near_m);

  vec4 rotation = grainRotation(grain, (frame.alpha - 1.0) * frame.tick_s);
  vec3 local = rotateBy(vec4(-rotation.xyz, rotation.w), hit.normal);
#ifdef MOTION
  vec4 previous_rotation = grainRotation(grain, (frame.previous_alpha - 1.0) * frame.tick_s);
  vec3 previous = grainCenter(grain, frame.previous_origin.xyz, frame.previous_alpha) +
                  grain.radius * rotateBy(previous_rotation, local);
  vec3 previous_clip = (view.previous_clip_from_relative * vec4(previous, 1.0)).xyw;
  vec2 motion_px = motionFromPrevious(previous_clip, gl_FragDepth);
#else
  vec2 motion_px = vec2(0.0);
#endif

  float contrast = grainContrast(grain.radius * view.pixels_at_1m / max(hit.t, view.near_m));
  Surface s;
  s.albedo = tintOf(grain.look) * grainPattern(local, contrast);
  s.metallic = 0.0;
  s.spread = 0.0;
  s.normal_ws = hit.normal;
  s.roughness = roughnessOf(grain.look);
  s.motion_px = motion_px;
  s.id = grain.id;
  writeGbuffer(s);
}
