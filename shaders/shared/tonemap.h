// From linear radiance to the display: tone curve and sRGB encoding.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// Khronos PBR Neutral (Khronos 2024, ToneMapping/PBR_Neutral). Keeps hue and base colour: below
// 0.8 only the Fresnel offset (at most 0.04) is taken away; above, the peak is compressed towards 1
// and desaturates. Radiance >= 0, exposed so that 1 is the display's white -> [0, 1).
RULE vec3 toneMap(vec3 radiance) {
  const float compression_start = 0.8f - 0.04f;
  const float desaturation = 0.15f;
  float low = min(radiance.x, min(radiance.y, radiance.z));
  float offset = low < 0.08f ? low - 6.25f * low * low : 0.04f;
  vec3 color = radiance - vec3(offset, offset, offset);
  float peak = max(color.x, max(color.y, color.z));
  if (peak < compression_start) return color;
  float d = 1.0f - compression_start;
  float new_peak = 1.0f - d * d / (peak + d - compression_start);
  color = color * (new_peak / peak);
  float g = 1.0f / (desaturation * (peak - new_peak) + 1.0f);
  return vec3(new_peak, new_peak, new_peak) * (1.0f - g) + color * g;
}

// IEC 61966-2-1, one channel: linear [0, 1] -> encoded [0, 1]. The power is a polynomial of degree 4
// in the fourth root, minimax over the curved part: within 3.5e-5 of the standard (0.009 steps of 8
// bits), and cheaper than pow where there is no hardware for it.
RULE float srgbFromLinear(float linear) {
  float x = clamp(linear, 0.0f, 1.0f);
  float s = sqrt(sqrt(x));
  float curved = (((0.08132998f * s - 0.33550155f) * s + 1.12268162f) * s + 0.19613587f) * s - 0.06461154f;
  return x <= 0.0031308f ? 12.92f * x : min(curved, 1.0f);
}
RULE vec3 srgbFromLinear(vec3 linear) {
  return vec3(srgbFromLinear(linear.x), srgbFromLinear(linear.y), srgbFromLinear(linear.z));
}

// The inverse.
RULE float linearFromSrgb(float encoded) {
  float x = clamp(encoded, 0.0f, 1.0f);
  return x <= 0.04045f ? x / 12.92f : pow((x + 0.055f) / 1.055f, 2.4f);
}

RULES_END
