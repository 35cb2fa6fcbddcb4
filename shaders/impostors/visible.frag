// Which grain a pixel shows: coverage alone, at the depth of the outer sphere's disc, so that hidden fragments are
// rejected before this runs. OVERDRAW: the attachment that counts.
#include "impostors/atlas.glsl"

in vec3 on_disc;
in vec3 point;
flat in vec3 eye;
flat in vec3 weight;
flat in uvec3 layer;
flat in vec3 right[3], up[3];
flat in float level;
flat in uint number;

layout(location = 0) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

void main() {
  if (dot(on_disc.xy, on_disc.xy) > on_disc.z * on_disc.z) discard;
  vec3 seen = impostorOnProxy(impostorRay(point, point - eye), atlas.proxy);
  float coverage = 0.0;
  for (int k = 0; k < 3; ++k) {
    vec2 at = vec2(dot(seen, right[k]), dot(seen, up[k])) + 0.5;
    coverage += weight[k] * textureLod(atlas_shape, vec3(at, float(layer[k])), level).r;
  }
  if (coverage < 0.5) discard;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
}
