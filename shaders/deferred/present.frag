// Linear radiance to the display: exposure, tone curve, sRGB.
#include "shared/bindings.h"
#include "shared/tonemap.h"

layout(binding = kRadianceUnit) uniform sampler2D radiance;
layout(location = 0) uniform float exposure;
layout(location = 0) out vec4 display;

void main() {
  vec3 color = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb * exposure;
  display = vec4(srgbFromLinear(toneMap(color)), 1.0);
}
