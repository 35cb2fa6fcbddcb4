// Reads an atlas: what textureLod() gives, of packed images. Arguments as of coverageAt().
#include "impostors/coverage.glsl"

layout(r32ui, binding = kImpostorHeightImage) readonly uniform uimage2D atlas_height;
layout(rg32ui, binding = kImpostorSurfaceImage) readonly uniform uimage2D atlas_surface;

// Coverage and height.
vec2 shapeAt(vec2 at, float steps, vec2 from) {
  uvec2 step = coverageStep(at, steps, from);
  ivec2 texel = coverageTexel(step);
  return vec2(float(coverageBetween(imageLoad(atlas_coverage, texel).r, step & 255u)),
              float(coverageBetween(imageLoad(atlas_height, texel).r, step & 255u))) * (1.0 / 255.0);
}
struct AtlasSurface {
  vec4 color, normal;
};
AtlasSurface surfaceAt(vec2 at, float steps, vec2 from) {
  uvec2 step = coverageStep(at, steps, from);
  ivec2 texel = coverageTexel(step);
  // Beyond the edge is another level's or view's, of which nothing is taken there.
  uvec2 word = imageLoad(atlas_surface, texel).rg, right = imageLoad(atlas_surface, texel + ivec2(1, 0)).rg;
  uvec2 upper = imageLoad(atlas_surface, texel + ivec2(0, 1)).rg, both = imageLoad(atlas_surface, texel + ivec2(1, 1)).rg;
  return AtlasSurface(coverageBytes(word.x, right.x, upper.x, both.x, step & 255u),
                      coverageBytes(word.y, right.y, upper.y, both.y, step & 255u));
}
