// Distance queries of hulls, meshes and grids against brute force in double.
#include <gtest/gtest.h>

#include <limits>

#include "modules/grains/grid_field.h"
#include "modules/grains/hull.h"
#include "modules/grains/triangle_surface.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

SharedField made(Result<SharedField> result) {
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error());
  return result.ok() ? *result : nullptr;
}

// Against the nearest triangle and the winding number; the normal leads to the surface.
void compareClosed(const DistanceField& field, const Soup& soup, uint64_t seed, int points, float size) {
  for (int k = 0; k < points; ++k) {
    const vec3 p = (unitCube(seed, static_cast<uint64_t>(k)) * 2.0f - 1.0f) * size;
    const SurfacePoint near = field.nearest(p);
    const double exact = bruteDistance(soup, p) * (windingNumber(soup, p) > 0.5 ? -1 : 1);
    ASSERT_NEAR(near.distance, exact, 2e-7 * size + 1e-6 * std::abs(exact)) << k;
    ASSERT_NEAR(glm::length(near.normal), 1, 1e-5);
    ASSERT_NEAR(bruteDistance(soup, dvec3(p) - dvec3(near.normal) * static_cast<double>(near.distance)), 0,
                2e-6 * size) << k;
    for (const float most : {0.3f * size, 3 * size}) {
      const float bounded = field.distance(p, most);
      if (near.distance < most) {
        ASSERT_EQ(bounded, near.distance);
      } else {
        ASSERT_GE(bounded, most);
      }
    }
  }
}

TEST(Mesh, SolidDistanceIsThatOfBruteForce) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const Soup soup = bumpySoup(3, seed);
    compareClosed(*made(makeMesh(soup, true, 0)), soup, 10 + seed, 600, 1.6f);
  }
  const Soup box = boxSoup({-1, -0.2f, -0.5f}, {0.7f, 0.3f, 0.5f});
  compareClosed(*made(makeMesh(box, true, 0)), box, 20, 2000, 1.5f);
}

TEST(Mesh, SheetDistanceIsThatOfBruteForce) {
  Soup soup;  // any triangles, crossing each other
  for (uint64_t k = 0; k < 300; ++k) {
    const vec3 at = 2.0f * unitCube(31, k);
    addTriangle(soup, at, at + 0.4f * (unitCube(32, k) - 0.5f), at + 0.4f * (unitCube(33, k) - 0.5f));
  }
  const SharedField sheet = made(makeMesh(soup, false, 0)), thick = made(makeMesh(soup, false, 0.1f));
  for (uint64_t k = 0; k < 3000; ++k) {
    const vec3 p = 3.0f * unitCube(34, k) - 0.5f;
    const SurfacePoint near = sheet->nearest(p);
    ASSERT_NEAR(near.distance, bruteDistance(soup, p), 1e-6) << k;
    ASSERT_NEAR(bruteDistance(soup, dvec3(p) - dvec3(near.normal) * static_cast<double>(near.distance)), 0, 3e-6);
    ASSERT_NEAR(thick->nearest(p).distance, near.distance - 0.05f, 1e-6);
    ASSERT_NEAR(sheet->distance(p, 0.2f), std::min(near.distance, std::max(0.2f, sheet->distance(p, 0.2f))), 1e-7);
    // `flat`: no other plane is nearest within it.
    if (near.flat > 0) {
      const vec3 q = p + (unitCube(35, k) - 0.5f) * (1.1f * near.flat);
      const double plane = static_cast<double>(near.distance) + glm::dot(dvec3(near.normal), dvec3(q) - dvec3(p));
      EXPECT_LE(bruteDistance(soup, q), std::abs(plane) + 1e-6);
    }
  }
}

// Points where the distance is least among all near it on the surface, by sampling.
TEST(Mesh, TouchesAreTheLeastDistancesAround) {
  const float s = 0.5f;
  Soup groove;  // a V of 90 degrees along z, each side of several triangles
  for (int k = -3; k < 3; ++k) {
    const float z0 = static_cast<float>(k), z1 = z0 + 1;
    addQuad(groove, {0, 0, z0}, {0, 0, z1}, {2 * s, 2 * s, z1}, {2 * s, 2 * s, z0});
    addQuad(groove, {-2 * s, 2 * s, z0}, {-2 * s, 2 * s, z1}, {0, 0, z1}, {0, 0, z0});
  }
  const SharedField field = made(makeMesh(groove, false, 0));
  SurfacePoint touch[DistanceField::kMostTouches];
  const uint32_t two = field->touches({0.05f, 0.3f, 0.37f}, 0.5f, touch);
  ASSERT_EQ(two, 2u);
  const float root = std::sqrt(0.5f);
  EXPECT_NEAR(touch[0].distance, 0.25f * root, 1e-6);
  EXPECT_NEAR(touch[1].distance, 0.35f * root, 1e-6);
  EXPECT_LT(glm::length(touch[0].normal - vec3(-root, root, 0)), 1e-5f);
  EXPECT_LT(glm::length(touch[1].normal - vec3(root, root, 0)), 1e-5f);
  EXPECT_EQ(field->touches({0.05f, 0.3f, 0.37f}, 0.2f, touch), 1u);
  EXPECT_EQ(field->touches({0.05f, 0.3f, 0.37f}, 0.1f, touch), 0u);
  // Over the convex side there is one: the edge.
  EXPECT_EQ(field->touches({0.01f, -0.2f, 0.37f}, 0.5f, touch), 1u);
  EXPECT_LT(glm::length(touch[0].normal - glm::normalize(vec3(0.01f, -0.2f, 0))), 1e-4f);

  const SharedField flat = made(makeMesh(floorSoup(1, 20, [](float, float) { return 0.25f; }), false, 0));
  for (uint64_t k = 0; k < 3000; ++k) {
    // On corners and edges of triangles too.
    vec3 p = 1.8f * unitCube(41, k) - 0.9f;
    if (k % 3 == 0) p.x = 0.1f * std::round(10 * p.x);
    if (k % 5 == 0) p.z = 0.1f * std::round(10 * p.z);
    p.y = 0.25f + (k % 2 == 0 ? 0.1f : -0.1f);
    ASSERT_EQ(flat->touches(p, 0.3f, touch), 1u) << k;
    ASSERT_NEAR(std::abs(touch[0].normal.y), 1, 1e-5) << k;
  }
}

// In a pipe that is wider than the sphere, of facets: their edges come nearer only beside the touch.
TEST(Mesh, EdgesOfAHollowDoNotTouch) {
  constexpr int kFacets = 90;
  Soup pipe;
  const auto around = [](int k, float z) {
    const double a = 2 * kPi * (k % kFacets) / kFacets;
    return vec3(std::sin(a), 1 - std::cos(a), z);
  };
  for (int k = 0; k < kFacets; ++k)
    for (int j = -3; j < 3; ++j) {
      const float z0 = 0.3f * static_cast<float>(j), z1 = z0 + 0.3f;
      addQuad(pipe, around(k, z0), around(k, z1), around(k + 1, z1), around(k + 1, z0));
    }
  const SharedField field = made(makeMesh(pipe, false, 0));
  SurfacePoint touch[DistanceField::kMostTouches];
  for (uint64_t k = 0; k < 3000; ++k) {
    const float a = static_cast<float>(2 * kPi) * unit(87, k, 0), r = 0.05f + 0.2f * unit(87, k, 1);
    const vec3 p = vec3(0, 1, 0.8f * (unit(87, k, 2) - 0.5f)) + (1 - r) * vec3(std::sin(a), -std::cos(a), 0);
    const uint32_t n = field->touches(p, 1.6f * r, touch);
    ASSERT_GE(n, 1u) << k;
    for (uint32_t t = 0; t < n; ++t)
      EXPECT_TRUE(touch[t].flat > 0 || touch[t].distance < touch[0].distance + 1e-5f) << k;
  }
}

TEST(Hull, HoldsAllPointsAndIsTheSmallest) {
  const auto check = [](const std::vector<vec3>& points, const char* what) {
    std::vector<vec3> corners;
    ASSERT_EQ(convexHull(points, corners), "") << what;
    TriangleSurface surface;
    ASSERT_EQ(surface.build(corners), "") << what;
    EXPECT_TRUE(surface.closed()) << what;
    // Euler: triangles of a closed surface without holes.
    EXPECT_EQ(surface.triangles() + surface.skipped(), 2 * (surface.vertices().size() - 2)) << what;
    double size = 0;
    for (const vec3 p : points) size = std::max(size, static_cast<double>(glm::length(p)));
    for (size_t k = 0; k < corners.size(); k += 3) {
      const dvec3 a(corners[k]), n = glm::normalize(glm::cross(dvec3(corners[k + 1]) - a, dvec3(corners[k + 2]) - a));
      for (const vec3 p : points) ASSERT_LE(glm::dot(n, dvec3(p) - a), 1e-9 * size) << what;
    }
    for (const vec3 v : surface.vertices())
      ASSERT_NE(std::find(points.begin(), points.end(), v), points.end()) << what;
  };
  std::vector<vec3> points;
  for (uint64_t k = 0; k < 500; ++k) points.push_back(unitCube(51, k));
  check(points, "random");
  for (vec3& p : points) p = glm::normalize(p - 0.5f) * 3.0f + 100.0f;
  check(points, "on a sphere, far away");
  points.clear();
  for (int k = 0; k < 1000; ++k)
    points.push_back({static_cast<float>(k % 10), static_cast<float>(k / 10 % 10), static_cast<float>(k / 100)});
  check(points, "a lattice");
  for (vec3& p : points) p = turnOf(52, 1) * (p * vec3(0.1f, 0.001f, 1));
  check(points, "a thin lattice, turned");
  points.clear();
  for (int k = 0; k < 64; ++k) {
    const float a = static_cast<float>(2 * kPi * k / 64);
    for (const float y : {-0.5f, 0.5f}) points.push_back({std::cos(a), y, std::sin(a)});
  }
  check(points, "a cylinder");
  for (int k = 0; k < 300; ++k) points.push_back(0.3f * unitCube(53, static_cast<uint64_t>(k)));
  check(points, "a cylinder with points inside");
}

TEST(Hull, DistanceIsThatOfBruteForce) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::vector<vec3> points;
    const int count = seed < 3 ? 5 : 40;
    for (int k = 0; k < count; ++k)
      points.push_back((unitCube(60 + seed, static_cast<uint64_t>(k)) - 0.5f) * vec3(2, seed == 6 ? 0.01f : 1, 1));
    std::vector<vec3> corners;
    ASSERT_EQ(convexHull(points, corners), "");
    compareClosed(*made(makeHull(points)), corners, 70 + seed, 800, 1.5f);
  }
}

TEST(Hull, WithoutVolumeIsRefused) {
  const auto fault = [](const std::vector<vec3>& points) { return makeHull(points); };
  EXPECT_FALSE(fault({}).ok());
  EXPECT_FALSE(fault({{1, 2, 3}}).ok());
  EXPECT_FALSE(fault({{1, 2, 3}, {1, 2, 3}, {2, 3, 4}, {3, 4, 5}}).ok());
  std::vector<vec3> plane;
  for (uint64_t k = 0; k < 100; ++k) plane.push_back(turnOf(1, 1) * (unitCube(2, k) * vec3(1, 0, 1)));
  const Result<SharedField> refused = fault(plane);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("lie in a plane"), std::string::npos) << refused.error();
  EXPECT_FALSE(fault({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, std::nanf("")}}).ok());
}

TEST(Mesh, TrianglesWithoutAreaAreSkipped) {
  Soup soup = bumpySoup(2, 9);
  const Soup clean = soup;
  for (uint64_t k = 0; k < 50; ++k) {
    const vec3 a = 3.0f * unitCube(81, k), b = 3.0f * unitCube(82, k);
    addTriangle(soup, a, a, b);
    addTriangle(soup, a, a, a);
    addTriangle(soup, a, b, a + 2.0f * (b - a));
  }
  TriangleSurface surface;
  ASSERT_EQ(surface.build(soup), "");
  EXPECT_GE(surface.skipped(), 140u);
  const SharedField field = made(makeMesh(clean, true, 0));
  for (uint64_t k = 0; k < 500; ++k) {
    const vec3 p = 3.0f * unitCube(83, k) - 1.5f;
    EXPECT_NEAR(std::sqrt(surface.nearest(p, 1e9).square), bruteDistance(clean, p), 1e-5) << k;
  }
  Soup none;
  addTriangle(none, {0, 0, 0}, {1, 1, 1}, {2, 2, 2});
  EXPECT_FALSE(makeMesh(none, false, 0).ok());
  EXPECT_FALSE(makeMesh({}, false, 0).ok());
}

// A wedge whose edge is cracked and filled with triangles that have no area: inside stays inside.
TEST(Mesh, FilledCracksDoNotConfuseTheSides) {
  const vec3 a(0, 0, -1), b(0, 0, 1), middle(0, 0, 0.25f), low(-2, -0.2f, 0), high(-2, 0.2f, 0);
  Soup soup;
  addTriangle(soup, b, a, high);  // the upper face, in one; the lower one in two
  addTriangle(soup, middle, b, low);
  addTriangle(soup, a, middle, low);
  addTriangle(soup, a, b, middle);  // between them
  addTriangle(soup, high, a, low);
  addTriangle(soup, b, high, low);
  TriangleSurface surface;
  ASSERT_EQ(surface.build(soup), "");
  EXPECT_EQ(surface.skipped(), 1u);
  EXPECT_TRUE(surface.closed());
  const SharedField solid = made(makeMesh(soup, true, 0));
  for (uint64_t k = 0; k < 4000; ++k) {
    const vec3 p = 4.0f * (unitCube(85, k) - 0.5f);
    const double exact = bruteDistance(soup, p) * (windingNumber(soup, p) > 0.5 ? -1 : 1);
    ASSERT_NEAR(solid->nearest(p).distance, exact, 1e-5) << k;
  }
}

// Triangles that do not share their corners: cracks and T-junctions in a flat floor are not felt.
TEST(Mesh, CracksInAFloorDoNotTouch) {
  Soup soup;
  for (int k = -5; k < 5; ++k) {
    const float x = 0.2f * static_cast<float>(k), shift = 0.1f * static_cast<float>(k % 2);
    for (int j = -6; j < 6; ++j) {
      const float z = 0.2f * static_cast<float>(j) + shift;
      addQuad(soup, {x, 0, z}, {x, 0, z + 0.2f}, {x + 0.2f, 0, z + 0.2f}, {x + 0.2f, 0, z});
    }
  }
  const SharedField field = made(makeMesh(soup, false, 0));
  SurfacePoint touch[DistanceField::kMostTouches];
  for (uint64_t k = 0; k < 3000; ++k) {
    const vec3 p = vec3(1.6f, 0, 1.6f) * (unitCube(86, k) - 0.5f) + vec3(0, 0.05f, 0);
    ASSERT_EQ(field->touches(p, 0.2f, touch), 1u) << k;
    ASSERT_NEAR(touch[0].normal.y, 1, 1e-4) << k;
  }
}

TEST(Mesh, RefusalsSayWhy) {
  Soup open = boxSoup(vec3(-1), vec3(1));
  open.resize(open.size() - 3);
  for (const Result<SharedField>& refused : {makeMesh(open, true, 0), bakeMesh(open, 16)}) {
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().find("not closed"), std::string::npos) << refused.error();
  }
  EXPECT_TRUE(makeMesh(open, false, 0).ok());
  Soup inside_out = boxSoup(vec3(-1), vec3(1));
  std::swap(inside_out[0], inside_out[1]);
  EXPECT_FALSE(makeMesh(inside_out, true, 0).ok());
  const Soup big(3 * (kMostTriangles + 1), vec3(1));
  const Result<SharedField> refused = makeMesh(big, false, 0);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("allowed are 1048576"), std::string::npos) << refused.error();
  Soup wild = boxSoup(vec3(-1), vec3(1));
  wild[4].y = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(makeMesh(wild, false, 0).ok());
}

TEST(Grid, IsExactForPlanesAndCloseForSpheres) {
  const vec3 n = glm::normalize(vec3(0.3f, 0.8f, -0.5f));
  const SharedField plane = made(sampleDistance([&](vec3 p) { return glm::dot(n, p) - 0.1f; }, vec3(-1), vec3(1), 0.13f));
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec3 p = 2.0f * unitCube(91, k) - 1.0f;
    const SurfacePoint near = plane->nearest(p);
    EXPECT_NEAR(near.distance, glm::dot(n, p) - 0.1f, 1e-6);
    EXPECT_LT(glm::length(near.normal - n), 1e-5f);
  }
  // The error of linear interpolation: cell^2 / (8 r) along each of two axes.
  for (const float cell : {0.2f, 0.1f, 0.05f}) {
    const SharedField ball = made(sampleDistance([](vec3 p) { return glm::length(p) - 1; }, vec3(-1.5f), vec3(1.5f), cell));
    for (uint64_t k = 0; k < 1000; ++k) {
      const vec3 p = glm::normalize(unitCube(92, k) - 0.5f) * (0.8f + 0.4f * unit(92, k, 7));
      EXPECT_NEAR(ball->nearest(p).distance, glm::length(p) - 1, cell * cell / (4 * 0.8f));
    }
    // Outside the grid it is never too far, and no less than the way to the grid.
    const auto [low, high] = ball->bounds();
    for (uint64_t k = 0; k < 1000; ++k) {
      const vec3 p = glm::normalize(unitCube(93, k) - 0.5f) * (3 + 50 * unit(93, k, 7));
      const float d = ball->nearest(p).distance;
      EXPECT_LE(d, glm::length(p) - 1 + cell * cell);
      EXPECT_GE(d, 0.99999f * glm::length(p - glm::clamp(p, low, high)));
    }
  }
}

TEST(Grid, BakedMeshNearsTheMesh) {
  const Soup soup = bumpySoup(4, 5);
  double worst_before = 1e9;
  for (const int resolution : {12, 24, 48}) {
    const SharedField baked = made(bakeMesh(soup, resolution));
    double worst = 0;
    for (uint64_t k = 0; k < 1500; ++k) {
      const vec3 p = 1.2f * (2.0f * unitCube(95, k) - 1.0f);
      const double exact = bruteDistance(soup, p) * (windingNumber(soup, p) > 0.5 ? -1 : 1);
      if (std::abs(exact) < 0.1) worst = std::max(worst, std::abs(static_cast<double>(baked->nearest(p).distance) - exact));
    }
    // Half a cell's diagonal, whatever changes no faster than it moves.
    const auto [low, high] = baked->bounds();
    const double cell = static_cast<double>(high.x - low.x) / resolution;
    EXPECT_LT(worst, 0.5 * std::sqrt(3.0) * cell) << resolution;
    EXPECT_LT(worst, 0.7 * worst_before) << resolution;
    worst_before = worst;
  }
}

TEST(Grid, RefusalsSayWhy) {
  const auto zero = [](vec3) { return 0.0f; };
  EXPECT_FALSE(sampleDistance(zero, vec3(0), vec3(1), 0).ok());
  EXPECT_FALSE(sampleDistance(zero, vec3(0), vec3(1, 0, 1), 0.1f).ok());
  EXPECT_FALSE(sampleDistance(zero, vec3(0), vec3(1), 1e-4f).ok());
  EXPECT_FALSE(sampleDistance(zero, vec3(0), vec3(std::nanf("")), 0.1f).ok());
  const Result<SharedField> refused = sampleDistance([](vec3 p) { return p.x > 0.5f ? std::nanf("") : p.y; }, vec3(0), vec3(1), 0.25f);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("not finite"), std::string::npos) << refused.error();
}

// A million points, from the surface itself to the edge of what a float holds.
TEST(Fields, AMillionPointsHaveFiniteAnswers) {
  const Soup soup = bumpySoup(2, 3);
  std::vector<SharedField> fields{made(makeHull(soup)), made(makeMesh(soup, true, 0)), made(makeMesh(soup, false, 0.02f)),
                                  made(bakeMesh(soup, 16))};
  SurfacePoint touch[DistanceField::kMostTouches];
  for (uint64_t k = 0; k < 250'000; ++k) {
    vec3 p = unitCube(97, k) * 2.0f - 1.0f;
    switch (k % 8) {
      case 0: p = soup[k / 8 % soup.size()]; break;  // a vertex
      case 1: {  // an edge, or a place of a face
        const size_t t = k / 8 % (soup.size() / 3) * 3;
        p = k % 16 < 8 ? 0.5f * (soup[t] + soup[t + 1]) : (soup[t] + soup[t + 1] + soup[t + 2]) / 3.0f;
        break;
      }
      case 2: p *= 1e3f; break;
      case 3: p *= std::pow(10.0f, 37 * unit(97, k, 5)); break;
      case 4: p *= std::pow(10.0f, -37 * unit(97, k, 5)); break;
      default: p *= 1.5f;
    }
    for (const SharedField& field : fields) {
      const SurfacePoint near = field->nearest(p);
      ASSERT_TRUE(std::isfinite(near.distance) && std::isfinite(near.flat)) << k;
      ASSERT_NEAR(glm::length(near.normal), 1, 1e-3) << k;
      const uint32_t n = field->touches(p, 0.3f, touch);
      ASSERT_LE(n, field->mostTouches());
      for (uint32_t t = 0; t < n; ++t) {
        ASSERT_TRUE(std::isfinite(touch[t].distance));
        ASSERT_NEAR(glm::length(touch[t].normal), 1, 1e-3) << k;
      }
    }
  }
}

}  // namespace
}  // namespace scree::grains::test
