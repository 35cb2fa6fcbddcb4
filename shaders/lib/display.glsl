// Linear radiance to the display: exposure, tone curve, sRGB.
#include "shared/tonemap.h"

layout(location = 0) uniform float exposure;

vec4 displayed(vec3 radiance) { return vec4(srgbFromLinear(toneMap(radiance * exposure)), 1.0); }
