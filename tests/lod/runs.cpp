// What is said of all grains of a run at once, against each grain by itself.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"
#include "tests/support/exact_sphere.h"

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
  size_t outside = 0, points = 0, alike = 0, unlike = 0;
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
    ++(all == rules::kUnlike ? unlike : all == rules::kPoint ? points : all == rules::kNotDrawn ? outside : alike);
    if (all == rules::kUnlike) continue;
    for (const SwarmRecord& record : records)
      for (uint32_t before = 0; before < rules::kRepresentations; ++before)
        ASSERT_EQ(routeOf(record, swarm, view.block, before), all) << "run " << seed << ", drawn before as " << before;
  }
  std::printf("%zu outside, %zu points, %zu of another kind, %zu unlike\n", outside, points, alike, unlike);
  EXPECT_GT(outside, 5000u);
  EXPECT_GT(points, 1000u);
  EXPECT_GT(alike, 200u);
  EXPECT_GT(unlike, 1000u);
}

// Of sizes on both sides of each threshold, by hair's breadths.
TEST(Runs, SizesThatAreAlikeAreDrawnAlike) {
  rules::SwarmBlock swarm{};
  size_t alike[rules::kRepresentations + 1] = {};
  for (uint64_t seed = 0; seed < 300'000; ++seed) {
    const auto unit = [&](uint32_t at) { return randomUnit(12, seed, 0, at); };
    swarm.point_px = unit(0);
    swarm.small_px = 4;
    swarm.impostor_from_px = unit(1) < 0.5f ? 0 : 3 * unit(2);
    swarm.impostor_px = 20 * unit(3);
    swarm.mesh_px = vec4(0, 60, 30 * unit(4), 10 * unit(5));
    swarm.band = unit(6) < 0.5f ? 0 : 0.1f * unit(7);
    const float thresholds[] = {swarm.point_px, swarm.small_px, swarm.impostor_from_px, swarm.impostor_px, swarm.mesh_px[1], swarm.mesh_px[2], swarm.mesh_px[3]};
    const auto size = [&](uint32_t at) {
      const float some = thresholds[std::min(static_cast<size_t>(7 * unit(at)), size_t{6})];
      return unit(at + 1) < 0.3f ? 80 * unit(at + 2) : some * (1 + 0.3f * (unit(at + 2) - 0.5f));
    };
    float least = size(10), most = size(20);
    if (least > most) std::swap(least, most);
    const uint32_t all = rules::routeOfSizes(least, most, swarm);
    ++alike[all];
    if (all == rules::kUnlike) continue;
    for (const float px : {least, 0.5f * (least + most), most})
      for (const float own : {0.0f, 0.5f, 0.9999999f})
        for (uint32_t before = 0; before < rules::kRepresentations; ++before)
          ASSERT_EQ(rules::representationOf(px, own, before, swarm), all)
              << seed << ": " << px << " px of " << least << " to " << most << ", drawn before as " << before;
  }
  for (uint32_t r = rules::kPoint; r < rules::kMesh + rules::kMeshLevels; ++r) EXPECT_GT(alike[r], 1000u) << r;
  EXPECT_GT(alike[rules::kUnlike], 1000u);
  EXPECT_EQ(alike[rules::kNotDrawn], 0u);
}

// Where a run may show holds where each of its grains may, however it is drawn.
TEST(Runs, ShowWithinTheBoundsOfTheWhole) {
  Random random(13);
  size_t known = 0;
  std::vector<rules::SwarmRun> runs;
  for (uint64_t seed = 0; seed < 20'000; ++seed) {
    const ivec2 size(1 + static_cast<int>(random.between(0, 1800)), 1 + static_cast<int>(random.between(0, 1000)));
    // Half of them are tight: along an axis, all grains in one place.
    const bool tight = seed % 2 == 0;
    const float fov = random.between(0.1f, 2.5f), near_m = std::exp(random.between(-7, -1));
    const View view = tight ? viewOf(dvec3(0), {0, 0, -1}, size, fov, near_m) : randomView(random, size, fov, near_m);
    const rules::OcclusionView eye = rules::occlusionView(view.block.clip_from_relative, view.block.size_px, view.block.near_m);
    const ExactView exact(view);
    rules::SwarmBlock swarm{};
    const float reach = random.between(0.8f, 1.3f);  // of the ellipsoid, at its longest
    swarm.bound = rules::unitBall();
    swarm.bound.axis_a *= vec4(vec3(reach), 1 / (reach * reach));
    swarm.bound.axis_b *= vec4(vec3(0.4f), 1 / 0.16f);
    swarm.bound.center.w = reach;
    const vec3 middle = exact.somewhere(random, std::exp(random.between(-2, 7)), 1.2);
    swarm.origin = vec4(middle, std::exp(random.between(-6, 1)));
    std::vector<SwarmRecord> records = randomRun(seed, 64, swarm.origin.w);
    const vec3 first(records[0].x, records[0].y, records[0].z);
    for (SwarmRecord& record : records) {
      const vec3 at = tight ? vec3(0) : vec3(record.x, record.y, record.z) - first;
      record.x = at.x, record.y = at.y, record.z = at.z;
      const quat turn(lookingAlong(random.direction(), static_cast<double>(random.between(-3, 3))));
      record.rotation = rules::packRotation(vec4(turn.x, turn.y, turn.z, turn.w));
    }
    lod::boundRuns(records, swarm.origin.w, runs);
    const rules::SphereBounds whole = rules::boxBounds(eye, rules::lowOf(runs[0], vec3(swarm.origin)), rules::highOf(runs[0], vec3(swarm.origin)),
                                                       rules::reachOfRun(runs[0], swarm), rules::kReachTouched);
    if (!whole.known) continue;
    ++known;
    for (const SwarmRecord& record : records)
      for (const uint32_t drawn : {rules::kAsSolid, rules::kAsTriangle, rules::kAsImage}) {
        const vec3 center = vec3(swarm.origin) + vec3(record.x, record.y, record.z);
        const float radius = rules::radiusOf(record.size, swarm.origin.w);
        const float stretch = 1 + static_cast<float>(glm::dot(exact.tangent, exact.tangent));
        if (drawn == rules::kAsImage && rules::sizePx(radius, glm::length(center), view.block.pixels_at_1m) >
                                            rules::mostParallelPx(view.block.pixels_at_1m, stretch))
          continue;  // not drawn so
        const rules::SphereBounds one = rules::ellipsoidBounds(eye, center, radius, rules::unpackRotation(record.rotation), swarm.bound,
                                                               drawn == rules::kAsSolid ? rules::kReachTouched : rules::kReachCenters, drawn);
        ASSERT_TRUE(one.known) << "run " << seed << ", drawn as " << drawn;
        ASSERT_GE(whole.depth, one.depth) << "run " << seed << ", drawn as " << drawn;
        if (one.last_px.x < one.first_px.x || one.last_px.y < one.first_px.y) continue;
        for (int axis = 0; axis < 2; ++axis) {
          ASSERT_LE(whole.first_px[axis], one.first_px[axis]) << "run " << seed << ", drawn as " << drawn;
          ASSERT_GE(whole.last_px[axis], one.last_px[axis]) << "run " << seed << ", drawn as " << drawn;
        }
      }
  }
  std::printf("%zu runs that are known\n", known);
  EXPECT_GT(known, 5000u);
}

TEST(Runs, EightAtOnce) {
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    uint32_t eight = 0, points = 0, later = 0, hidden = 0, less = 0, bits = 0, spread = 0;
    glm::uvec4 counts(0);
    for (uint32_t k = 0; k < 8; ++k) {
      const auto r = static_cast<uint32_t>(16 * randomUnit(5, seed, 0, k));
      eight |= r << 4 * k;
      points |= (r == rules::kPoint ? 1u : 0u) << 4 * k;
      const bool is_later = r > rules::kPoint && r < rules::kFirst;
      later |= (is_later ? 1u : 0u) << 4 * k;
      hidden |= (r == rules::kHidden ? 1u : 0u) << 4 * k;
      less |= (is_later ? rules::kHidden : r) << 4 * k;
      bits |= (r & 1) << k;
      spread |= (r & 1) << 4 * k;
      if (r != rules::kNotDrawn) counts[r / 4] += 1u << 8 * (r % 4);
    }
    EXPECT_EQ(rules::pointsOf(eight), points);
    EXPECT_EQ(rules::laterOf(eight), later);
    EXPECT_EQ(rules::hiddenOf(eight), hidden);
    EXPECT_EQ(rules::hideLater(eight), less);
    EXPECT_EQ(rules::bitsOfEight(bits), spread);
    EXPECT_EQ(rules::countsOf(eight), counts);
    EXPECT_EQ(rules::laterCount(counts), static_cast<uint32_t>(std::popcount(later)));
    EXPECT_EQ(rules::hiddenCount(counts), static_cast<uint32_t>(std::popcount(hidden)));
    EXPECT_EQ(rules::countsOf(eight & ~(15 * (later | hidden))), rules::withoutLater(counts));
    EXPECT_EQ(rules::onlyHidden(counts), hidden != 0 && (eight & 0x77777777u) == 0);
  }
  EXPECT_EQ(rules::eightOf(rules::kPoint, 0), 0u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 3), 0x111u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 8), 0x11111111u);
  EXPECT_EQ(rules::eightOf(rules::kPoint, 64), 0x11111111u);
  EXPECT_EQ(rules::eightOf(rules::kNotDrawn, 64), 0u);
}

}  // namespace
}  // namespace scree::test
