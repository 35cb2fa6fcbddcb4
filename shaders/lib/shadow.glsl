// How much of the sun reaches a point, by the shadow map. Define SHADOW_SINGLE_FETCH for one bilinear
// comparison in place of 3x3.
#include "shared/shadow.h"

layout(binding = kShadowMapUnit) uniform sampler2DShadow shadow_map;

// 0 (none) to 1 (all) at a point with unit normal n; relative space.
float sunVisibility(ShadowViewBlock shadow, vec3 relative, vec3 n) {
  vec3 moved = relative + n * shadowNormalOffset(n, shadow);
  vec3 p = vec3(shadow.shadow_from_relative * vec4(moved, 1.0));
  bool outside = any(greaterThan(abs(p.xy - 0.5 * shadow.size_px), 0.5 * shadow.size_px));
  // For a fixed-point map GL clamps the reference to [0, 1]: beyond the farthest caster it is 0, and
  // the stored depth is never below.
  float depth = outside ? 1.0 : p.z;
#ifdef SHADOW_SINGLE_FETCH
  return textureLod(shadow_map, vec3(p.xy / float(kShadowMapSize), depth), 0.0);
#else
  vec2 texel = p.xy - 0.5;
  vec2 base = floor(texel);
  ShadowTaps x = shadowTaps(texel.x - base.x);
  ShadowTaps y = shadowTaps(texel.y - base.y);
  const float scale = 1.0 / float(kShadowMapSize);
  base = (base + 0.5) * scale;
  vec2 columns = base.x + vec2(x.position0, x.position1) * scale;
  vec2 rows = base.y + vec2(y.position0, y.position1) * scale;
  float lower = x.weight0 * textureLod(shadow_map, vec3(columns.x, rows.x, depth), 0.0) +
                x.weight1 * textureLod(shadow_map, vec3(columns.y, rows.x, depth), 0.0);
  float upper = x.weight0 * textureLod(shadow_map, vec3(columns.x, rows.y, depth), 0.0) +
                x.weight1 * textureLod(shadow_map, vec3(columns.y, rows.y, depth), 0.0);
  return (y.weight0 * lower + y.weight1 * upper) * (1.0 / 9.0);
#endif
}
