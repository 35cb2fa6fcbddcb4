// Sun and sky of the frame, as every program that shades reads them.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
#include "shared/sky.h"
RULES_BEGIN

// std140.
struct LightingBlock {
  SkyPolynomial sky;
  vec4 to_sun;          // xyz: unit, towards the sun; w unused
  vec4 sun_irradiance;  // rgb: across the beam, colour * lux; 0 without a sun; w unused
};

RULES_END

#ifndef __cplusplus
layout(std140, binding = kLightingBinding) uniform LightingUniforms { LightingBlock lighting; };
#endif
