// The rules of points against brute force, without GL.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <set>

#include "engine/core/random.h"
#include "shaders/shared/bed.h"
#include "shaders/shared/points.h"
#include "shaders/shared/swarm.h"

namespace scree::test {
namespace {

vec3 direction(uint64_t k, uint32_t at) {
  const float z = 2 * randomUnit(1, k, 0, at) - 1, a = 6.2831853f * randomUnit(1, k, 0, at + 1), s = std::sqrt(1 - z * z);
  return {s * std::cos(a), s * std::sin(a), z};
}

// Mean normal of the sides that face the eye, by a grid on the disc; shares by the polynomial.
dvec3 meanNormalByRays(dvec3 eye, dvec3 up, dvec3 shares) {
  const dvec3 x = glm::normalize(glm::cross(std::abs(eye.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0), eye)), y = glm::cross(eye, x);
  constexpr int kSide = 300;
  dvec3 sum(0);
  double all = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double px = 2 * (i + 0.5) / kSide - 1, py = 2 * (j + 0.5) / kSide - 1, r2 = px * px + py * py;
      if (r2 > 1) continue;
      const dvec3 n = x * px + y * py + eye * std::sqrt(1 - r2);
      const double t = glm::dot(n, up), share = shares.x + shares.y * t + shares.z * t * t;
      all += share;
      sum += share * n;
    }
  return sum / all;
}

TEST(Bed, MeanNormalIsThatByRays) {
  for (uint64_t k = 0; k < 60; ++k) {
    const vec3 eye = direction(k, 0);
    vec3 up = direction(k, 4);
    if (glm::dot(up, eye) < 0) up = -up;
    const vec3 shares = k % 3 == 0 ? vec3(1, 0, 0) : rules::bedShares(0.1f * static_cast<float>(k % 20));
    const dvec3 wanted = meanNormalByRays(glm::normalize(dvec3(eye)), glm::normalize(dvec3(up)), shares);
    EXPECT_LT(glm::length(dvec3(rules::bedMeanNormal(eye, up, shares)) - wanted), 1e-3) << k;
  }
}

TEST(Bed, SharesAreNearTheExponential) {
  for (const float steepness : {0.0f, 0.5f, 1.0f, 1.5f}) {
    const vec3 p = rules::bedShares(steepness);
    for (float x = -1; x <= 1; x += 0.1f) {
      EXPECT_NEAR(p.x + p.y * x + p.z * x * x, std::exp(steepness * x), 0.05 * std::exp(steepness) + 1e-6) << steepness << " " << x;
      EXPECT_GT(p.x + p.y * x + p.z * x * x, 0);
    }
  }
}

// The model of shared/bed.h, drawn: balls at random below a plane, and a ray that is to reach a side of one.
TEST(Bed, SteepnessIsThatOfBallsAtRandom) {
  for (const double facing : {0.15, 0.35, 0.7, 1.0}) {
    const double density = static_cast<double>(rules::kBedPacking) / (4.0 / 3 * 3.14159265358979);
    const double slant = std::sqrt(1 - facing * facing);
    // Volume of the tube above a point at this depth, by slices along the normal of the plane.
    const auto volume = [&](double depth) {
      double sum = 0;
      constexpr double kStep = 0.02;
      for (double z = -1; z < depth; z += kStep)  // height above the point
        for (double x = -1; x < 1 + std::max(0.0, z) * slant / facing + 1 / facing; x += 0.02) {
          // Across the plane of slant: a chord of the tube or of the ball where it begins.
          const double along = z * facing + x * slant, aside = -z * slant + x * facing;
          const double room = along > 0 ? 1 - aside * aside : 1 - z * z - x * x;
          if (room > 0) sum += 2 * std::sqrt(room) * 0.02 * kStep;
        }
      return sum;
    };
    double shares = 0, last = 0;
    constexpr double kDepth = 0.05;
    const double at_plane = std::exp(-density * volume(0));
    for (double depth = 0; depth < 12; depth += kDepth) {
      last = std::exp(-density * volume(depth + kDepth / 2));
      shares += last * kDepth;
    }
    const double wanted = at_plane / shares;  // - d log(integral from a) / da at a = 0
    const double got = rules::bedSteepness(static_cast<float>(facing), rules::kBedPacking);
    std::printf("facing %.2f: steepness %.3f, of balls at random %.3f\n", facing, got, wanted);
    EXPECT_NEAR(got, wanted, 0.1 * wanted);
  }
}

TEST(Bed, WhatIsSeenLiesDeeperWhereItIsLoose) {
  for (uint64_t k = 0; k < 2000; ++k) {
    const float outer = std::pow(10.0f, -4 * randomUnit(8, k, 0, 0)), radius = outer * (0.3f + 0.7f * randomUnit(8, k, 0, 1));
    const float packing = randomUnit(8, k, 0, 2), looser = 0.5f * packing, receded = 2 * randomUnit(8, k, 0, 3);
    const vec2 radii(outer, radius);
    const float depth = rules::bedSeenDepth(packing, radii, 0);
    EXPECT_GE(depth, 0) << outer;
    EXPECT_LT(depth, (rules::kMeanFront + 1) * outer) << "not behind the far side of a layer";
    EXPECT_GE(rules::bedSeenDepth(looser, radii, 0), depth);
    EXPECT_LE(rules::bedSeenDepth(packing, radii, receded), depth) << "the foremost is none of the highest";
  }
  EXPECT_EQ(rules::bedSeenDepth(0.5f, vec2(0.7f, 0.6f), 0.3f), 0) << "one fills the pixel";
  EXPECT_EQ(rules::bedSeenDepth(0, vec2(0), 0), 0);
}

TEST(Foremost, IsKept) {
  for (uint64_t k = 0; k < 2000; ++k) {
    const float outer = std::pow(10.0f, -4 * randomUnit(9, k, 0, 0)), shown = outer * randomUnit(9, k, 0, 1);
    const vec2 place(randomUnit(9, k, 0, 2), randomUnit(9, k, 0, 3));
    const rules::Foremost kept = rules::unpackForemost(rules::packForemost({outer, shown, place}));
    EXPECT_NEAR(kept.outer_px, outer, 8e-3f * outer);
    EXPECT_NEAR(kept.shown_px, shown, 8e-3f * shown + 2.1e-3f * outer);
    EXPECT_NEAR(kept.place_px.x, place.x, 1.0f / 128 + 1e-3f);
    EXPECT_NEAR(kept.place_px.y, place.y, 1.0f / 128 + 1e-3f);
  }
  EXPECT_GT(rules::packForemost({0, 0, vec2(0)}), 0u);
  EXPECT_GT(rules::unpackForemost(rules::packForemost({1e30f, 1e30f, vec2(1)})).outer_px, 5e4f) << "no infinity";
}

// Its change by points at random places, with noise.
TEST(Plane, IsFound) {
  for (uint64_t k = 0; k < 200; ++k) {
    const vec2 change = 0.04f * vec2(randomUnit(10, k, 0, 0) - 0.5f, randomUnit(10, k, 0, 1) - 0.5f);
    rules::PlaneSums sums{};
    for (uint32_t at = 0; at < 9; ++at) {
      const vec2 place(static_cast<float>(at % 3) - 1 + randomUnit(10, k, at, 2), static_cast<float>(at / 3) - 1 + randomUnit(10, k, at, 3));
      sums = rules::addToPlane(sums, place, glm::dot(change, place) + 1e-4f * (randomUnit(10, k, at, 4) - 0.5f));
    }
    const vec2 found = rules::planeChange(sums);
    EXPECT_NEAR(found.x, change.x, 1e-4f + 0.02f * 0.04f);
    EXPECT_NEAR(found.y, change.y, 1e-4f + 0.02f * 0.04f);
  }
  rules::PlaneSums line{};
  for (const float x : {-1.0f, 0.0f, 1.0f}) line = rules::addToPlane(line, vec2(x, 0.5f), 0.01f * x);
  EXPECT_NEAR(rules::planeChange(line).x, 0.01f, 3e-4f);
  EXPECT_EQ(rules::planeChange(line).y, 0);
  EXPECT_EQ(rules::planeChange(rules::addToPlane(rules::PlaneSums{}, vec2(0.3f, 0.4f), 0.5f)), vec2(0)) << "of one point";
}

TEST(Bed, NormalOfAPlaneIsFound) {
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec3 forward = direction(k, 0);
    const vec3 right = glm::normalize(glm::cross(std::abs(forward.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0), forward)), above = glm::cross(forward, right);
    const vec3 x = right * 0.01f, y = above * 0.01f, ray = forward + x * 20.0f + y * -30.0f;
    vec3 n = direction(k, 2);
    if (glm::dot(n, ray) > 0) n = -n;
    if (glm::dot(n, ray) > -0.05f) continue;
    const auto inverse = [&](vec3 r) { return glm::dot(n, r) / -5.0f; };
    const vec3 got = rules::planeNormal(ray, x, y, forward, inverse(ray), vec2(inverse(ray + x) - inverse(ray), inverse(ray + y) - inverse(ray)));
    EXPECT_GT(glm::dot(got, n), 0.9999f) << k;
  }
}

TEST(Shares, AreThoseOfATentAndMakeOne) {
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec2 f(randomUnit(2, k, 0, 0), randomUnit(2, k, 0, 1));
    const vec4 shares = rules::pointShares(f);
    EXPECT_NEAR(shares.x + shares.y + shares.z + shares.w, 1, 1e-6);
    EXPECT_NEAR(shares.y + shares.w, f.x, 1e-6);
    EXPECT_NEAR(shares.z + shares.w, f.y, 1e-6);
  }
}

TEST(Shares, PixelsOfAPointAreItsAreaInTheMeanNearestFirst) {
  for (const float area : {0.05f, 0.7f, 1.0f, 2.4f, 3.1f}) {
    double pixels = 0;
    for (uint64_t k = 0; k < 4000; ++k) {
      const uint32_t count = rules::pointPixels(area, randomUnit(6, k, 0, 0));
      EXPECT_LT(std::abs(static_cast<float>(count) - area), 1) << area;
      pixels += count;
    }
    EXPECT_NEAR(pixels / 4000, area, 0.02);
  }
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec2 f(randomUnit(7, k, 0, 0), randomUnit(7, k, 0, 1));
    const auto away = [&](uint32_t pixel) {
      return glm::length(f - vec2(static_cast<float>(pixel & 1), static_cast<float>(pixel >> 1)));
    };
    uint32_t by_rank[4] = {9, 9, 9, 9};
    for (uint32_t pixel = 0; pixel < 4; ++pixel) by_rank[rules::shownInOrder(f, pixel)] = pixel;
    for (int rank = 0; rank < 4; ++rank) ASSERT_LT(by_rank[rank], 4u) << f.x << " " << f.y;
    for (int rank = 0; rank < 3; ++rank) EXPECT_LE(away(by_rank[rank]), away(by_rank[rank + 1]) + 1e-6f) << f.x << " " << f.y;
  }
}

// Whatever the share that is drawn; and no rank that has a weight is passed over.
TEST(Ranks, AreasAreKeptInTheMean) {
  for (float radius_px = 1; radius_px > 0.015f; radius_px *= 0.93f) {
    const float least_hidden = rules::leastHiddenRank(radius_px);
    const bool all = radius_px * radius_px * 3.14159265f * rules::kMostPointsAPixel >= 1;
    constexpr uint32_t kRuns = 1 << 12;
    double sum = 0;
    for (uint32_t run = 0; run < kRuns; ++run)
      for (uint32_t k = 0; k < rules::kRunGrains; ++k) {
        const rules::RunRanks ranks = rules::ranksOfRun(run, 7);
        const float rank = rules::rankOf(k, ranks), weight = rules::pointFullness(rank, least_hidden) * rules::pointWeight(least_hidden);
        ASSERT_TRUE(rank >= 0 && rank < 1) << run << " " << k;
        ASSERT_NEAR(weight, all ? 1 : weight, 1e-6f) << radius_px;
        const bool looked_at = (rules::ranksBelow(least_hidden, ranks, k >> 3) >> (k & 7) & 1) != 0;
        ASSERT_TRUE(looked_at || weight == 0) << radius_px << " " << run << " " << k;
        sum += static_cast<double>(weight);
      }
    EXPECT_NEAR(sum / kRuns / rules::kRunGrains, 1, 0.01) << radius_px;
  }
}
// So do those of many swarms of one grain, and of every other grain.
TEST(Ranks, FavourNoPlaceInARunAndNoSwarm) {
  for (const float radius_px : {0.12f, 0.08f, 0.05f}) {
    const float least_hidden = rules::leastHiddenRank(radius_px);
    const auto weight = [&](uint32_t grain, uint32_t seed) {
      const float rank = rules::rankOf(grain % rules::kRunGrains, rules::ranksOfRun(grain / rules::kRunGrains, seed));
      return static_cast<double>(rules::pointFullness(rank, least_hidden) * rules::pointWeight(least_hidden));
    };
    constexpr uint32_t kMany = 1 << 16;
    double of_one = 0;
    for (uint32_t seed = 0; seed < kMany; ++seed) of_one += weight(0, seed);
    EXPECT_NEAR(of_one / kMany, 1, 0.05) << radius_px;
    for (uint32_t step = 1; step < rules::kRunGrains; step *= 2) {
      double every_other = 0;
      for (uint32_t grain = 0; grain < 64 * kMany; ++grain) every_other += (grain & step) != 0 ? weight(grain, 3) : 0;
      EXPECT_NEAR(every_other / (32 * kMany), 1, 0.03) << radius_px << " " << step;
    }
  }
}
TEST(Ranks, AreEachOfSixtyFourOnceAndFewWhereFewAreDrawn) {
  for (uint32_t run = 0; run < 200; ++run) {
    rules::RunRanks ranks = rules::ranksOfRun(run, 1);
    ranks.first = 0;
    std::set<float> all;
    for (uint32_t k = 0; k < 64; ++k) all.insert(rules::rankOf(k, ranks) * 64);
    ASSERT_EQ(all.size(), 64u);
    ASSERT_EQ(*all.rbegin(), 63);
    for (int drawn = 0; drawn <= 64; ++drawn) {
      int bits = 0;
      for (uint32_t w = 0; w < 8; ++w) bits += std::popcount(rules::ranksBelow(static_cast<float>(drawn) / 64, ranks, w));
      ASSERT_EQ(bits, drawn);
    }
  }
}
// A camera that goes away by a hundredth changes no point's area by more than this, relative to the pixel's.
TEST(Ranks, LeaveWithoutAJump) {
  for (float radius_px = 0.4f; radius_px > 0.02f; radius_px *= 0.99f)
    for (uint32_t k = 0; k < 64; ++k) {
      const auto area = [&](float r) {
        const float least_hidden = rules::leastHiddenRank(r);
        return 3.14159265f * r * r * rules::pointFullness(rules::rankOf(k, rules::ranksOfRun(5, 5)), least_hidden) * rules::pointWeight(least_hidden);
      };
      EXPECT_LT(std::abs(area(radius_px) - area(0.99f * radius_px)), 0.15f / rules::kMostPointsAPixel) << radius_px << " " << k;
    }
}

TEST(Keys, AreOrderedAndGoBack) {
  float last = 0;
  for (float along = 1e6f; along > 1e-3f; along *= 0.93f) {
    const uint32_t key = rules::pointKey(along);
    EXPECT_GT(key, rules::pointKey(along * 1.001f));
    EXPECT_NEAR(rules::alongOf(key) / along, 1, 1e-6);
    last = along;
  }
  EXPECT_GT(last, 0);
}

}  // namespace
}  // namespace scree::test
