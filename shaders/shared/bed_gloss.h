// Gloss of a bed of balls (shared/bed.h), and the flat surface that reflects as much of the sun and of the sky.
//
// A ball mirrors its surroundings from all sides: seen as a whole its gloss hardly depends on where the light is. So
// the flat surface is matte: what the gloss of the balls has more than its own is added to its colour, white, and
// its normal makes up for the sun. Luminances; the sky's is linear.x + linear.y y + linear.z y^2.
#pragma once
#include "shared/bed.h"
#include "shared/spread.h"
RULES_BEGIN

// The flat surface's roughness: of metal, whose gloss is all that it reflects, the balls' own if it is more than
// the least. On a smoother one the sun would flash, where balls show it whatever their turn is.
const float kBedLeastRoughness = 0.5f;
RULE float bedRoughness(float roughness, float metallic) {
  return metallic * max(roughness, kBedLeastRoughness) + (1.0f - metallic);
}

// What ballAlbedo (shared/spread.h) is, of a flat surface of roughness 1: within 0.01 and 0.005.
RULE vec2 matteAlbedo(float n_v) {
  float q = 1.0f - sqrt(n_v);
  return vec2(0.307f + q * (0.41f + 0.32f * q), 0.046f * q * q);
}

RULE float skyAlong(vec3 sky, float mean_y, float mean_y2) { return max(sky.x + sky.y * mean_y + sky.z * mean_y2, 0.0f); }

// What the balls mirror of the sky. Of mirrors, with equal shares, all directions are reflected alike; Schlick's
// weight prefers those away from the eye. The shares add their first two terms. Moments of n.v with that weight:
// 1/4, 1/12, 1/30 (beta functions).
RULE float bedSkyGloss(vec3 to_eye, vec3 up, vec3 shares, float f0, float roughness, vec3 sky) {
  float f = dot(to_eye, up), v = to_eye.y, u = up.y, f2 = f * f;
  vec2 albedo = ballAlbedo(roughness);
  float even = shares.x + shares.y * (2.0f / 3.0f) * f + shares.z * (0.25f + 0.25f * f2);
  float even_y = shares.y * ((4.0f / 15.0f) * u - (2.0f / 15.0f) * f * v);
  float edge = shares.x + shares.y * 0.25f * f + shares.z * ((1.0f / 12.0f) * f2 + (11.0f / 24.0f) * (1.0f - f2));
  float edge_y = shares.x * (-5.0f / 6.0f) * v + shares.y * (-(11.0f / 60.0f) * f * v + (13.0f / 60.0f) * (u - f * v));
  // Mean of (r.v)^2 with that weight.
  float edge_y2 = 0.727f * v * v + 0.1365f * (1.0f - v * v);
  float of_even = f0 * albedo.x * skyAlong(sky, even_y / even, 1.0f / 3.0f);
  float of_edge = edge / even * albedo.y * skyAlong(sky, edge_y / edge, edge_y2);
  return of_even + of_edge;
}

// What the matte surface mirrors of it: its lobe is about its normal.
RULE float matteSkyGloss(float y, float n_v, float f0, vec3 sky) {
  vec2 albedo = matteAlbedo(n_v);
  return (f0 * albedo.x + albedo.y) * skyAlong(sky, 0.61f * y, 1.0f / 3.0f + 0.41f * (0.372f * y * y - 0.124f));
}

// `share`, `white`: the flat surface's colour is share times the balls' + white.
struct BedSurface {
  vec3 normal;
  float share;
  float white;
};

// `to_sun`: 0 if there is none. `base`: luminance of the balls' colour; f0: of the gloss; sun: its irradiance does
// not matter, as both reflect it alike.
RULE BedSurface bedSurface(vec3 to_eye, vec3 to_sun, vec3 up, vec3 shares, float base, float f0, float roughness,
                           float metallic, vec3 sky) {
  BedSurface s;
  bool sunny = dot(to_sun, to_sun) > 0.5f;
  vec3 light = sunny ? to_sun : vec3(0.0f, 1.0f, 0.0f);
  float height = bedHeight(bedHeights(to_eye, up, shares), sky.y * (2.0f / 3.0f), sky.z * 0.25f);
  float cosine = sunny ? bedTowards(to_eye, to_sun, up, shares) : height, gained = cosine;
  vec2 ball = ballAlbedo(roughness);
  float lost = f0 * ball.x + ball.y, gloss = bedSkyGloss(to_eye, up, shares, f0, roughness, sky);
  // Mirrors reflect F / 4 shares(h) / seen of a beam, / pi. Roughness blurs that, until at 1 it is what the matte
  // surface does.
  vec3 h = to_eye + light;
  float h2 = dot(h, h);
  h = h2 > 1e-6f ? h * (1.0f / sqrt(h2)) : up;
  float w = schlickWeight(dot(to_eye, h)), fresnel = f0 + (1.0f - f0) * w, t = dot(up, h);
  float mirrors = 0.25f * (shares.x + shares.y * t + shares.z * t * t) / bedSeen(shares, dot(to_eye, up));
  float strength = sunny && h2 > 1e-6f ? 1.0f - alphaFromRoughness(roughness) : 0.0f;
  float alpha = alphaFromRoughness(bedRoughness(roughness, metallic));
  s.share = 1.0f, s.white = 0.0f;
  // What the flat surface mirrors itself changes with its normal: half of each step suffices to settle.
  for (int k = 0; k < 4; ++k) {
    s.normal = bedNormal(to_eye, light, gained, height);
    float kept = 1.0f, n_v = clamp(dot(s.normal, to_eye), 1e-3f, 1.0f), n_h = clamp(dot(s.normal, h), 0.0f, 1.0f);
    if (metallic < 0.5f) {
      vec2 matte = matteAlbedo(n_v);
      float y = s.normal.y;
    kept = 1.0f - f0 * matte.x - matte.y;
      float even = skyAlong(sky, y * (2.0f / 3.0f), 0.25f + 0.25f * y * y);
      s.share = (1.0f - lost) / kept;
      s.white = even > 1e-6f ? (gloss - matteSkyGloss(y, n_v, f0, sky)) / (even * kept) : 0.0f;
      s.white = clamp(s.white, -0.5f * base, 1.0f - base);
    }
    float own = base * (1.0f - metallic), flat_own = own * s.share + s.white;
    if (!(sunny && flat_own > 0.0f)) continue;
    float n_l = max(gained, 1e-3f), flat_gloss = kPi * n_l * ggxDistributionVisibility(n_h, n_v, n_l, alpha);
    float wanted = own * (1.0f - lost) * cosine + strength * fresnel * (mirrors - flat_gloss);
    gained = clamp(0.5f * (gained + wanted / (flat_own * kept)), 0.0f, 1.0f);
  }
  return s;
}

RULES_END
