// One more sample of the mean: blended over the mean of those before with weight 1 / count.
#include "shared/bindings.h"

layout(binding = kRadianceUnit) uniform sampler2D radiance;
layout(location = 0) uniform float weight;
layout(location = 0) out vec4 mean;

void main() { mean = vec4(texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb, weight); }
