// The sky: radiance as a quadratic in the direction's height, with its exact diffuse and blurred
// integrals. Being band-limited to l = 2 it is an exact test oracle and needs no texture.
//
//   L(d) = a + b y + c y^2,  y = d.y;  L(+Y) = zenith, L(y = 0) = horizon, L(-Y) = ground
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// Radiance, linear RGB; w unused (std140).
struct SkyPolynomial {
  vec4 a;
  vec4 b;
  vec4 c;
};

RULE SkyPolynomial skyPolynomial(vec3 zenith, vec3 horizon, vec3 ground) {
  SkyPolynomial sky;
  sky.a = vec4(horizon, 0.0f);
  sky.b = vec4((zenith - ground) * 0.5f, 0.0f);
  sky.c = vec4((zenith + ground) * 0.5f - horizon, 0.0f);
  return sky;
}

// Radiance from unit direction d with d.y = y. A horizon much darker than zenith or ground together
// can push the quadratic below zero: it is shown as zero, while the integrals below keep the
// negative part.
RULE vec3 skyRadiance(SkyPolynomial sky, float y) {
  return max(vec3(sky.a) + (vec3(sky.b) + vec3(sky.c) * y) * y, vec3(0.0f, 0.0f, 0.0f));
}

// Irradiance / pi on a surface with normal n, n.y = y: the radiance of a white Lambertian surface. Of a surface with
// many normals: their mean of y, and of y^2.
// Integral of L(d) (n.d) over the hemisphere of n, over pi: the cosine lobe scales the Legendre
// terms of order 0, 1, 2 by 1, 2/3, 1/4 (Ramamoorthi & Hanrahan 2001).
RULE vec3 skyIrradianceOverPi(SkyPolynomial sky, float y, float y2) {
  return max(vec3(sky.a) + vec3(sky.b) * (y * (2.0f / 3.0f)) + vec3(sky.c) * (0.25f + 0.25f * y2),
             vec3(0.0f, 0.0f, 0.0f));
}

// Mean radiance over a lobe of directions. `mean`: the mean of its unit directions (its length s1 is
// the factor on the Legendre terms of order 1); order 2 is scaled by k s1^2, about the same axis.
RULE vec3 skyLobeRadiance(SkyPolynomial sky, vec3 mean, float k) {
  float y2 = (1.0f / 3.0f) + k * (mean.y * mean.y - dot(mean, mean) * (1.0f / 3.0f));
  return max(vec3(sky.a) + vec3(sky.b) * mean.y + vec3(sky.c) * y2, vec3(0.0f, 0.0f, 0.0f));
}

RULES_END
