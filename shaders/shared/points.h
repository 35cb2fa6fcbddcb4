// Rules of grains that are smaller than a pixel: what they cover, and how a ball of which nothing is seen but
// its light reflects it.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// Sums are kept in whole numbers, whose order of addition does not matter: areas in this part of a pixel.
// Four channels of up to 255 times 1,024 pixels of area fit in 32 bits.
const float kPointAreaSteps = 16384.0f;

// Nearer is greater. `along`: distance along the view axis.
RULE uint pointKey(float along) { return floatBitsToUint(1.0f / max(along, 1e-30f)); }
RULE float alongOf(uint key) { return 1.0f / uintBitsToFloat(key); }

// How far behind the foremost grain of its pixel one may be and still be seen: what lies between the grains of
// a surface, and how far a surface seen at 45 degrees recedes within a pixel. m.
RULE float pointBand(float radius, float pixel_m) { return 2.5f * radius + pixel_m; }

// Shares of a point among the 2 x 2 pixels whose centres are around it: x and y from the lower left one.
RULE vec4 pointShares(vec2 fraction) {
  vec2 g = vec2(1.0f, 1.0f) - fraction;
  return vec4(g.x * g.y, fraction.x * g.y, g.x * fraction.y, fraction.x * fraction.y);
}

// Mean of the cosine to the light over the disc of a white Lambertian ball, as the share of what it would be
// if the ball faced the light all over: 2/3 with the light behind the eye, 0 with it behind the ball.
// (Schoenberg 1929; `cosine`: of the angle between the directions to eye and light.)
RULE float ballPhase(float cosine) {
  float c = clamp(cosine, -1.0f, 1.0f);
  float angle = acos(c);
  return (sqrt(max(1.0f - c * c, 0.0f)) + (3.14159265f - angle) * c) * (2.0f / (3.0f * 3.14159265f));
}

// The normal of a flat surface that reflects the light as the ball does: between the directions to the eye and
// to the light, or where the ball is darker yet, away from it.
RULE vec3 ballNormal(vec3 to_eye, vec3 to_light) {
  float cosine = dot(to_eye, to_light);
  vec3 side = to_eye - to_light * cosine;
  float length2 = dot(side, side);
  // The light is behind the eye or the ball: any direction aside will do.
  if (length2 < 1e-6f) {
    side = abs(to_light.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
    side = side - to_light * dot(side, to_light);
    length2 = dot(side, side);
  }
  float wanted = ballPhase(cosine);
  return to_light * wanted + side * (sqrt(max(1.0f - wanted * wanted, 0.0f)) / sqrt(length2));
}

RULES_END
