// Sky and surface model without GL, against integrals taken in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "engine/core/random.h"
#include "modules/deferred/lobe_table.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/sky.h"

namespace scree {
namespace {

constexpr double kPi = 3.14159265358979323846;

double unit(uint64_t seed, uint64_t i, uint64_t draw) { return randomUnit(seed, i, 0, draw); }

dvec3 direction(double z, double phi) {
  const double r = std::sqrt(std::max(0.0, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}
dvec3 randomDirection(uint64_t seed, uint64_t i, uint64_t draw = 0) {
  return direction(2 * unit(seed, i, draw) - 1, 2 * kPi * unit(seed, i, draw + 1));
}
// Columns t, b, n of some frame around n.
glm::dmat3 frameAround(dvec3 n) {
  const dvec3 t = glm::normalize(glm::cross(std::abs(n.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0), n));
  return {t, glm::cross(n, t), n};
}

struct SkyColors {
  vec3 zenith, horizon, ground;
};
const SkyColors kSkies[] = {
    {vec3(0.18f, 0.32f, 0.65f), vec3(0.60f, 0.68f, 0.75f), vec3(0.16f, 0.14f, 0.12f)},
    {vec3(1), vec3(1), vec3(1)},
    {vec3(2, 0.5f, 0), vec3(1, 0.5f, 0.2f), vec3(0.1f, 0.5f, 0.2f)},
};
// Straight from the definition: the parabola through the three colours.
dvec3 skyReference(const SkyColors& s, dvec3 d) {
  const double y = d.y;
  return dvec3(s.ground) * (y * (y - 1) / 2) + dvec3(s.horizon) * (1 - y * y) +
         dvec3(s.zenith) * (y * (y + 1) / 2);
}
rules::SkyPolynomial polynomial(const SkyColors& s) {
  return rules::skyPolynomial(s.zenith, s.horizon, s.ground);
}
double maxOf(dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

TEST(Sky, TakesItsThreeColours) {
  for (const SkyColors& s : kSkies) {
    EXPECT_LT(maxOf(dvec3(rules::skyRadiance(polynomial(s), 1)) - dvec3(s.zenith)), 1e-6);
    EXPECT_LT(maxOf(dvec3(rules::skyRadiance(polynomial(s), 0)) - dvec3(s.horizon)), 1e-6);
    EXPECT_LT(maxOf(dvec3(rules::skyRadiance(polynomial(s), -1)) - dvec3(s.ground)), 1e-6);
    for (uint64_t i = 0; i < 1000; ++i) {
      const dvec3 d = randomDirection(1, i);
      EXPECT_LT(maxOf(dvec3(rules::skyRadiance(polynomial(s), static_cast<float>(d.y))) - skyReference(s, d)),
                1e-6);
    }
  }
}

TEST(Sky, NeverShowsNegativeRadiance) {
  const auto dark = rules::skyPolynomial(vec3(0), vec3(0), vec3(4));
  for (int i = -100; i <= 100; ++i) EXPECT_GE(rules::skyRadiance(dark, i / 100.0f).x, 0);
}

// Irradiance / pi by the midpoint rule over the hemisphere of n, in cos and phi.
TEST(Sky, IrradianceIsTheIntegral) {
  constexpr int kRings = 200, kSectors = 200;
  for (const SkyColors& s : kSkies)
    for (uint64_t k = 0; k < 20; ++k) {
      const dvec3 n = k == 0 ? dvec3(0, 1, 0) : k == 1 ? dvec3(0, -1, 0) : randomDirection(2, k);
      const glm::dmat3 frame = frameAround(n);
      dvec3 sum(0);
      for (int i = 0; i < kRings; ++i)
        for (int j = 0; j < kSectors; ++j) {
          const double z = (i + 0.5) / kRings;
          sum += skyReference(s, frame * direction(z, 2 * kPi * (j + 0.5) / kSectors)) * z;
        }
      const dvec3 expected = sum * (2.0 / (kRings * kSectors));  // dw = dz dphi, over pi
      const dvec3 got(rules::skyIrradianceOverPi(polynomial(s), static_cast<float>(n.y), static_cast<float>(n.y * n.y)));
      EXPECT_LT(maxOf(got - expected), 2e-5) << "n.y " << n.y;
    }
}

// A lobe symmetric about its mean, Henyey-Greenstein: moments of order l are g^l.
TEST(Sky, LobeRadianceIsTheIntegral) {
  constexpr int kRings = 20000, kSectors = 16;
  for (const double g : {0.0, 0.3, 0.7, 0.9})
    for (uint64_t k = 0; k < 4; ++k) {
      const dvec3 m = randomDirection(3, k);
      const glm::dmat3 frame = frameAround(m);
      dvec3 sum(0);
      for (int i = 0; i < kRings; ++i) {
        const double z = 2 * (i + 0.5) / kRings - 1;
        const double weight = 0.5 * (1 - g * g) / std::pow(1 + g * g - 2 * g * z, 1.5);
        for (int j = 0; j < kSectors; ++j)
          sum += skyReference(kSkies[0], frame * direction(z, 2 * kPi * (j + 0.5) / kSectors)) * weight;
      }
      const dvec3 expected = sum * (2.0 / (kRings * kSectors));
      const dvec3 got(rules::skyLobeRadiance(polynomial(kSkies[0]), vec3(m * g), 1));
      EXPECT_LT(maxOf(got - expected), 1e-4) << "g " << g;
    }
}

// ---- surface model

// The model again in double, from its papers, without the compensation.
struct Ggx {
  double alpha;
  double d(double n_h) const {
    const double c2 = n_h * n_h, t2 = (1 - c2) / c2;
    const double q = alpha * alpha + t2;
    return alpha * alpha / (kPi * c2 * c2 * q * q);
  }
  double lambda(double c) const {
    return (-1 + std::sqrt(1 + alpha * alpha * (1 - c * c) / (c * c))) / 2;
  }
  // D V = D G2 / (4 n.v n.l)
  double dv(double n_h, double n_v, double n_l) const {
    return d(n_h) / ((1 + lambda(n_v) + lambda(n_l)) * 4 * n_v * n_l);
  }
};

// sum(weight(l) * f) over the reflection lobe, f = D V (n.l): half vectors drawn from D (n.h) over a
// regular grid, so that neither the sampling nor the lattice is the table's.
template <class F>
void overLobe(double n_v, double alpha, int side, const F& f) {
  const Ggx ggx{alpha};
  const dvec3 v = direction(n_v, 0);
  for (int i = 0; i < side; ++i) {
    // Warped towards the distribution's tail, which is what is seen at grazing angles.
    const double t = (i + 0.5) / side, u = 1 - (1 - t) * (1 - t) * (1 - t);
    const double warp = 3 * (1 - t) * (1 - t);
    const double cosine = 1 / std::sqrt(1 + alpha * alpha * u / (1 - u));
    for (int j = 0; j < side; ++j) {
      const dvec3 h = direction(cosine, 2 * kPi * (j + 0.5) / side);
      const double v_h = glm::dot(v, h);
      if (v_h <= 0) continue;
      const dvec3 l = 2 * v_h * h - v;
      if (l.z <= 0) continue;
      // pdf of l: D (n.h) / (4 v.h)
      const double weight = warp * ggx.dv(h.z, n_v, l.z) * l.z * 4 * v_h / (ggx.d(h.z) * h.z);
      f(l, v_h, weight / (side * side));
    }
  }
}

struct Moments {
  double a = 0, b = 0;
  dvec3 mean{0};
};
Moments lobeMoments(double n_v, double alpha, int side = 400) {
  Moments m;
  overLobe(n_v, alpha, side, [&](dvec3 l, double v_h, double weight) {
    const double w = std::pow(1 - v_h, 5);
    m.a += weight * (1 - w);
    m.b += weight * w;
    m.mean += weight * l;
  });
  m.mean /= m.a + m.b;
  return m;
}

TEST(Brdf, DistributionAndVisibilityFollowThePapers) {
  for (uint64_t i = 0; i < 20'000; ++i) {
    const double alpha = rules::alphaFromRoughness(static_cast<float>(unit(4, i, 0)));
    const double n_v = 0.01 + 0.99 * unit(4, i, 1), n_l = 0.01 + 0.99 * unit(4, i, 2);
    const double n_h = std::cos(unit(4, i, 3) * 1.5);
    const double expected = Ggx{alpha}.dv(n_h, n_v, n_l);
    const double got = rules::ggxDistributionVisibility(static_cast<float>(n_h), static_cast<float>(n_v),
                                                        static_cast<float>(n_l), static_cast<float>(alpha));
    // fp32 keeps 2 digits at the peak of the narrowest lobe.
    EXPECT_NEAR(got / expected, 1, 1e-5 + 4e-7 / (alpha * alpha)) << alpha << " " << n_h;
  }
}

TEST(Brdf, LobeTermsAreTheIntegrals) {
  double worst = 0;
  for (const float roughness : {0.045f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f})
    for (const double n_v : {0.02, 0.1, 0.3, 0.6, 0.95}) {
      const double alpha = rules::alphaFromRoughness(roughness);
      const Moments m = lobeMoments(n_v, alpha);
      const rules::LobeTerms t = integrateLobe(n_v, alpha, 8192);
      EXPECT_NEAR(t.a, m.a, 2e-3) << roughness << " " << n_v;
      EXPECT_NEAR(t.b, m.b, 2e-3) << roughness << " " << n_v;
      // The mean again as a vector: n (n.v) - v = -x sin.
      const double sine = std::sqrt(1 - n_v * n_v);
      EXPECT_NEAR(-t.tangent * sine, m.mean.x, 3e-3) << roughness << " " << n_v;
      EXPECT_NEAR(t.normal, m.mean.z, 3e-3) << roughness << " " << n_v;
      worst = std::max({worst, std::abs(t.a - m.a), std::abs(t.b - m.b)});
    }
  std::printf("worst difference between two quadratures: %.2e\n", worst);
}

TEST(Brdf, TableErrorIsAsStated) {
  const std::vector<vec4> table = makeLobeTable();
  ASSERT_EQ(table.size(), 1024u);
  double worst_a = 0, worst_b = 0, squares = 0, worst_mean = 0;
  int count = 0;
  // Dense at grazing angles, as the table is: it is worst there.
  constexpr int kSteps = 100;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double root = 0.055 + 0.945 * (i + 0.5) / kSteps, n_v = root * root;
      const float roughness = 0.045f + 0.955f * (static_cast<float>(j) + 0.5f) / kSteps;
      const rules::LobeTerms exact = integrateLobe(n_v, rules::alphaFromRoughness(roughness), 2048);
      const rules::LobeTerms t = sampleLobeTable(table, static_cast<float>(n_v), roughness);
      const double sine = std::sqrt(1 - n_v * n_v);
      worst_a = std::max<double>(worst_a, std::abs(t.a - exact.a));
      worst_b = std::max<double>(worst_b, std::abs(t.b - exact.b));
      worst_mean = std::max(worst_mean, std::hypot((t.tangent - exact.tangent) * sine, t.normal - exact.normal));
      squares += (t.a - exact.a) * (t.a - exact.a);
      ++count;
    }
  std::printf("table: a max %.4f rms %.5f, b max %.4f, mean direction max %.4f\n", worst_a,
              std::sqrt(squares / count), worst_b, worst_mean);
  EXPECT_LT(worst_a, 0.011);
  EXPECT_LT(worst_b, 0.023);
  EXPECT_LT(std::sqrt(squares / count), 0.0007);
  EXPECT_LT(worst_mean, 0.006);
  for (const vec4& t : table) {
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(std::isfinite(t[k]));
    EXPECT_TRUE(t.x >= 0 && t.y >= 0 && t.x + t.y <= 1.0005f) << t.x << " " << t.y;
  }
}

// The furnace: whatever the table says, albedo 1 gives back everything, and never more than that.
TEST(Brdf, WhiteSurfaceConservesEnergyExactly) {
  for (uint64_t i = 0; i < 100'000; ++i) {
    const auto a = static_cast<float>(unit(5, i, 0));
    const auto b = static_cast<float>(unit(5, i, 1)) * (1 - a);
    const auto metallic = static_cast<float>(unit(5, i, 2));
    const rules::Reflectance white = rules::reflectance(vec3(1), metallic, a, b);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(white.single[k] + white.diffuse[k], 1, 1e-5) << a << " " << b;
    const vec3 color(static_cast<float>(unit(5, i, 3)), static_cast<float>(unit(5, i, 4)), 0);
    const rules::Reflectance r = rules::reflectance(color, metallic, a, b);
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(r.diffuse[k], -1e-6f);
      EXPECT_LE(r.single[k] + r.diffuse[k], 1.00001f);
    }
  }
}

// The sun's beam, summed over a uniform sky of suns, is the sky's reflection: one model, two uses.
TEST(Brdf, BeamsSumToTheDirectionalAlbedo) {
  constexpr int kSide = 300;
  for (const float roughness : {0.3f, 0.6f, 1.0f})
    for (const float metallic : {0.0f, 0.5f, 1.0f})
      for (const double n_v : {0.1, 0.5, 0.9}) {
        const float alpha = rules::alphaFromRoughness(roughness);
        const rules::LobeTerms t = integrateLobe(n_v, alpha, 8192);
        const rules::Reflectance r = rules::reflectance(vec3(1, 0.5f, 0.1f), metallic, t.a, t.b);
        const dvec3 v = direction(n_v, 0);
        // Each part on a grid of its own: half vectors for the lobe, the hemisphere for the rest.
        dvec3 sum(0);
        rules::Reflectance specular = r;
        specular.diffuse = vec3(0);
        overLobe(n_v, alpha, kSide, [&](dvec3 l, double, double weight) {
          const dvec3 h = glm::normalize(l + v);
          const double dv = Ggx{alpha}.dv(h.z, n_v, l.z) * l.z;
          const vec3 f = rules::reflectBeam(specular, vec3(0, 0, 1), vec3(v), vec3(l), static_cast<float>(l.z), static_cast<float>(n_v), alpha);
          sum += dvec3(f) * (weight / dv);
        });
        for (int i = 0; i < kSide; ++i)
          for (int j = 0; j < kSide; ++j) {
            const dvec3 l = direction((i + 0.5) / kSide, 2 * kPi * (j + 0.5) / kSide);
            sum += dvec3(r.diffuse) * (l.z / kPi) * (2 * kPi / (kSide * kSide));
          }
        EXPECT_LT(maxOf(sum - dvec3(r.single + r.diffuse)), 4e-3) << roughness << " " << metallic << " " << n_v;
      }
}

TEST(Brdf, BeamIsFiniteAndZeroBelowTheHorizon) {
  for (uint64_t i = 0; i < 100'000; ++i) {
    const vec3 n(randomDirection(6, i, 0)), v(randomDirection(6, i, 2)), l(randomDirection(6, i, 4));
    const rules::Reflectance r = rules::reflectance(vec3(1), 1, 0.5f, 0.1f);
    const float n_v = glm::clamp(glm::dot(n, v), 1e-4f, 1.0f);
    const vec3 f = rules::reflectBeam(r, n, v, l, glm::dot(n, l), n_v, rules::alphaFromRoughness(0));
    EXPECT_TRUE(std::isfinite(f.x) && f.x >= 0);
    EXPECT_TRUE(glm::dot(n, l) > 0 || f == vec3(0));
    const vec3 opposite = rules::reflectBeam(r, n, v, -v, -glm::dot(n, v), n_v, rules::alphaFromRoughness(0));
    EXPECT_TRUE(std::isfinite(opposite.x));
  }
}

// Sky reflection by table against the integral of the whole model over the whole sky.
TEST(Brdf, SkyReflectionIsTheIntegral) {
  const std::vector<vec4> table = makeLobeTable();
  double worst = 0, worst_mirror = 0, squares = 0, squares_mirror = 0;
  int count = 0;
  for (uint64_t i = 0; i < 60; ++i) {
    const SkyColors& sky = kSkies[i % 2 * 2];
    const auto roughness = static_cast<float>(0.045 + 0.955 * unit(7, i, 0));
    const double n_v = 0.05 + 0.95 * unit(7, i, 1);
    const dvec3 n = randomDirection(7, i, 2);
    const glm::dmat3 frame = frameAround(n);
    const double alpha = rules::alphaFromRoughness(roughness);
    dvec3 single(0);
    double a = 0;
    overLobe(n_v, alpha, 300, [&](dvec3 l, double, double weight) {
      single += weight * skyReference(sky, frame * l);  // a mirror metal, F = 1
      a += weight;
    });
    const dvec3 expected = single / a;
    const auto terms = sampleLobeTable(table, static_cast<float>(n_v), roughness);
    rules::Reflectance r{};
    r.single = vec3(1);
    const dvec3 v = frame * direction(n_v, 0);
    const dvec3 got(rules::reflectSky(polynomial(sky), r, terms, vec3(n), vec3(v), static_cast<float>(n_v), roughness, vec2(n.y, n.y * n.y)));
    const dvec3 mirror = skyReference(sky, 2 * n_v * n - v);
    const double error = maxOf(got - expected), mirror_error = maxOf(mirror - expected);
    worst = std::max(worst, error);
    worst_mirror = std::max(worst_mirror, mirror_error);
    squares += error * error;
    squares_mirror += mirror_error * mirror_error;
    ++count;
  }
  std::printf("sky reflection of F = 1: max %.4f rms %.4f; by the mirror direction alone: max %.4f rms %.4f\n",
              worst, std::sqrt(squares / count), worst_mirror, std::sqrt(squares_mirror / count));
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(std::sqrt(squares / count), 0.015);
  EXPECT_GT(worst_mirror, 5 * worst);
}

}  // namespace
}  // namespace scree
