// What is said of all grains of a run at once, against each grain by itself.
#include <gtest/gtest.h>

#include <cmath>

#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

using rules::SwarmRecord;

// The records of `run` grains in a box somewhere around the eye, of one size or of several.
std::vector<SwarmRecord> randomRun(uint64_t seed, size_t count, float largest) {
  const auto unit = [&](uint64_t k, uint32_t at) { return randomUnit(seed, k, 7, at); };
  const float extent = std::pow(10.0f, -2 + 3 * unit(1000, 0)), least = unit(1000, 1);
  const vec3 middle = (vec3(unit(1000, 2), unit(1000, 3), unit(1000, 4)) * 2.0f - 1.0f) * std::pow(10.0f, 2.5f * unit(1000, 5));
  std::vector<SwarmRecord> records(count);
  for (size_t k = 0; k < count; ++k) {
    const vec3 p = middle + (vec3(unit(k, 0), unit(k, 1), unit(k, 2)) - 0.5f) * extent;
    records[k] = packed({.position = p, .radius = largest * (least + (1 - least) * unit(k, 3))}, largest);
  }
  return records;
}

TEST(Runs, BoundsHoldEveryGrainAndAreTight) {
  for (const size_t count : {size_t{1}, size_t{63}, size_t{64}, size_t{65}, size_t{1000}}) {
    const std::vector<SwarmRecord> records = randomRun(count, count, 0.3f);
    std::vector<rules::SwarmRun> runs;
    lod::boundRuns(records, 0.3f, runs);
    ASSERT_EQ(runs.size(), (count + 63) / 64);
    for (size_t run = 0; run < runs.size(); ++run) {
      vec3 low(1e30f), high(-1e30f);
      float least = 1e30f, most = 0;
      for (size_t k = 64 * run; k < std::min(64 * run + 64, count); ++k) {
        low = glm::min(low, vec3(records[k].x, records[k].y, records[k].z));
        high = glm::max(high, vec3(records[k].x, records[k].y, records[k].z));
        least = std::min(least, rules::radiusOf(records[k].size, 0.3f));
        most = std::max(most, rules::radiusOf(records[k].size, 0.3f));
      }
      EXPECT_EQ(rules::lowOf(runs[run], vec3(0)), low);
      EXPECT_EQ(rules::highOf(runs[run], vec3(0)), high);
      EXPECT_EQ(runs[run].least_radius, least);
      EXPECT_EQ(runs[run].most_radius, most);
    }
  }
}

// In double precision, each grain by itself.
uint32_t routeOf(const SwarmRecord& record, const rules::SwarmBlock& swarm, const rules::ViewBlock& view, uint32_t before) {
  const dvec3 center = dvec3(swarm.origin) + dvec3(record.x, record.y, record.z);
  const double radius = static_cast<double>(rules::radiusOf(record.size, swarm.origin.w));
  for (const vec4& plane : view.frustum_planes)
    if (glm::dot(dvec3(plane), center) + static_cast<double>(plane.w) < -radius) return rules::kNotDrawn;
  const double size = radius * static_cast<double>(view.pixels_at_1m) / glm::length(center);
  return rules::representationOf(glm::length(center) > radius ? static_cast<float>(size) : rules::kLargestPx,
                                 rules::ownShare(record.look, record.size), before, swarm);
}

TEST(Runs, RoutesAreThoseOfEachGrain) {
  rules::SwarmBlock swarm{};
  swarm.mesh_px = vec4(0, 50, 10, 0);
  swarm.point_px = 0.75f;
  swarm.impostor_px = 16;
  swarm.band = 0.05f;
  size_t outside = 0, points = 0, unlike = 0;
  std::vector<rules::SwarmRun> runs;
  for (uint64_t seed = 0; seed < 20000; ++seed) {
    const auto unit = [&](uint32_t at) { return randomUnit(11, seed, 0, at); };
    const Transform eye{.rotation = glm::normalize(quat(unit(0) - 0.5f, unit(1) - 0.5f, unit(2) - 0.5f, unit(3) - 0.5f))};
    FrameInput input;
    input.size = {320, 240};
    const View view = computeView(previousOf(eye), eye, {.fov_y_rad = 0.05f + 2.5f * unit(4), .near_m = 0.1f}, input);
    swarm.origin = vec4((vec3(unit(5), unit(6), unit(7)) - 0.5f) * 20.0f, 0.2f * unit(8) + 1e-3f);
    const std::vector<SwarmRecord> records = randomRun(seed, 64, swarm.origin.w);
    lod::boundRuns(records, swarm.origin.w, runs);
    const uint32_t all = rules::routeOfRun(runs[0], swarm, view.block);
    ++(all == rules::kUnlike ? unlike : all == rules::kPoint ? points : outside);
    if (all == rules::kUnlike) continue;
    for (const SwarmRecord& record : records)
      for (uint32_t before = 0; before < rules::kRepresentations; ++before)
        ASSERT_EQ(routeOf(record, swarm, view.block, before), all) << "run " << seed << ", drawn before as " << before;
  }
  std::printf("%zu outside, %zu points, %zu unlike\n", outside, points, unlike);
  EXPECT_GT(outside, 5000u);
  EXPECT_GT(points, 1000u);
  EXPECT_GT(unlike, 1000u);
}

TEST(Runs, EightAtOnce) {
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    uint32_t eight = 0, points = 0, later = 0;
    for (uint32_t k = 0; k < 8; ++k) {
      const auto r = static_cast<uint32_t>(16 * randomUnit(5, seed, 0, k));
      eight |= r << 4 * k;
      points |= (r == rules::kPoint ? 1u : 0u) << 4 * k;
      later |= (r > rules::kPoint && r < rules::kFirst ? 1u : 0u) << 4 * k;
    }
    EXPECT_EQ(rules::pointsOf(eight), points);
    EXPECT_EQ(rules::laterOf(eight), later);
  }
  EXPECT_EQ(rules::eightOf(rules::kPoint, 0), 0u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 3), 0x111u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 8), 0x11111111u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 64), 0x11111111u);
  EXPECT_EQ(rules::eightOf(rules::kNotDrawn, 64), 0u);
}

}  // namespace
}  // namespace scree::test
