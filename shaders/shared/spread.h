// Surfaces whose normals differ under one pixel: a mean direction, and how far they spread about it.
//
// Spread is 1 - the length of the mean of the unit normals that are seen, weighted by the area that they are seen
// with: 0 for one normal, 1/3 for a ball seen as a whole. About the mean direction normals are taken to be spread
// evenly; their second moments are those of a ball's caps at both ends of that range.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

const float kMostSpread = 0.5f;
// The G-buffer keeps it in so many steps, finer towards 0.
const int kSpreadSteps = 25;
RULE int spreadCode(float spread) {
  float share = clamp(spread, 0.0f, kMostSpread) * (1.0f / kMostSpread);
  return int(pow(share, 2.0f / 3.0f) * float(kSpreadSteps) + 0.5f);
}
RULE float spreadFromCode(int code) {
  float share = float(code) * (1.0f / float(kSpreadSteps));
  return kMostSpread * share * sqrt(share);
}

// Mean square of a normal's part across the mean direction, along one of two axes; and variance of that along it.
RULE float spreadAcross(float spread) { return spread - 0.75f * spread * spread; }
RULE float spreadAlong(float spread) { return 0.5f * spread * spread; }

// Variance of n.d, for the cosine c between d and the mean direction.
RULE float spreadVariance(float c, float spread) {
  return c * c * spreadAlong(spread) + max(1.0f - c * c, 0.0f) * spreadAcross(spread);
}

// Mean of max(n.d, 0). That of a disc's points is (mean + sqrt(mean^2 + (8 / (3 pi))^2 variance)) / 2 where the mean is
// 0, and the mean where that is two deviations and more; of a ball within 0.007.
RULE float spreadTowards(float c, float spread) {
  float mean = (1.0f - spread) * c, variance = max(1.0f - c * c, 0.0f) * spreadAcross(spread);
  float lost = 0.7205f * sqrt(variance * max(variance - 0.25f * mean * mean, 0.0f));
  return 0.5f * (mean + sqrt(mean * mean + lost));
}

// Means of n.d and of its square.
RULE vec2 spreadMoments(float c, float spread) {
  float mean = (1.0f - spread) * c;
  return vec2(mean, mean * mean + spreadVariance(c, spread));
}

// A flat receiver is moved out of the steps of the shadow map (shadowNormalOffset() of shared/shadow.h); so much of that
// is left out where normals spread: what is seen of balls is no plane, and lies lower than the discs that the map shows.
// Fitted to the light of beds with balls of half a texel to 12 texels: modules/points/README.md.
RULE float spreadUnmoved(float spread) { return min(2.4f * spread, 1.0f); }

// Squared GGX width (alpha^2) of what the surface's mean alpha^2 and its normals make together. Variances of slopes
// add (LEAN mapping, Olano and Baker 2010), and a lobe's alpha^2 is twice its variance. Normals of Gaussian slopes
// with a = twice the variance have a mean of length sqrt(pi / a) exp(1 / a) erfc(1 / sqrt(a)), whose inverse is
// (1 - l^2) / l^3 within 3 % up to a = 1. (Toksvig's 2 (1 - l) / l is 13 % short at a = 0.2, 36 % at 1.)
RULE float spreadAlpha2(float alpha2, float spread) {
  float l = clamp(1.0f - spread, 0.0f, 1.0f);
  float room = l * l * l;
  float excess = 1.0f - l * l;
  return excess >= room ? 1.0f : min(alpha2 + excess / room, 1.0f);
}

// Means over the near side of a ball of the two parts of a GGX lobe's albedo: of what does not depend on the angle,
// and of Schlick's weight. Fitted to modules/deferred/lobe_table: within 0.007 and 0.0015.
RULE vec2 ballAlbedo(float roughness) {
  float r2 = roughness * roughness, r4 = r2 * r2;
  return vec2(0.952f / (1.0f + r4 * (1.7f - 0.36f * r2)), (1.0f / 21.0f) / (1.0f + r2 * roughness * (12.2f + 4.0f * r4)));
}

// What the surface model (brdf.h) takes of a surface whose normals spread about n.
struct SpreadLook {
  float n_l;        // mean of max(n.l, 0)
  vec2 height;      // means of n.y and of its square
  float alpha;      // of the lobe that microfacets and normals make together
  float roughness;  // of that
  float sides;      // share of alpha^2 that is due to the normals
  vec2 kept;        // of what smooth sides would mirror at any angle, and of Schlick's weight, the microfacets leave so much
};
RULE SpreadLook spreadLook(vec3 n, vec3 to_sun, float roughness, float spread) {
  SpreadLook look;
  float alpha = roughness * roughness, alpha2 = spreadAlpha2(alpha * alpha, spread);
  look.n_l = spreadTowards(dot(n, to_sun), spread);
  look.height = spreadMoments(n.y, spread);
  look.alpha = sqrt(alpha2);
  look.roughness = sqrt(look.alpha);
  look.sides = 1.0f - alpha * alpha / alpha2;
  look.kept = ballAlbedo(roughness) * vec2(21.0f / 20.0f, 21.0f);
  return look;
}

RULES_END
