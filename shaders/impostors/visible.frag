// Which grain a pixel shows: coverage alone, at the depth of the outer sphere's disc, so that hidden fragments are
// rejected before this runs. OVERDRAW: the attachment that counts.
#include "impostors/coverage.glsl"
#include "shared/impostor.h"

in vec3 on_disc;
in vec3 point;
flat in vec3 eye;
flat in vec4 weight_steps;
flat in vec4 right0, up0, right1, up1, right2, up2;
flat in vec3 proxy_center, proxy_diagonal, proxy_upper;
flat in uint number;

layout(location = 0) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

float seenBy(vec3 seen, vec4 right, vec4 up) {
  float steps = weight_steps.w;
  return coverageAt(vec2(dot(seen, right.xyz), dot(seen, up.xyz)) + 0.5 * steps, steps, vec2(right.w, up.w));
}

void main() {
  if (dot(on_disc.xy, on_disc.xy) > on_disc.z * on_disc.z) discard;
  ImpostorProxy proxy = ImpostorProxy(vec4(proxy_center, 0.0), vec4(proxy_diagonal, 0.0), vec4(proxy_upper, 0.0));
  vec3 seen = impostorOnProxy(impostorRay(point, point - eye), proxy);
  // In a loop they would be read from memory, by llvmpipe.
  float coverage = weight_steps.x * seenBy(seen, right0, up0);
  coverage += weight_steps.y * seenBy(seen, right1, up1);
  coverage += weight_steps.z * seenBy(seen, right2, up2);
  if (coverage < 0.5) discard;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
}
