// Linear radiance to the display.
#include "lib/display.glsl"
#include "shared/bindings.h"

layout(binding = kRadianceUnit) uniform sampler2D radiance;
layout(location = 0) out vec4 display;

void main() { display = displayed(texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb); }
