// The shared rules of impostors against closed forms, brute force and double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "engine/core/random.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/impostor.h"

namespace scree {
namespace {

using glm::dot;
using rules::ImpostorViews;

vec3 randomDirection(uint64_t k, uint64_t seed = 9) {
  for (uint64_t draw = 0;; draw += 3) {
    const vec3 v = vec3(randomUnit(seed, k, 0, draw), randomUnit(seed, k, 0, draw + 1),
                        randomUnit(seed, k, 0, draw + 2)) *
                       2.0f -
                   1.0f;
    if (dot(v, v) < 1 && dot(v, v) > 0.01f) return glm::normalize(v);
  }
}

// Weight of every view, by layer.
std::map<uint32_t, float> weightsOf(const ImpostorViews& v) {
  std::map<uint32_t, float> out;
  out[v.layer0] += v.weight.x;
  out[v.layer1] += v.weight.y;
  out[v.layer2] += v.weight.z;
  return out;
}
float distanceOf(const ImpostorViews& a, const ImpostorViews& b) {
  std::map<uint32_t, float> difference = weightsOf(a);
  for (const auto& [layer, weight] : weightsOf(b)) difference[layer] -= weight;
  float sum = 0;
  for (const auto& [layer, weight] : difference) sum += std::abs(weight);
  return sum;
}

TEST(ImpostorViews, LayersNumberTheLatticeOnceAndBackForEveryN) {
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    const int m = n - 1;
    std::set<uint32_t> seen;
    for (int k = -m; k <= m; ++k) {
      for (int j = -m; j <= m; ++j) {
        for (int i = -m; i <= m; ++i) {
          if (std::abs(i) + std::abs(j) + std::abs(k) != m) continue;
          const glm::ivec3 lattice(i, j, k);
          const uint32_t layer = rules::impostorLayer(lattice, m);
          ASSERT_LT(layer, static_cast<uint32_t>(rules::impostorViewCount(n)));
          ASSERT_TRUE(seen.insert(layer).second) << n << ": " << i << " " << j << " " << k;
          ASSERT_EQ(rules::impostorLattice(layer, n), lattice) << n;
        }
      }
    }
    ASSERT_EQ(static_cast<int>(seen.size()), rules::impostorViewCount(n));
  }
}

TEST(ImpostorViews, EveryBasisIsFiniteAndOrthonormalForEveryN) {
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    for (int layer = 0; layer < rules::impostorViewCount(n); ++layer) {
      const vec3 axis = rules::impostorViewDirection(static_cast<uint32_t>(layer), n);
      const rules::ImpostorBasis b = rules::impostorBasis(axis);
      ASSERT_TRUE(finite(axis) && finite(b.right) && finite(b.up));
      constexpr float kEps = 1e-6f;
      ASSERT_NEAR(dot(axis, axis), 1, kEps);
      ASSERT_NEAR(dot(b.right, b.right), 1, kEps);
      ASSERT_NEAR(dot(b.up, b.up), 1, kEps);
      ASSERT_NEAR(dot(b.right, b.up), 0, kEps);
      const vec3 across = glm::cross(b.right, b.up) - axis;
      ASSERT_LT(dot(across, across), kEps * kEps * 4);
    }
  }
}

TEST(ImpostorViews, AxesAreViewsThemselvesForEveryNAndSignOfZero) {
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      for (float sign : {1.0f, -1.0f}) {
        for (float zero : {0.0f, -0.0f}) {
          vec3 d(zero);
          d[axis] = sign;
          float largest = 0;
          for (const auto& [layer, weight] : weightsOf(rules::impostorViews(d, n))) {
            if (weight <= largest) continue;
            largest = weight;
            EXPECT_EQ(rules::impostorViewDirection(layer, n)[axis], sign);
          }
          EXPECT_EQ(largest, 1.0f);
        }
      }
    }
  }
}

// The triangle's views must be the three whose axes span the direction with positive weights.
TEST(ImpostorViews, WeightsAreThoseOfATriangleThatHoldsTheDirection) {
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    const auto views = static_cast<uint64_t>(rules::impostorViewCount(n));
    for (uint64_t k = 0; k < 2000 + views; ++k) {
      // Random ones, of which some lie on the circles where signs change, and every view itself.
      vec3 d = k < 2000 ? randomDirection(k)
                        : rules::impostorViewDirection(static_cast<uint32_t>(k - 2000), n);
      if (k < 2000 && k % 4 == 0) d[static_cast<int>(k / 4 % 3)] = k % 8 == 0 ? 0.0f : -0.0f;
      const ImpostorViews v = rules::impostorViews(d, n);
      ASSERT_NEAR(v.weight.x + v.weight.y + v.weight.z, 1, 1e-6f);
      ASSERT_GE(std::min({v.weight.x, v.weight.y, v.weight.z}), 0);
      const uint32_t layers[] = {v.layer0, v.layer1, v.layer2};
      const vec3 axes[] = {v.axis0, v.axis1, v.axis2};
      glm::dvec3 sum(0);
      const int m = n - 1;
      for (int c = 0; c < 3; ++c) {
        ASSERT_LT(layers[c], static_cast<uint32_t>(rules::impostorViewCount(n)));
        ASSERT_EQ(axes[c], rules::impostorViewDirection(layers[c], n));
        sum += glm::dvec3(rules::impostorLattice(layers[c], n)) / static_cast<double>(m) *
               static_cast<double>(v.weight[c]);
        // Neighbours: a lattice step from each other.
        const glm::ivec3 step = glm::abs(rules::impostorLattice(layers[c], n) -
                                         rules::impostorLattice(layers[(c + 1) % 3], n));
        ASSERT_EQ(step.x + step.y + step.z, 2);
      }
      // On the octahedron the weighted lattice points give the direction's own point.
      const double l1 = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(sum[c], d[c] / l1, 3e-6) << n;
    }
  }
}

// Across every border of the lattice, the equator and the poles: a step of one ulp changes the
// weights by ulps, and a step of an angle by no more than the lattice's spacing allows.
TEST(ImpostorViews, WeightsAreContinuousEverywhere) {
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    const float bound = 3e-6f * static_cast<float>(n);
    const auto expectNear = [&](vec3 a, vec3 b) {
      const float step = distanceOf(rules::impostorViews(a, n), rules::impostorViews(b, n));
      ASSERT_LT(step, bound) << n << ": " << a.x << " " << a.y << " " << a.z;
    };
    for (int k = 0; k < 720; ++k) {
      const float angle = static_cast<float>(k) * 0.00872664626f;
      const float c = std::cos(angle), s = std::sin(angle);
      for (int axis = 0; axis < 3; ++axis) {  // the three great circles where signs change
        vec3 on(0), above(0), below(0);
        on[(axis + 1) % 3] = above[(axis + 1) % 3] = below[(axis + 1) % 3] = c;
        on[(axis + 2) % 3] = above[(axis + 2) % 3] = below[(axis + 2) % 3] = s;
        for (float tiny : {std::numeric_limits<float>::denorm_min(), 1e-20f, 6e-8f}) {
          above[axis] = tiny;
          below[axis] = -tiny;
          expectNear(on, above);
          expectNear(on, below);
          on[axis] = -0.0f;
          expectNear(on, above);
          on[axis] = 0;
        }
      }
    }
    // Lattice points, edges and random places: each moved by one ulp along each axis.
    for (uint64_t k = 0; k < 1500; ++k) {
      vec3 d = k < 500
                   ? rules::impostorViewDirection(
                         static_cast<uint32_t>(randomBits(3, k, 0, 0) %
                                               static_cast<uint64_t>(rules::impostorViewCount(n))),
                         n)
                   : randomDirection(k, 21);
      if (k % 3 == 1) d[static_cast<int>(k / 3 % 3)] = d[static_cast<int>(k / 3 + 1) % 3];
      if (d == vec3(0)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        for (float to : {-2.0f, 2.0f}) {
          vec3 moved = d;
          moved[axis] = std::nextafter(moved[axis], to);
          expectNear(d, moved);
        }
      }
    }
  }
}

TEST(ImpostorViews, WhatHasNoDirectionTakesTheFirstAxisAndStaysFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              inf = std::numeric_limits<float>::infinity();
  for (int n : {2, 5, 33}) {
    for (const vec3 d :
         {vec3(0), vec3(nan, 0, 1), vec3(inf, 0, 0), vec3(-inf, inf, nan), vec3(1e-38f, 0, 0)}) {
      const ImpostorViews v = rules::impostorViews(d, n);
      EXPECT_EQ(v.weight.x, 1);
      EXPECT_EQ(v.axis0.z, 1);
      for (const vec3 axis : {v.axis0, v.axis1, v.axis2}) EXPECT_TRUE(finite(axis));
    }
    for (float scale : {1e-25f, 1.0f, 1e25f})
      EXPECT_LT(distanceOf(rules::impostorViews(vec3(0.3f, -0.5f, 0.7f) * scale, n),
                           rules::impostorViews(vec3(0.3f, -0.5f, 0.7f), n)),
                1e-5f * static_cast<float>(n));
  }
}

// The farthest that a direction can be from its nearest view; the paper's half octahedra of n x n
// squares leave 18.4 degrees at n = 8 (128 views).
TEST(ImpostorViews, ViewsAreNearerThanThoseOfSquareCells) {
  const auto farthest = [](int n) {
    float least = 1;
    for (uint64_t k = 0; k < 20000; ++k) {
      const vec3 d = randomDirection(k, 5);
      const ImpostorViews v = rules::impostorViews(d, n);
      least = std::min(least, std::max({dot(d, v.axis0), dot(d, v.axis1), dot(d, v.axis2)}));
    }
    return std::acos(least) * 57.29578f;
  };
  EXPECT_EQ(rules::impostorViewCount(6), 102);
  EXPECT_LT(farthest(6), 16);  // 102 views
  EXPECT_LT(farthest(7), 13);  // 146 views
}

// ---- Where a ray looks ----------------------------------------------------------------------

TEST(ImpostorRays, PointsLieOnTheRayAndOnTheirSurface) {
  const rules::ImpostorProxy proxy{vec4(0.05f, -0.1f, 0.02f, 0), vec4(1.2f, 1.9f, 1.5f, 0),
                                   vec4(0.3f, -0.2f, 0.15f, 0)};
  for (uint64_t k = 0; k < 20000; ++k) {
    const vec3 direction = randomDirection(k),
               origin = randomDirection(k, 2) * (3 * randomUnit(4, k, 0, 0));
    const rules::ImpostorRay ray = rules::impostorRay(origin, direction);
    ASSERT_NEAR(dot(ray.foot, ray.direction), 0, 1e-6f);
    const vec3 axis = randomDirection(k, 3);
    const auto offRay = [&](vec3 p) { return glm::length(glm::cross(p - origin, direction)); };
    const vec3 on_plane = rules::impostorOnPlane(ray, axis);
    ASSERT_LT(offRay(on_plane), 1e-5f);
    if (dot(direction, axis) < -0.1f) {
      ASSERT_NEAR(dot(on_plane, axis), 0, 2e-5f);
    }
    const vec3 on_sphere = rules::impostorOnSphere(ray, 0.8f);
    ASSERT_LT(offRay(on_sphere), 1e-5f);
    ASSERT_NEAR(glm::length(on_sphere), std::max(0.8f, glm::length(ray.foot)), 1e-5f);
    const vec3 on_proxy = rules::impostorOnProxy(ray, proxy);
    ASSERT_LT(offRay(on_proxy), 1e-5f);
    const auto metric = [&](vec3 p) {
      return glm::length(rules::impostorToProxy(proxy, p - vec3(proxy.center)));
    };
    // The nearest point of the ray by search, and the first of the two where it enters.
    float least = 1e9f;
    for (int i = -200; i <= 200; ++i)
      least = std::min(least, metric(ray.foot + ray.direction * (static_cast<float>(i) * 0.01f)));
    if (least < 0.98f) {
      ASSERT_NEAR(metric(on_proxy), 1, 2e-5f);
      ASSERT_GT(metric(on_proxy - ray.direction * 1e-2f), metric(on_proxy));
    } else if (least > 1.01f) {
      ASSERT_NEAR(metric(on_proxy), least, 1e-3f);
    }
    const vec3 stepped = rules::impostorStep(ray, on_proxy, axis, 0.3f);
    ASSERT_TRUE(finite(stepped));
    if (dot(direction, axis) < -0.25f) {
      ASSERT_NEAR(dot(stepped, axis), 0.3f, 2e-5f);
    }
  }
}

TEST(ImpostorRays, NothingJumpsAtTheSilhouetteOfTheEllipsoid) {
  const rules::ImpostorProxy proxy{vec4(0), vec4(1.5f, 2.2f, 1.1f, 0), vec4(0.4f, 0.1f, -0.3f, 0)};
  for (uint64_t k = 0; k < 200; ++k) {
    const vec3 axis = randomDirection(k, 6);
    const rules::ImpostorBasis basis = rules::impostorBasis(axis);
    vec3 before(0);
    for (int i = 0; i <= 4000; ++i) {
      const vec3 p = rules::impostorOnProxy(
          {basis.right * (static_cast<float>(i) * 2.5e-4f), axis * -1.0f}, proxy);
      // The depth falls as a square root of the distance to the silhouette.
      if (i > 0) {
        ASSERT_LT(glm::length(p - before), 0.06f);
      }
      before = p;
    }
  }
}

TEST(ImpostorRays, AnEyeInTheAxisSeesTheImageAsItIs) {
  constexpr int kTexels = 64;
  const float extent = rules::impostorExtent(kTexels);
  for (int layer = 0; layer < rules::impostorViewCount(5); ++layer) {
    const vec3 axis = rules::impostorViewDirection(static_cast<uint32_t>(layer), 5);
    const rules::ImpostorBasis basis = rules::impostorBasis(axis);
    const vec2 at(0.31f, -0.62f);
    const rules::ImpostorRay ray =
        rules::impostorRay(basis.right * at.x + basis.up * at.y + axis * 5.0f, axis * -1.0f);
    const vec3 points[] = {rules::impostorOnPlane(ray, axis), rules::impostorOnSphere(ray, 0.9f),
                           rules::impostorMixed(ray, axis, 0.9f),
                           rules::impostorStep(ray, ray.foot, axis, 0.2f)};
    for (const vec3& p : points) {
      const vec2 uv = rules::impostorUv(p, axis, extent);
      EXPECT_NEAR(uv.x, 0.5f + 0.5f * at.x / extent, 2e-6f);
      EXPECT_NEAR(uv.y, 0.5f + 0.5f * at.y / extent, 2e-6f);
    }
  }
  // The outer sphere ends a texel before the image does.
  EXPECT_NEAR((0.5f + 0.5f / extent) * kTexels, kTexels - 1, 1e-4f);
}

TEST(ImpostorLevel, IsTheSharpestThatIsNotMuchFinerThanThePicture) {
  EXPECT_EQ(rules::impostorLevel(64, 62, 0), 0);
  EXPECT_EQ(rules::impostorLevel(64, 31, 0), 1);
  EXPECT_EQ(rules::impostorLevel(64, 1000, 0), 0);
  EXPECT_EQ(rules::impostorLevel(64, 0, 0), 6);
  EXPECT_EQ(rules::impostorLevel(256, 4, -1), 5);
}

TEST(ImpostorCodes, ZeroAndTheEndsSurvive) {
  for (int code = 1; code < 256; ++code) {
    const float x = rules::impostorHeightFromCode(static_cast<float>(code) / 255.0f);
    EXPECT_NEAR(x, static_cast<float>(code - 128) / 127.0f, 1e-5f);
  }
  EXPECT_NEAR(rules::impostorHeightFromCode(128.0f / 255.0f), 0, 1e-7f);
}

}  // namespace
}  // namespace scree
