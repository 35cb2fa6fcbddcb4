// The grains of one buffer in the colours of how they are drawn; TURNS: of when. The rest of the picture stays.
#include "lib/swarm.glsl"
#include "shared/octahedral.h"
#include "shared/swarm_view.h"

layout(binding = kGbufferIdUnit) uniform usampler2D gbuffer_id;
layout(binding = kGbufferNormalUnit) uniform sampler2D gbuffer_normal;

in vec3 ray;

layout(location = 0) out vec4 display;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint id = texelFetch(gbuffer_id, pixel, 0).r, grain = (id & ~kGrainIdBit) - 1u - swarm.first;
  if ((id & kGrainIdBit) == 0u || grain >= swarm.count) discard;
  uint representation = representations[grain / 8u] >> 4u * (grain & 7u) & 15u;
#ifdef TURNS
  vec3 color = turnColor(representation);
#else
  vec3 color = representationColor(representation);
#endif
  vec3 normal = octDecode(octUnpack24(texelFetch(gbuffer_normal, pixel, 0).rgb));
  display = vec4(color * viewShade(-dot(normal, normalize(ray))), 1.0);
}
