// Which grain a pixel shows: coverage alone, at the depth of the disc, so that hidden fragments are rejected
// before this runs. OVERDRAW: the attachment that counts.
#include "impostors/atlas.glsl"

in vec2 on_disc;
flat in uint number;
#ifdef SMALL
in vec2 uv;
flat in vec2 layer_level;
#else
in vec3 point;
flat in vec3 eye;
flat in vec3 weight;
flat in uvec3 layer;
flat in vec3 right[3], up[3];
flat in float level;
#endif

layout(location = 0) out uint visible_grain;
#ifdef OVERDRAW
layout(location = OVERDRAW) out float overdraw;
#endif

void main() {
  if (dot(on_disc, on_disc) > 1.0) discard;
#ifdef SMALL
  float coverage = textureLod(atlas_shape, vec3(uv, layer_level.x), layer_level.y).r;
#else
  vec3 seen = impostorOnProxy(impostorRay(point, point - eye), atlas.proxy);
  float coverage = 0.0;
  for (int k = 0; k < 3; ++k) {
    vec2 at = vec2(dot(seen, right[k]), dot(seen, up[k])) + 0.5;
    coverage += weight[k] * textureLod(atlas_shape, vec3(at, float(layer[k])), level).r;
  }
#endif
  if (coverage < 0.5) discard;
  visible_grain = number;
#ifdef OVERDRAW
  overdraw = 1.0;
#endif
}
