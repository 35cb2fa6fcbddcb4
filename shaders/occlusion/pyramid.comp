// Three levels of the depth pyramid from the picture's depth, or (FROM_LEVEL) from the level below
// them; each invocation takes 8 x 8 texels, so that none waits for another. A software rasteriser pays
// dearly for shared memory: 11 ms against 1.5 ms for a picture of 1280 x 720.
#include "shared/bindings.h"

layout(local_size_x = 64) in;

layout(binding = kPassTextureUnit) uniform sampler2D source;
layout(binding = kPyramidImage, r32f) uniform writeonly image2D level_0;
layout(binding = kPyramidImage + 1, r32f) uniform writeonly image2D level_1;
layout(binding = kPyramidImage + 2, r32f) uniform writeonly image2D level_2;

layout(location = 0) uniform ivec2 size;  // of the source, as far as it is in use
layout(location = 1) uniform int level;   // of the source

// Least of the 2 x 2 texels from p on; beyond the edge the last ones count again.
float least(ivec2 p) {
#ifdef FROM_LEVEL
  p = min(p, size - 1);
  ivec2 q = min(p + 1, size - 1);
  return min(min(texelFetch(source, p, level).r, texelFetch(source, ivec2(q.x, p.y), level).r),
             min(texelFetch(source, ivec2(p.x, q.y), level).r, texelFetch(source, q, level).r));
#else
  // At the corner that the four share, half a texel from where the choice would change; the wrap
  // mode clamps.
  vec4 four = textureGather(source, vec2(p + 1) / vec2(size));
  return min(min(four.x, four.y), min(four.z, four.w));
#endif
}

void main() {
  ivec2 at_2 = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(at_2 * 8, size))) return;
  float least_2 = 1.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 at_1 = at_2 * 2 + ivec2(k & 1, k >> 1);
    float least_1 = 1.0;
    for (int j = 0; j < 4; ++j) {
      ivec2 at_0 = at_1 * 2 + ivec2(j & 1, j >> 1);
      float least_0 = least(at_0 * 2);
      imageStore(level_0, at_0, vec4(least_0));  // outside of the level: dropped
      least_1 = min(least_1, least_0);
    }
    imageStore(level_1, at_1, vec4(least_1));
    least_2 = min(least_2, least_1);
  }
  imageStore(level_2, at_2, vec4(least_2));
}
