// How often grains were written to each pixel, as a heat map in place of the picture.
#include "shared/bindings.h"
#include "shared/swarm_view.h"

layout(binding = kPassTextureUnit) uniform sampler2D overdraw;
layout(binding = kGbufferIdUnit) uniform usampler2D point_overdraw;

layout(location = 0) out vec4 display;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float times = texelFetch(overdraw, pixel, 0).r + float(texelFetch(point_overdraw, pixel, 0).r);
  display = vec4(overdrawColor(times), 1.0);
}
