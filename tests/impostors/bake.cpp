// The bake: spheres, rasteriser, texels, mip levels, determinism, refusals, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "modules/impostors/bounding_ellipsoid.h"
#include "modules/impostors/cast.h"
#include "modules/impostors/texels.h"
#include "shaders/shared/gbuffer.h"
#include "tests/impostors/shapes.h"

namespace scree {
namespace {

using namespace impostors;
using test::globe;
using test::grainOf;
using test::plain;

constexpr BakeParameters kSmall{.edge = 3, .texels = 16, .supersample = 4, .directions = 0};

// ---- Spheres --------------------------------------------------------------------------------

TEST(ImpostorSpheres, EnclosingSphereIsTheSmallest) {
  for (uint64_t k = 0; k < 200; ++k) {
    std::vector<dvec3> points;
    const size_t count = 2 + k % 40;
    for (size_t i = 0; i < count; ++i)
      points.emplace_back(randomUnit(k, i, 0, 0), 0.3 * randomUnit(k, i, 0, 1),
                          k % 7 == 0 ? 0.0 : 2.0 * randomUnit(k, i, 0, 2));
    const Sphere sphere = enclosingSphere(points);
    double farthest = 0;
    for (const dvec3& p : points) farthest = std::max(farthest, glm::length(p - sphere.center));
    EXPECT_NEAR(farthest, sphere.radius, 1e-9);
    // Smallest: no step of the centre brings the farthest point nearer.
    for (uint64_t s = 0; s < 60; ++s) {
      const dvec3 step =
          (dvec3(randomUnit(77, s, 0, 0), randomUnit(77, s, 0, 1), randomUnit(77, s, 0, 2)) - 0.5) *
          0.02;
      double moved = 0;
      for (const dvec3& p : points) moved = std::max(moved, glm::length(p - sphere.center - step));
      EXPECT_GE(moved, sphere.radius - 1e-9);
    }
  }
}

TEST(ImpostorSpheres, CoincidentCollinearAndCocircularPointsAreBorne) {
  EXPECT_EQ(enclosingSphere(std::vector<dvec3>(1000, dvec3(3, 4, 5))).radius, 0);
  std::vector<dvec3> line, circle;
  for (int i = 0; i <= 100; ++i) line.emplace_back(i * 0.1, i * 0.2, 0);
  EXPECT_NEAR(enclosingSphere(line).radius, 0.5 * std::sqrt(100.0 + 400.0), 1e-9);
  for (int i = 0; i < 500; ++i)
    circle.emplace_back(std::cos(i * 0.0125663706), std::sin(i * 0.0125663706), 7);
  EXPECT_NEAR(enclosingSphere(circle).radius, 1, 1e-9);
}

TEST(ImpostorSpheres, InnerRadiusOfABallIsTheWayToItsSurfaceAndNoneOutside) {
  const MeshData ball = globe(48);
  Corners corners;
  for (uint32_t i : ball.indices) corners.emplace_back(ball.vertices[i].position);
  // Flat triangles lie inside the sphere by the versed sine of half a band.
  EXPECT_NEAR(innerRadius(corners, dvec3(0)), 1, 0.003);
  EXPECT_NEAR(innerRadius(corners, dvec3(0.5, 0, 0)), 0.5, 0.003);
  EXPECT_EQ(innerRadius(corners, dvec3(1.2, 0, 0)), 0);
  EXPECT_EQ(innerRadius({}, dvec3(0)), 0);
}

TEST(ImpostorSpheres, ProxyOfAnEllipsoidIsThatEllipsoid) {
  const glm::dmat3 turn(glm::mat3_cast(glm::normalize(quat(0.8f, 0.3f, -0.4f, 0.2f))));
  const dvec3 axes(0.9, 0.35, 0.6), center(0.05, -0.03, 0.08);
  const MeshData ball = globe(64, [&](vec3 p) { return vec3(turn * (dvec3(p) * axes) + center); });
  Corners corners;
  for (uint32_t i : ball.indices) corners.emplace_back(ball.vertices[i].position);
  const rules::ImpostorProxy proxy = proxyOf(corners, 0.5);
  for (const Vertex& v : ball.vertices)
    EXPECT_NEAR(glm::length(rules::impostorToProxy(proxy, v.position - vec3(proxy.center))), 1,
                4e-3f);
  std::swap(corners[0], corners[1]);
  for (size_t t = 3; t < corners.size(); t += 3) std::swap(corners[t], corners[t + 1]);
  EXPECT_NEAR(proxyOf(corners, 0.5).diagonal.x, 2, 1e-6f);  // inside out: the sphere
}

double volumeOf(const rules::Ellipsoid& e) {
  return static_cast<double>(glm::length(vec3(e.axis_a)) * glm::length(vec3(e.axis_b)) * glm::length(vec3(e.axis_c)));
}

TEST(BoundingEllipsoid, OfAnEllipsoidIsThatEllipsoid) {
  const glm::dmat3 turn(glm::mat3_cast(glm::normalize(quat(0.8f, 0.3f, -0.4f, 0.2f))));
  const dvec3 axes(0.9, 0.35, 0.6), center(0.05, -0.03, 0.08);
  const MeshData ball = globe(64, [&](vec3 p) { return vec3(turn * (dvec3(p) * axes) + center); });
  std::vector<dvec3> points;
  for (const Vertex& v : ball.vertices) points.emplace_back(v.position);
  const rules::Ellipsoid e = boundingEllipsoid(points);
  EXPECT_LT(glm::distance(vec3(e.center), vec3(center)), 5e-3f);
  EXPECT_NEAR(volumeOf(e), 0.9 * 0.35 * 0.6, 0.015 * 0.9 * 0.35 * 0.6);
  for (const dvec3& p : points) EXPECT_LE(glm::length(rules::toBall(e, vec3(p) - vec3(e.center))), 1.0f);
  // What leads to the ball leads back.
  const vec3 v(0.3f, -0.7f, 0.2f);
  EXPECT_LT(glm::distance(rules::fromBall(e, rules::toBall(e, v)), v), 1e-5f);
}

TEST(BoundingEllipsoid, HoldsWhatIsFlatOrALineOrAPointOrRound) {
  const auto holds = [](const std::vector<dvec3>& points) {
    const rules::Ellipsoid e = boundingEllipsoid(points);
    for (const dvec3& p : points) EXPECT_LE(glm::length(rules::toBall(e, vec3(p) - vec3(e.center))), 1 + 2e-7f);
    EXPECT_LT(e.center.w, 1.75f);
    return volumeOf(e);
  };
  EXPECT_LT(holds({{-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}}), 0.1);
  EXPECT_LT(holds({{-0.6, 0, 0.8}, {0.6, 0, -0.8}}), 0.02);
  EXPECT_LT(holds({{0, 0, 0}}), 0.001);
  EXPECT_LT(holds({{0, 0, 1}}), 0.02);
  std::vector<dvec3> round;
  for (const Vertex& v : globe(24).vertices) round.emplace_back(v.position);
  EXPECT_EQ(holds(round), 1);
}

TEST(ImpostorSpheres, RadiiOfTheBakeHoldTheWholeMeshAndNothingLiesInside) {
  for (const char* name : {"coffee_bean.glb", "pebble.glb", "bolt.glb"}) {
    const GrainMesh grain = test::model(name);
    Result<ImpostorAtlas> atlas = bake(grain, kSmall);
    ASSERT_TRUE(atlas.ok()) << atlas.error();
    EXPECT_GT(atlas->inner, 0.2f) << name;
    double nearest = 1e9;
    for (const MeshData& part : grain.parts) {
      for (size_t t = 0; t < part.indices.size(); t += 3) {
        const auto at = [&](size_t k) {
          return dvec3(part.vertices[part.indices[t + k]].position) - dvec3(atlas->center);
        };
        for (size_t k = 0; k < 3; ++k)
          EXPECT_LE(glm::length(at(k)), static_cast<double>(atlas->outer)) << name;
        nearest = std::min(nearest, distanceToTriangle(dvec3(0), at(0), at(1), at(2)));
      }
    }
    EXPECT_LE(static_cast<double>(atlas->inner) * static_cast<double>(atlas->outer), nearest)
        << name;
    EXPECT_GE(static_cast<double>(atlas->inner) * static_cast<double>(atlas->outer),
              nearest * 0.9999)
        << name;
  }
}

// ---- Rasteriser -----------------------------------------------------------------------------

TEST(ImpostorCast, EverySampleSeesWhatARayThroughItMeetsFirst) {
  const GrainMesh grain = test::model("bolt.glb");
  Result<UnitGrain> unit = unitGrain(grain);
  ASSERT_TRUE(unit.ok());
  int compared = 0, differing = 0;
  for (int layer : {0, 3, 9, 17}) {
    const vec3 axis = rules::impostorViewDirection(static_cast<uint32_t>(layer), 3);
    const rules::ImpostorBasis basis = rules::impostorBasis(axis);
    const Shot shot{dvec3(axis), dvec3(basis.right), dvec3(basis.up), 1.1, 96};
    std::vector<Seen> seen;
    cast(*unit, shot, seen);
    for (int y = 0; y < 96; y += 3) {
      for (int x = 0; x < 96; x += 3) {
        const double px = ((x + 0.5) / 96 * 2 - 1) * 1.1, py = ((y + 0.5) / 96 * 2 - 1) * 1.1;
        double best = -10;
        for (size_t t = 0; t < unit->corners.size(); t += 3) {
          const dvec3 &a = unit->corners[t], &b = unit->corners[t + 1], &c = unit->corners[t + 2];
          // Moeller and Trumbore 1997, from far away towards the centre.
          const dvec3 origin = shot.right * px + shot.up * py + shot.axis * 5.0, d = -shot.axis;
          const dvec3 e1 = b - a, e2 = c - a, p = glm::cross(d, e2);
          const double det = glm::dot(e1, p);
          if (det <= 1e-12) continue;
          const dvec3 s = origin - a, q = glm::cross(s, e1);
          const double u = glm::dot(s, p) / det, v = glm::dot(d, q) / det;
          if (u < 0 || v < 0 || u + v > 1) continue;
          best = std::max(best, 5.0 - glm::dot(e2, q) / det);
        }
        const Seen& s = seen[static_cast<size_t>(y * 96 + x)];
        ++compared;
        if ((s.triangle >= 0) != (best > -5) ||
            (s.triangle >= 0 && std::abs(static_cast<double>(s.height) - best) > 0.02))
          ++differing;
      }
    }
  }
  // Corners are rounded to 1/256 of a sample: a sample as near as that to an edge may see past it.
  EXPECT_GT(compared, 4000);
  EXPECT_LE(differing, compared / 250);
}

TEST(ImpostorCast, TrianglesThatShareEdgesCoverASquareOnceAndWholly) {
  // A fan around a point that lies on no grid; seen along its normal, its area is the count of
  // samples.
  std::vector<vec3> corners;
  const vec3 middle(0.0317f, -0.0713f, 0);
  for (int k = 0; k < 32; ++k) {
    const auto rim = [](int i) {
      const float t = static_cast<float>(i % 32) / 8.0f;
      const float f = 2 * (t - std::floor(t)) - 1;
      return i % 32 < 8    ? vec3(f, -1, 0)
             : i % 32 < 16 ? vec3(1, f, 0)
             : i % 32 < 24 ? vec3(-f, 1, 0)
                           : vec3(-1, -f, 0);
    };
    for (const vec3& p : {middle, rim(k), rim(k + 1)}) corners.push_back(p);
  }
  // And two halves whose common edge runs through the centres of samples.
  const std::vector<vec3> halves = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0},
                                    {-1, -1, 0}, {1, 1, 0},  {-1, 1, 0}};
  for (const std::vector<vec3>& square : {corners, halves}) {
    const GrainMesh grain = grainOf(test::soup(square));
    Result<UnitGrain> unit = unitGrain(grain);
    ASSERT_TRUE(unit.ok()) << unit.error();
    const Shot shot{.extent = 2, .samples = 200};
    const auto covered = [&shot](const UnitGrain& drawn) {
      std::vector<Seen> seen;
      cast(drawn, shot, seen);
      return std::ranges::count_if(seen, [](const Seen& s) { return s.triangle >= 0; });
    };
    std::ptrdiff_t sum = 0;
    for (const UnitTriangle& triangle : unit->triangles) {
      UnitGrain alone = *unit;
      alone.triangles = {triangle};
      sum += covered(alone);
    }
    EXPECT_EQ(sum, covered(*unit));  // none twice
    // Half the square's side is 50 / sqrt(2) = 35.4 samples: 35 centres on either side of its
    // middle.
    EXPECT_EQ(sum, 70 * 70);
  }
}

TEST(ImpostorCast, BackFacesAreSeenOnlyOfDoubleSidedMaterials) {
  const MeshData sheet = test::soup({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}});
  for (bool twice : {false, true}) {
    MaterialData material = plain({1, 0, 0});
    material.double_sided = twice;
    const GrainMesh grain = grainOf(sheet, material);
    Result<UnitGrain> unit = unitGrain(grain);
    ASSERT_TRUE(unit.ok());
    std::vector<Seen> seen;
    cast(*unit, {.axis = {0, 0, -1}, .right = {-1, 0, 0}, .extent = 1.2, .samples = 32}, seen);
    const auto found = std::ranges::find_if(seen, [](const Seen& s) { return s.triangle >= 0; });
    EXPECT_EQ(found != seen.end(), twice);
    if (found == seen.end()) continue;
    EXPECT_EQ(surfaceAt(*unit, unit->triangles[0], found->b, found->c, found->flipped).normal.z,
              -1);
  }
}

// ---- Texels ---------------------------------------------------------------------------------

vec3 albedoAt(const ImpostorAtlas& a, uint64_t texel) {
  return rules::albedoFromCode(
      vec3(a.color[texel * 4], a.color[texel * 4 + 1], a.color[texel * 4 + 2]) / 255.0f);
}
vec3 normalAt(const ImpostorAtlas& a, uint64_t texel) {
  return rules::impostorNormalFromCode(
      vec3(a.normal[texel * 4], a.normal[texel * 4 + 1], a.normal[texel * 4 + 2]) / 255.0f);
}

TEST(ImpostorBake, ASphereHasItsNormalsHeightsAndArea) {
  const float radius = 0.02f;
  Result<ImpostorAtlas> atlas =
      bake(grainOf(globe(96, [&](vec3 p) { return p * radius + vec3(0.7f, 0.8f, 0.9f); })),
           {.edge = 3, .texels = 64, .directions = 0});
  ASSERT_TRUE(atlas.ok()) << atlas.error();
  EXPECT_NEAR(atlas->outer, radius, 1e-5f);
  EXPECT_NEAR(atlas->inner, 1, 1e-3f);
  const float extent = rules::impostorExtent(64);
  for (int layer = 0; layer < atlas->views(); ++layer) {
    const vec3 axis = rules::impostorViewDirection(static_cast<uint32_t>(layer), 3);
    const rules::ImpostorBasis basis = rules::impostorBasis(axis);
    double area = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const uint64_t texel = atlas->offset(0, layer) + static_cast<uint64_t>(y * 64 + x);
        area += atlas->shape[texel * 2] / 255.0;
        const vec2 at = ((vec2(x, y) + 0.5f) / 32.0f - 1.0f) * extent;
        const float inside = 1 - glm::dot(at, at);
        if (inside < 0.3f) continue;
        ASSERT_EQ(atlas->shape[texel * 2], 255);
        const float height = std::sqrt(inside);
        ASSERT_NEAR(rules::impostorHeightFromCode(atlas->shape[texel * 2 + 1] / 255.0f), height,
                    0.008f);
        ASSERT_GT(glm::dot(glm::normalize(normalAt(*atlas, texel)),
                           basis.right * at.x + basis.up * at.y + axis * height),
                  0.998f);
        ASSERT_NEAR(albedoAt(*atlas, texel).x, 0.5f, 0.006f);
      }
    }
    EXPECT_NEAR(area * 4 * extent * extent / (64 * 64), std::numbers::pi, 0.01);
  }
}

TEST(ImpostorBake, EveryTexelOfEveryLevelIsDefinedEvenWhereNothingIsSeen) {
  // A needle that most views miss or see in one texel, and a sheet that is edge-on for some.
  const std::vector<std::vector<vec3>> shapes = {
      {{0, 0, 0}, {1, 0, 0}, {0.5f, 0.01f, 0}, {0, 0, 0}, {0.5f, 0, 0.01f}, {1, 0, 0}},
      {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}};
  for (const std::vector<vec3>& corners : shapes) {
    Result<ImpostorAtlas> atlas = bake(grainOf(test::soup(corners), plain({0.2f, 0.9f, 0.1f})),
                                       {.edge = 4, .texels = 32, .directions = 0});
    ASSERT_TRUE(atlas.ok()) << atlas.error();
    int unseen = 0;
    for (int layer = 0; layer < atlas->views(); ++layer) {
      int covered = 0;
      for (int level = 0; level < atlas->levels(); ++level) {
        for (int i = 0; i < atlas->side(level) * atlas->side(level); ++i) {
          const uint64_t texel = atlas->offset(level, layer) + static_cast<uint64_t>(i);
          covered += atlas->shape[texel * 2] > 0;
          const float length = glm::length(normalAt(*atlas, texel));
          ASSERT_GT(length, 1 - rules::kMostSpread - 0.02f);
          ASSERT_LT(length, 1.02f);
          // The material's colour, or of a view that sees nothing the neutral one.
          const vec3 albedo = albedoAt(*atlas, texel);
          ASSERT_TRUE(glm::length(albedo - vec3(0.2f, 0.9f, 0.1f)) < 0.02f ||
                      glm::length(albedo - vec3(0.5f)) < 0.02f);
        }
      }
      unseen += covered == 0;
    }
    EXPECT_GT(unseen, 0);
    EXPECT_LT(unseen, atlas->views());
  }
}

// Red seen from +z, blue from -z, with views of both beside each other in the atlas.
TEST(ImpostorBake, ViewsDoNotBleedIntoEachOtherInAnyLevel) {
  GrainMesh grain;
  grain.materials = {plain({1, 0, 0}), plain({0, 0, 1})};
  grain.parts = {test::soup({{-1, -1, 0.01f}, {1, -1, 0.01f}, {0, 1, 0.01f}}),
                 test::soup({{1, -1, -0.01f}, {-1, -1, -0.01f}, {0, 1, -0.01f}})};
  grain.parts[0].material = 0;
  grain.parts[1].material = 1;
  Result<ImpostorAtlas> atlas = bake(grain, {.edge = 5, .texels = 32, .directions = 0});
  ASSERT_TRUE(atlas.ok()) << atlas.error();
  int red = 0, blue = 0;
  for (int layer = 0; layer < atlas->views(); ++layer) {
    const float z = rules::impostorViewDirection(static_cast<uint32_t>(layer), 5).z;
    if (z == 0) continue;
    (z > 0 ? red : blue) += 1;
    for (int level = 0; level < atlas->levels(); ++level)
      for (int i = 0; i < atlas->side(level) * atlas->side(level); ++i)
        ASSERT_EQ(albedoAt(*atlas, atlas->offset(level, layer) + static_cast<uint64_t>(i)),
                  z > 0 ? vec3(1, 0, 0) : vec3(0, 0, 1));
  }
  EXPECT_GT(red, 20);
  EXPECT_EQ(red, blue);
}

TEST(ImpostorTexels, LevelsAreMeansWeightedByCoverage) {
  // Two by two: a white texel that is wholly covered, a black one by a quarter, two empty ones.
  std::vector<TexelSum> sums(4);
  sums[0] = {1, vec3(1), 1, vec3(0, 0, 1), 0.04f, 0.5f};
  sums[3] = {0.25f, vec3(0), 0, vec3(0, 0, 0.25f), 0.25f * 0.16f, -0.25f * 0.5f};
  const std::vector<TexelSum> half = halved(sums, 2);
  ASSERT_EQ(half.size(), 1u);
  EXPECT_FLOAT_EQ(half[0].coverage, 1.25f / 4);
  const Texel mean = meanOf(half[0], vec3(1, 0, 0));
  EXPECT_FLOAT_EQ(mean.albedo.x, 0.8f);
  EXPECT_FLOAT_EQ(mean.metallic, 0.8f);
  EXPECT_FLOAT_EQ(mean.height, (0.5f - 0.125f) / 1.25f);
  EXPECT_FLOAT_EQ(mean.roughness, std::sqrt(std::sqrt((0.04f + 0.04f) / 1.25f)));
  EXPECT_EQ(mean.normal, vec3(0, 0, 1));  // of one normal
}

TEST(ImpostorTexels, NormalsThatCancelKeepALengthAndTheMostSpread) {
  std::vector<TexelSum> sums(4);
  const vec3 opposed[4] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  for (size_t k = 0; k < 4; ++k) sums[k] = {1, vec3(0.5f), 0, opposed[k], 0.01f, 0};
  const vec3 axis = glm::normalize(vec3(1, 2, 3));
  const Texel mean = meanOf(halved(sums, 2)[0], axis);
  EXPECT_NEAR(glm::length(mean.normal - axis * (1 - rules::kMostSpread)), 0, 1e-6f);
  EXPECT_FLOAT_EQ(mean.roughness, std::sqrt(std::sqrt(0.01f)));
  const StoredTexel bytes = stored(1, mean);
  const vec3 read = rules::impostorNormalFromCode(
      vec3(bytes.normal[0], bytes.normal[1], bytes.normal[2]) / 255.0f);
  EXPECT_NEAR(glm::length(read), 1 - rules::kMostSpread, 0.01f);
  // And of ridges that face each other nearly.
  sums[0].normal = glm::normalize(vec3(1, 0, 0.01f));
  EXPECT_NEAR(glm::length(meanOf(halved(sums, 2)[0], axis).normal), 1 - rules::kMostSpread, 1e-6f);
  // Of those that agree in part, what is left is their mean.
  sums[0].normal = sums[1].normal = vec3(0, 0, 1);
  sums[2].normal = sums[3].normal = glm::normalize(vec3(0, 1, 1));
  EXPECT_NEAR(glm::length(meanOf(halved(sums, 2)[0], axis).normal), std::cos(std::numbers::pi / 8), 1e-6);
}

TEST(ImpostorBake, CoarserLevelsOfABumpyGrainSpreadMore) {
  // Facets in all directions: one normal in the fine level, many in the coarse one; as rough in all.
  const GrainMesh grain = grainOf(globe(12), plain({0.5f, 0.5f, 0.5f}, 0.2f));
  Result<ImpostorAtlas> atlas = bake(grain, {.edge = 3, .texels = 64, .directions = 0});
  ASSERT_TRUE(atlas.ok());
  float before = 0;
  for (int level = 0; level < atlas->levels(); ++level) {
    const uint64_t middle =
        atlas->offset(level, 0) +
        static_cast<uint64_t>(atlas->side(level) / 2 * (atlas->side(level) + 1));
    const float spread = 1 - glm::length(normalAt(*atlas, middle));
    EXPECT_NEAR(atlas->normal[middle * 4 + 3] / 255.0f, 0.2f, 0.51f / 255) << level;
    EXPECT_GE(spread, before - 0.005f);  // of codes
    before = spread;
    if (level == 0) {
      EXPECT_LT(spread, 0.01f);
    }
  }
  EXPECT_NEAR(before, 1.0f / 3, 0.03f);  // a ball as a whole
}

// ---- Materials ------------------------------------------------------------------------------

TEST(ImpostorBake, MaskedMaterialsAreCutOut) {
  ImageData image{
      .name = "stripes", .width = 2, .height = 1, .channels = 4, .encoding = ColorEncoding::Srgb};
  image.bytes = {255, 255, 255, 255, 255, 255, 255, 0};
  MeshData sheet =
      test::soup({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
  for (Vertex& v : sheet.vertices) v.uv = (vec2(v.position) + 1.0f) * 0.5f;
  MaterialData material = plain({1, 1, 1});
  material.alpha_mode = AlphaMode::Mask;
  material.base_color_map = {.image = 0, .wrap_u = TextureWrap::ClampToEdge};
  GrainMesh grain = grainOf(sheet, material);
  grain.images.push_back(image);
  const auto covered = [](const GrainMesh& mesh) {
    Result<ImpostorAtlas> atlas = bake(mesh, kSmall);
    double sum = 0;
    // n = 3: rows of 1, 3, 5, 3, 1 views; the pole +z is number 6.
    for (uint64_t i = 0; i < 16 * 16; ++i)
      sum += atlas->shape[(atlas->offset(0, 6) + i) * 2] / 255.0;
    return sum;
  };
  const double cut = covered(grain);
  grain.materials[0].alpha_mode = AlphaMode::Opaque;
  EXPECT_NEAR(cut / covered(grain), 0.5, 0.03);
}

TEST(ImpostorBake, RefusesWhatNoViewShows) {
  GrainMesh grain = grainOf(globe(8));
  grain.parts[0].name = "pane";
  grain.materials[0].name = "glass";
  grain.materials[0].base_color.w = 0;
  EXPECT_TRUE(bake(grain, kSmall).ok()) << "opaque: its alpha does not count";
  for (const AlphaMode mode : {AlphaMode::Blend, AlphaMode::Mask}) {
    grain.materials[0].alpha_mode = mode;
    Result<ImpostorAtlas> atlas = bake(grain, kSmall);
    ASSERT_FALSE(atlas.ok());
    EXPECT_NE(atlas.error().find("part 0 \"pane\": material 0 \"glass\": its alpha is below 0.5"), std::string::npos) << atlas.error();
  }
  // With something to be seen beside it.
  grain.parts.push_back(globe(8, [](vec3 p) { return p * 0.5f; }));
  EXPECT_TRUE(bake(grain, kSmall).ok());
  Result<ImpostorAtlas> line = bake(grainOf(test::soup({{-1, 0, 0}, {1, 1e-6f, 0}, {1, 0, 0}})), kSmall);
  ASSERT_FALSE(line.ok());
  EXPECT_NE(line.error().find("too thin"), std::string::npos) << line.error();
}

TEST(ImpostorBake, ProgressGoesOnInEveryPhase) {
  std::vector<double> told;
  BakeParameters parameters = kSmall;
  parameters.directions = 2;
  ASSERT_TRUE(bake(grainOf(globe(8)), parameters, [&](double done) { told.push_back(done); }).ok());
  double before = 0;
  for (const double done : told) {
    EXPECT_GE(done, before);
    EXPECT_LE(done - before, 0.06);
    before = done;
  }
  EXPECT_NEAR(before, 1, 1e-9);
}

// ---- Determinism and refusals ---------------------------------------------------------------

TEST(ImpostorBake, BytesAreEqualForEveryNumberOfThreads) {
  const GrainMesh grain = test::model("coffee_bean.glb");
  std::string first;
  for (int threads : {1, 2, 4, 7}) {
    setThreadCount(threads);
    Result<ImpostorAtlas> atlas = bake(grain, {.edge = 4, .texels = 32, .directions = 2});
    ASSERT_TRUE(atlas.ok());
    const std::string bytes = encodeAtlas(*atlas);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << threads;
  }
  setThreadCount(0);
}

TEST(ImpostorBake, KeysTellApartAllThatIsBaked) {
  const GrainMesh grain = test::model("pebble.glb");
  std::set<uint64_t> keys{bakeKey(grain, {})};
  const auto expectNew = [&](const GrainMesh& other, const BakeParameters& p) {
    EXPECT_TRUE(keys.insert(bakeKey(other, p)).second);
  };
  expectNew(grain, {.edge = 7});
  expectNew(grain, {.texels = 32});
  expectNew(grain, {.supersample = 2});
  expectNew(grain, {.directions = 1});
  GrainMesh other = grain;
  other.parts[0].vertices[5].position.x += 1e-6f;
  expectNew(other, {});
  other = grain;
  other.images[0].bytes[17] ^= 1;
  expectNew(other, {});
  other = grain;
  other.materials[0].roughness += 0.001f;
  expectNew(other, {});
  EXPECT_EQ(bakeKey(grain, {}), *keys.find(bakeKey(test::model("pebble.glb"), {})));
}

TEST(ImpostorBake, RefusesWhatCannotBeBakedAndNamesTheValue) {
  const auto refusal = [](const GrainMesh& grain, const BakeParameters& p = kSmall) {
    Result<ImpostorAtlas> atlas = bake(grain, p);
    return atlas.ok() ? std::string() : atlas.error();
  };
  const GrainMesh good = grainOf(globe(8));
  EXPECT_EQ(refusal(good), "");
  EXPECT_EQ(refusal(good, {.edge = 24}), "impostor: views (n) is 24, allowed are 2 to 23");
  EXPECT_EQ(refusal(good, {.edge = 1}), "impostor: views (n) is 1, allowed are 2 to 23");
  EXPECT_EQ(refusal(good, {.texels = 48}),
            "impostor: texels (p) is 48, allowed are 16, 32, 64, 128, 256");
  EXPECT_NE(refusal(good, {.texels = 512}), "");
  EXPECT_NE(refusal(good, {.supersample = 0}), "");
  EXPECT_NE(refusal(good, {.directions = -1}), "");
  EXPECT_NE(refusal(good, {.edge = 23, .texels = 256}).find("MiB"), std::string::npos);
  EXPECT_EQ(refusal({}), "grain: has no triangle");
  GrainMesh bad = good;
  bad.parts[0].indices[3] = 1000000;
  EXPECT_NE(refusal(bad).find("index 3 is 1000000"), std::string::npos);
  bad = good;
  bad.parts[0].vertices[7].position.y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(refusal(bad).find("vertex 7"), std::string::npos);
  bad = good;
  bad.parts[0].material = 3;
  EXPECT_NE(refusal(bad).find("material 3, of 1"), std::string::npos);
  bad = good;
  bad.materials[0].base_color_map.image = 0;
  EXPECT_NE(refusal(bad).find("image 0, of 0"), std::string::npos);
  EXPECT_NE(refusal(grainOf(test::soup({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}))).find("area"), std::string::npos);
  EXPECT_NE(refusal(grainOf(test::soup({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}))).find("outer radius"),
            std::string::npos);
  // Degenerate triangles beside sound ones, and a mesh far from its origin, are borne.
  bad = good;
  for (uint32_t k : {0u, 0u, 1u}) bad.parts[0].indices.push_back(k);
  EXPECT_EQ(refusal(bad), "");
  EXPECT_EQ(refusal(grainOf(globe(8, [](vec3 p) { return p * 1e-4f + vec3(5, 0, 0); }))), "");
}

}  // namespace
}  // namespace scree
