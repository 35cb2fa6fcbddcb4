// The surface model: GGX reflection with multiple-scattering compensation over a Lambertian base,
// mixed by metallic as glTF 2.0 (appendix B) says.
//
//   f = D V F + (M(v) + albedo (1 - S(v) - M(v))) / pi      for a dielectric, F0 = 0.04
//   f = D V F + M(v) / pi                                    for a metal, F0 = base colour
//
// S = F0 A + B is the exact directional albedo of the first term (tables over n.v and roughness),
// M what is scattered more than once (Fdez-Aguera 2019, "A Multiple-Scattering Microfacet Model
// for Real-Time Image-based Lighting", eq. 14 to 18). Sun and sky use the same f, and a surface of
// albedo 1 reflects exactly what it receives from a uniform sky, whatever the tables' error.
#pragma once
#include "shared/prelude.h"
#include "shared/sky.h"
#include "shared/spread.h"
RULES_BEGIN

const float kPi = 3.14159265358979f;
const float kDielectricF0 = 0.04f;
// Smallest perceptual roughness that is shaded; below, the sun's highlight is narrower than a pixel
// and its peak leaves the range of half floats.
const float kMinRoughness = 0.045f;

// GGX's alpha of a perceptual roughness in [0, 1].
RULE float alphaFromRoughness(float roughness) {
  float r = max(roughness, kMinRoughness);
  return r * r;
}

// D * V: GGX distribution times height-correlated Smith visibility (Heitz 2014, eq. 99), 1/sr.
// All cosines in (0, 1].
RULE float ggxDistributionVisibility(float n_h, float n_v, float n_l, float alpha) {
  float a2 = alpha * alpha;
  // 1 - n_h^2 (1 - a2) cancels near the peak; n_h arrives rounded, so the peak's width is limited
  // by kMinRoughness: a2 >= 4e-6.
  float d = (n_h * a2 - n_h) * n_h + 1.0f;
  float smith = n_l * sqrt(n_v * n_v * (1.0f - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0f - a2) + a2);
  return a2 * 0.5f / (kPi * d * d * smith);
}

// (1 - cos)^5 of Schlick's Fresnel approximation.
RULE float schlickWeight(float cosine) {
  float m = clamp(1.0f - cosine, 0.0f, 1.0f);
  float m2 = m * m;
  return m2 * m2 * m;
}

// How one surface splits what it reflects, for one view direction.
struct Reflectance {
  vec3 f0;       // of the mixed single-scattering lobe, for D V F
  vec3 single;   // directional albedo of D V F
  vec3 diffuse;  // directional albedo of everything else: it leaves with the cosine
};

// `a`, `b`: directional albedo of D V (1 - w) and D V w, w = Schlick's weight, at this n.v and
// roughness; both >= 0, a + b <= 1.
RULE Reflectance reflectance(vec3 base_color, float metallic, float a, float b) {
  float lost = 1.0f - a - b;
  float dielectric_single = kDielectricF0 * a + b;
  float dielectric_average = kDielectricF0 + (1.0f - kDielectricF0) / 21.0f;
  float dielectric_multiple =
      lost * dielectric_single * dielectric_average / (1.0f - dielectric_average * lost);
  float transmitted = 1.0f - dielectric_single - dielectric_multiple;

  vec3 one = vec3(1.0f, 1.0f, 1.0f);
  vec3 metal_single = base_color * a + one * b;
  vec3 metal_average = base_color * (20.0f / 21.0f) + one * (1.0f / 21.0f);
  vec3 metal_multiple = metal_single * metal_average * lost / (one - metal_average * lost);

  Reflectance r;
  vec3 d0 = vec3(kDielectricF0, kDielectricF0, kDielectricF0);
  r.f0 = mix(d0, base_color, metallic);
  r.single = mix(one * dielectric_single, metal_single, metallic);
  r.diffuse = mix(one * dielectric_multiple + base_color * transmitted, metal_multiple, metallic);
  return r;
}

// Radiance per irradiance measured across the beam: f (n.l). Zero when the light is below the
// horizon. `n_l`: dot(n, l), or what spread normals make of it (shared/spread.h).
RULE vec3 reflectBeam(Reflectance r, vec3 n, vec3 v, vec3 l, float n_l, float n_v, float alpha) {
  if (!(n_l > 0.0f)) return vec3(0.0f, 0.0f, 0.0f);
  vec3 h = l + v;
  float h2 = max(dot(h, h), 1e-12f);  // l = -v: no half vector; n.l > 0 then needs n.v < 0
  float h_inverse = 1.0f / sqrt(h2);
  float n_h = clamp((dot(n, l) + dot(n, v)) * h_inverse, 0.0f, 1.0f);
  float v_h = 0.5f * h2 * h_inverse;
  float w = schlickWeight(v_h);
  vec3 f = r.f0 * (1.0f - w) + vec3(w, w, w);
  float dv = ggxDistributionVisibility(n_h, n_v, n_l, alpha);
  return (f * dv + r.diffuse * (1.0f / kPi)) * n_l;
}

// The same of a surface of many normals (shared/spread.h). Its own shadow on itself is known of microfacets, not of
// the normals under a pixel: grains are round, and whatever of them is turned half way from the eye to the light is
// lit. So the share of the lobe that is due to these is masked towards the eye alone.
RULE vec3 reflectSpreadBeam(Reflectance r, vec3 n, vec3 v, vec3 l, float n_v, SpreadLook look) {
  vec3 h = l + v;
  float h2 = max(dot(h, h), 1e-12f), h_inverse = 1.0f / sqrt(h2);
  float n_h = clamp((dot(n, l) + dot(n, v)) * h_inverse, 0.0f, 1.0f);
  float w = schlickWeight(0.5f * h2 * h_inverse), a2 = look.alpha * look.alpha, n_l = look.n_l;
  float d = (n_h * a2 - n_h) * n_h + 1.0f, seen = sqrt(n_v * n_v * (1.0f - a2) + a2);
  float facets = n_l / max(n_l * seen + n_v * sqrt(n_l * n_l * (1.0f - a2) + a2), 1e-12f) * (1.0f - look.sides);
  float sides = look.sides / (n_v + seen);
  vec3 even = r.f0 * ((1.0f - w) * (facets + sides * look.kept.x));
  float edge = w * (facets + sides * look.kept.y);
  return (even + vec3(edge, edge, edge)) * (a2 * 0.5f / (kPi * d * d)) + r.diffuse * (n_l * (1.0f / kPi));
}

// The lobe table: what D V F does to the sky, by n.v (along x) and roughness (along y).
// Texels: (a, b, tangent, normal) of LobeTerms. Built on the CPU (modules/deferred/lobe_table.h),
// where its error is stated.
const int kLobeTableSize = 32;

struct LobeTerms {
  float a;        // directional albedo of D V (1 - w)
  float b;        // and of D V w, w = Schlick's weight
  float tangent;  // mean direction of the lobe = tangent (n (n.v) - v) + normal n
  float normal;
};

// Texture coordinates of an entry. Finer towards grazing angles, where the terms change fast; the
// first and last texels' centres are n.v = 0 and 1, roughness 0 and 1.
RULE vec2 lobeTableUv(float n_v, float roughness) {
  float size = float(kLobeTableSize);
  return (vec2(sqrt(n_v), roughness) * (size - 1.0f) + vec2(0.5f, 0.5f)) / size;
}

// Radiance towards v of a surface under the whole sky: split sum (Karis 2013) with the lobe's true
// mean direction in place of the mirror direction, which makes it exact for what is linear in the
// sky; the order-2 part is narrowed by a factor fitted to the GGX lobe (within 0.06). `height`: n.y and its square.
RULE vec3 reflectSky(SkyPolynomial sky, Reflectance r, LobeTerms lobe, vec3 n, vec3 v, float n_v,
                     float roughness, vec2 height) {
  vec3 mean = (n * n_v - v) * lobe.tangent + n * lobe.normal;
  float s1 = sqrt(dot(mean, mean));
  float k = 1.0f - 1.5f * roughness * max(1.0f - s1, 0.0f);
  return r.single * skyLobeRadiance(sky, mean, k) + r.diffuse * skyIrradianceOverPi(sky, height.x, height.y);
}

RULES_END
