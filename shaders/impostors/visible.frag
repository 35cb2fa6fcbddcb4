// Which grain a pixel shows: coverage alone, at the depth of the disc, so that hidden fragments are rejected
// before this runs.
#include "impostors/atlas.glsl"

in vec2 on_disc;
in vec3 point;
flat in vec3 eye;
flat in vec3 weight;
flat in uvec3 layer;
flat in vec3 right[3], up[3];
flat in float level;
flat in uint number;

layout(location = 0) out uint visible_grain;

void main() {
  if (dot(on_disc, on_disc) > 1.0) discard;
  vec3 seen = impostorOnProxy(impostorRay(point, point - eye), atlas.proxy);
  float coverage = 0.0;
  for (int k = 0; k < 3; ++k) {
    vec2 uv = vec2(dot(seen, right[k]), dot(seen, up[k])) + 0.5;
    coverage += weight[k] * textureLod(atlas_shape, vec3(uv, float(layer[k])), level).r;
  }
  if (coverage < 0.5) discard;
  visible_grain = number;
}
