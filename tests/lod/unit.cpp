// The router's rules and stores, without GL.
#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/core/random.h"
#include "engine/assets/nearest_on_triangle.h"
#include "modules/lod/lod.h"
#include "modules/lod/state.h"
#include "modules/lod/order.h"
#include "modules/lod/surface_distance.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

TEST(SwarmRecords, RotationsKeepTheirPrecision) {
  double worst = 0;
  for (uint64_t k = 0; k < 200000; ++k) {
    // Uniform on the sphere of quaternions (Shoemake 1992).
    const double u = randomUnit(3, k, 0, 0), a = 6.283185307179586 * randomUnit(3, k, 0, 1),
                 b = 6.283185307179586 * randomUnit(3, k, 0, 2);
    const double s = std::sqrt(1 - u), c = std::sqrt(u);
    const vec4 q(s * std::sin(a), s * std::cos(a), c * std::sin(b), c * std::cos(b));
    const vec4 back = rules::unpackRotation(rules::packRotation(q));
    const double dot = std::abs(glm::dot(glm::dvec4(q), glm::dvec4(back)));
    worst = std::max(worst, 2 * std::sqrt(2 * std::max(1 - dot, 0.0)));  // angle, for small ones
  }
  std::printf("worst angle %.3g rad\n", worst);
  EXPECT_LT(worst, 4.1e-3);
  EXPECT_GT(worst, 1e-4);
}

TEST(SwarmRecords, RotationsWithoutDirectionAreNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const vec4 q : {vec4(0), vec4(nan, 0, 0, 1), vec4(1e30f)}) {
    const vec4 back = rules::unpackRotation(rules::packRotation(q));
    EXPECT_NEAR(std::abs(back.w), 1, 1e-5) << q.x;
  }
  // All signs and each largest component.
  for (int most = 0; most < 4; ++most)
    for (int signs = 0; signs < 16; ++signs) {
      vec4 q(0.1f);
      q[most] = 0.9f;
      for (int k = 0; k < 4; ++k)
        if ((signs >> k & 1) != 0) q[k] = -q[k];
      const vec4 unit = q / std::sqrt(glm::dot(q, q));
      EXPECT_NEAR(std::abs(glm::dot(unit, rules::unpackRotation(rules::packRotation(q)))), 1, 2e-6);
    }
}

TEST(SwarmRecords, SizesAndLooks) {
  for (const float share : {0.0f, 1e-5f, 0.25f, 0.5f, 1.0f})
    EXPECT_NEAR(rules::radiusOf(rules::packGrainSize(share, 77), 3), 3 * share, 3.0 / 65535);
  EXPECT_EQ(rules::packGrainSize(0.5f, 0xabcd) >> 16, 0xabcdu);
  const uint32_t look = rules::packGrainLook({0, 0.25f, 1}, 0.5f);
  EXPECT_NEAR(rules::tintOf(look).y, 0.25f, 0.003f);
  EXPECT_EQ(rules::tintOf(look).x, 0.0f);
  EXPECT_EQ(rules::tintOf(look).z, 1.0f);
  EXPECT_NEAR(rules::roughnessOf(look), 0.5f, 0.002f);
}

// Sizes, outlines of three views and of one, what nearness adds to these, similarities.
GrainShape measuredShape() {
  GrainShape shape;
  shape.levels = {{0, 0}, {1, 0.01f}, {2, 0.05f}};
  shape.impostor = {{2, 0.05f, 0.1f, 0, 0, 0.97f},      {4, 0.03f, 0.1f, 0, 0, 0.97f},  {8, 0.025f, 0.1f, 0, 0, 0.98f},
                    {16, 0.02f, 0.1f, 0, 0, 0.98f},     {32, 0.02f, 0.1f, 0, 0, 0.97f}, {64, 0.02f, 0.1f, 0, 0, 0.9f},
                    {128, 0.001f, 0.1f, 0, 0, 0.9f, 0.9f}};
  return shape;
}
constexpr float kFar = 1e9f;  // pixels at 1 m: all sizes are far away

TEST(Thresholds, FollowTheMeasuredErrors) {
  LodThresholds t = thresholdsOf(measuredShape(), {.tolerance_px = 0.5f}, kFar);
  EXPECT_FLOAT_EQ(t.point_px, 0.75f);
  EXPECT_FLOAT_EQ(t.impostor_from_px, 0);
  EXPECT_FLOAT_EQ(t.small_px, 5) << "0.5 / 0.1";
  EXPECT_FLOAT_EQ(t.impostor_px, 25) << "0.5 / 0.02";
  EXPECT_FLOAT_EQ(t.mesh_px[1], 50);
  EXPECT_FLOAT_EQ(t.mesh_px[2], 10);
  EXPECT_FLOAT_EQ(t.mesh_px[3], 0) << "there is no such level";
  t = thresholdsOf(measuredShape(), {.tolerance_px = 2}, kFar);
  EXPECT_FLOAT_EQ(t.small_px, rules::kSmallPx);
  EXPECT_FLOAT_EQ(t.impostor_px, 32) << "the similarity ends it, not the outline";
  // An impostor that is bad at small sizes.
  GrainShape shape = measuredShape();
  shape.impostor[0].ssim = shape.impostor[0].small_ssim = 0.9f;
  t = thresholdsOf(shape, {.tolerance_px = 0.5f}, kFar);
  EXPECT_FLOAT_EQ(t.impostor_from_px, 4);
  EXPECT_FLOAT_EQ(t.small_px, 5);
  EXPECT_FLOAT_EQ(t.impostor_px, 25);
  // One of which one view alone is unlike the mesh from 4 px on.
  shape = measuredShape();
  shape.impostor[2].small_ssim = 0.9f;
  t = thresholdsOf(shape, {.tolerance_px = 0.5f}, kFar);
  EXPECT_FLOAT_EQ(t.impostor_from_px, 0);
  EXPECT_FLOAT_EQ(t.small_px, 4);
  EXPECT_FLOAT_EQ(t.impostor_px, 25);
  // One view alone is good up to 2.5 px only; three are from 2 px on.
  t = thresholdsOf(measuredShape(), {.tolerance_px = 0.25f}, kFar);
  EXPECT_FLOAT_EQ(t.impostor_from_px, 0);
  EXPECT_FLOAT_EQ(t.small_px, 2.5f);
  EXPECT_FLOAT_EQ(t.impostor_px, 12.5f);
  // It ends before three views begin.
  shape = measuredShape();
  shape.impostor[1].outline = shape.impostor[2].outline = 0.5f;
  t = thresholdsOf(shape, {.tolerance_px = 0.25f}, kFar);
  EXPECT_GT(t.small_px, 1e9f) << "always";
  EXPECT_FLOAT_EQ(t.impostor_px, 2.5f);
  // No numbers.
  const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(thresholdsOf(measuredShape(), {.tolerance_px = nan, .band = nan}, kFar).mesh_px[1], 0);
  EXPECT_GT(thresholdsOf(measuredShape(), {.tolerance_px = infinity}, kFar).mesh_px[1], 1e8f);
  // One that is good nowhere.
  shape = measuredShape();
  for (SizeError& e : shape.impostor) e.outline = e.small_outline = 10;
  shape.impostor.front().ssim = 0.9f;
  t = thresholdsOf(shape, {.tolerance_px = 0.5f}, kFar);
  EXPECT_FLOAT_EQ(t.impostor_px, 0);
}

TEST(Thresholds, ComeDownWhereThePerspectiveIsStrong) {
  GrainShape shape = measuredShape();
  for (SizeError& e : shape.impostor) e.near = 0.2f;
  // size (0.02 + 0.2 size / 400) = 0.5
  EXPECT_NEAR(thresholdsOf(shape, {.tolerance_px = 0.5f}, 400).impostor_px, 17.4166f, 1e-3f);
  // size 0.01 / (1 - size / 100) = 0.5
  EXPECT_NEAR(thresholdsOf(shape, {.tolerance_px = 0.5f}, 100).mesh_px[1], 33.3333f, 1e-3f);
  EXPECT_LE(thresholdsOf(shape, {.tolerance_px = 0.5f, .band = 0.05f}, 20).impostor_px * 1.05f, 6.0001f) << "not measured nearer";
}

rules::SwarmBlock blockOf(const LodThresholds& t, float band) {
  rules::SwarmBlock block{};
  lod::setThresholds(block, t, band);
  return block;
}

TEST(Representation, ErrorIsWithinTheToleranceAtEverySize) {
  GrainShape shape = measuredShape();
  for (SizeError& e : shape.impostor) e.near = e.small_near = 0.1f;
  for (const float tolerance : {0.1f, 0.25f, 0.5f, 1.0f})
    for (const float pixels_at_1m : {60.0f, 400.0f, 3000.0f}) {
      const LodSettings settings{.tolerance_px = tolerance};
      const rules::SwarmBlock block = blockOf(thresholdsOf(shape, settings, pixels_at_1m), 0);
      uint32_t last = rules::kPoint;
      for (float size = 0.01f; size < 0.99f * pixels_at_1m; size *= 1.01f) {
        const uint32_t r = rules::representationOf(size, 0.5f, rules::kNotDrawn, block);
        const float error = outlineErrorPx(shape, r, size, pixels_at_1m);
        EXPECT_LE(error, settings.tolerance_px * 1.0001f) << size;
        EXPECT_GE(error, 0) << size;
        if (last >= rules::kMesh && r >= rules::kMesh) {
          EXPECT_LE(r, last) << "finer as it comes near";
        }
        last = r;
      }
      EXPECT_EQ(last, rules::kMesh);
    }
}

TEST(Representation, TremblingAtAThresholdSwitchesOnce) {
  const rules::SwarmBlock block = blockOf(thresholdsOf(measuredShape(), {.tolerance_px = 0.5f}, kFar), 0.05f);
  for (const float threshold : {0.75f, 5.0f, 25.0f, 50.0f}) {
    uint32_t r = rules::representationOf(threshold * 0.999f, 0, rules::kNotDrawn, block);
    int switches = 0;
    for (int k = 0; k < 1000; ++k) {
      const float size = threshold * (1 + 1e-4f * (2 * randomUnit(5, static_cast<uint64_t>(k), 0, 0) - 1));
      const uint32_t now = rules::representationOf(size, 0, r, block);
      switches += now != r;
      r = now;
    }
    EXPECT_LE(switches, 1) << threshold;
    // And it does switch in the end, both ways.
    const uint32_t above = rules::representationOf(threshold * 1.2f, 0, r, block);
    const uint32_t below = rules::representationOf(threshold * 0.8f, 0, above, block);
    EXPECT_NE(above, below) << threshold;
  }
}

// Of sizes in a range, whatever a grain was before: passes that draw what is not "possible" do not run. Also where thresholds
// lie closer together than the band is wide.
TEST(Representation, IsOneOfThePossible) {
  uint64_t drawn = 0;
  const auto unit = [&] { return randomUnit(11, drawn++, 0, 0); };
  size_t far_fewer = 0;
  for (int k = 0; k < 200000; ++k) {
    GrainShape shape = measuredShape();
    for (SizeError& e : shape.impostor) e.outline = 0.1f * unit(), e.small_outline = 0.3f * unit();
    shape.point_outline = unit();
    if (k % 5 == 0) shape.impostor.clear();
    LodSettings settings{.tolerance_px = 1.5f * unit(), .band = k % 3 == 0 ? 0.5f * unit() : 0.05f};
    if (k % 7 == 0) settings.only = static_cast<uint32_t>(k / 7 % 6);
    const float pixels_at_1m = std::exp(8 * unit());
    const LodThresholds t = thresholdsOf(shape, settings, pixels_at_1m, 1 + 4 * unit() * unit());
    // Most where several thresholds are near each other.
    const float middle = k % 2 == 0 ? t.impostor_px * (0.8f + 0.4f * unit()) : 0;
    const float least = middle > 0 && middle < 1e6f ? middle : std::exp(8 * unit() - 3), most = least * std::exp(unit() * unit());
    const uint32_t possible = lod::possibleOf(t, shape.levels.size(), settings.band, {least, most});
    const rules::SwarmBlock block = blockOf(t, settings.band);
    uint32_t chosen = 0;
    for (int j = 0; j < 30; ++j) {
      const float size = least + (most - least) * (j < 2 ? static_cast<float>(j) : unit());
      const auto before = static_cast<uint32_t>(16 * unit());
      chosen |= 1u << rules::representationOf(size, unit(), before, block);
    }
    ASSERT_EQ(chosen & ~possible, 0u) << k << ": " << least << " to " << most << " px";
    far_fewer += std::popcount(possible) <= 1;
  }
  EXPECT_GT(far_fewer, 40000u);
}

TEST(SwarmStores, RefuseWhatIsNotFinite) {
  SwarmStore store;
  GrainShape shape;
  shape.levels = {{0, 0}};
  const uint32_t handle = store.addShape(shape);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  std::vector<SwarmGrain> grains(10);
  grains[1].position.y = nan;
  grains[2].radius = inf;
  grains[3].radius = 0;
  grains[4].radius = -1;
  grains[5].rotation.w = nan;
  grains[6].position.x = 1e20f;
  grains[7].radius = 1e20f;
  grains[8].radius = 1e-7f;  // beside the largest that is allowed: of no size
  grains[9].position = {1e9f, -1e9f, 0};
  const uint32_t swarm = store.add("odd", handle, grains);
  EXPECT_EQ(store.swarm(swarm).count, 2u);
  EXPECT_EQ(store.swarm(swarm).refused, 8u);
  EXPECT_EQ(store.swarm(swarm).largest_radius, 1);
  EXPECT_EQ(store.swarm(swarm).least_radius, 1);
  const SwarmStore::Fill fill = [&](uint64_t, std::span<rules::SwarmRecord> records) {
    for (size_t k = 0; k < records.size(); ++k) records[k] = packed(SwarmGrain{.radius = k == 1 ? 0.0f : 1.0f}, 1);
    records[2].x = 1e20f;
  };
  EXPECT_EQ(store.swarm(store.add("filled", handle, 4, 1, fill)).refused, 2u);
  EXPECT_EQ(store.swarm(store.add("empty", handle, std::span<const SwarmGrain>{})).count, 0u);
}

TEST(SwarmStores, RefuseShapesWhoseNumbersCannotBe) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto add = [](auto change) {
    GrainShape shape = measuredShape();
    shape.name = "odd";
    change(shape);
    SwarmStore().addShape(shape);
  };
  add([](GrainShape&) {});
  EXPECT_DEATH(add([](GrainShape& s) { s.levels.clear(); }), "shape \"odd\": 0 mesh levels, 1 to 4");
  EXPECT_DEATH(add([](GrainShape& s) { s.levels.resize(5); }), "5 mesh levels");
  for (const float x : {nan, inf, 0.0f, -1.0f, 1e-40f}) EXPECT_DEATH(add([x](GrainShape& s) { s.outer_radius = x; s.inner_radius = 0; }), "outer radius");
  for (const float x : {nan, -1.0f, 1.1f}) EXPECT_DEATH(add([x](GrainShape& s) { s.inner_radius = x; }), "inner radius");
  for (const float x : {nan, inf, -1e30f}) EXPECT_DEATH(add([x](GrainShape& s) { s.center.y = x; }), "centre");
  EXPECT_DEATH(add([](GrainShape& s) { s.bound.center.w = 0; }), "no ellipsoid");
  for (const float x : {nan, inf, -1.0f}) {
    EXPECT_DEATH(add([x](GrainShape& s) { s.levels[1].error = x; }), "level 1: error");
    EXPECT_DEATH(add([x](GrainShape& s) { s.point_outline = x; }), "point outline");
    EXPECT_DEATH(add([x](GrainShape& s) { s.impostor[2].near = x; }), "impostor size 2: outline error");
    EXPECT_DEATH(add([x](GrainShape& s) { s.albedo.z = x; }), "albedo");
    EXPECT_DEATH(add([x](GrainShape& s) { s.cast_share = x; }), "cast share");
    EXPECT_DEATH(add([x](GrainShape& s) { s.impostor[1].size_px = x; }), "impostor size 1: .* px, must");
  }
  EXPECT_DEATH(add([](GrainShape& s) { std::swap(s.impostor[3], s.impostor[4]); }), "impostor size 4: 16 px, must .* not below the one before");
  for (const float x : {nan, 1.5f, -2.0f}) EXPECT_DEATH(add([x](GrainShape& s) { s.impostor[0].mesh_ssim = x; }), "similarity");
}

TEST(SwarmStores, EllipsoidsThatAreNoneAreKnown) {
  EXPECT_TRUE(soundEllipsoid(rules::unitBall()));
  const auto with = [](auto change) {
    rules::Ellipsoid e = rules::unitBall();
    change(e);
    return soundEllipsoid(e);
  };
  EXPECT_TRUE(with([](auto& e) { e.axis_a = vec4(0.5f, 0, 0, 4); }));
  EXPECT_FALSE(with([](auto& e) { e.axis_a = vec4(0.5f, 0, 0, 1); })) << "length and inverse differ";
  EXPECT_FALSE(with([](auto& e) { e.axis_b = e.axis_a; })) << "not perpendicular";
  EXPECT_FALSE(with([](auto& e) { e.axis_c = vec4(0); }));
  EXPECT_FALSE(with([](auto& e) { e.center.w = 0.9f; })) << "reaches farther";
  EXPECT_FALSE(with([](auto& e) { e.center.x = std::nanf(""); }));
  EXPECT_FALSE(with([](auto& e) { e.center.x = 0.5f; })) << "reaches farther";
}

TEST(SwarmStores, NeighboursInTheListAreNeighboursInSpace) {
  constexpr uint32_t kSide = 32;
  std::vector<uint32_t> shuffled(kSide * kSide * kSide);
  for (uint32_t k = 0; k < shuffled.size(); ++k) shuffled[k] = k;
  for (uint32_t k = 0; k < shuffled.size(); ++k) std::swap(shuffled[k], shuffled[static_cast<size_t>(randomUnit(1, k, 0, 0) * static_cast<float>(k))]);
  std::vector<vec3> positions;
  for (const uint32_t k : shuffled) positions.emplace_back(glm::uvec3(k % kSide, k / kSide % kSide, k / kSide / kSide));
  const std::vector<uint32_t> order = lod::orderInSpace(positions);
  std::vector<bool> known(order.size());
  for (const uint32_t k : order) known[k] = true;
  EXPECT_EQ(std::count(known.begin(), known.end(), true), static_cast<long>(order.size())) << "each once";
  for (size_t first = 0; first < order.size(); first += 64) {
    vec3 low(1e30f), high(-1e30f);
    for (size_t k = first; k < first + 64; ++k) low = glm::min(low, positions[order[k]]), high = glm::max(high, positions[order[k]]);
    ASSERT_EQ(high - low, vec3(3)) << "64 of a lattice are a cube of four";
  }
  // Boxes without a size, or of all that floats hold.
  EXPECT_EQ(lod::orderInSpace(std::vector<vec3>(3, vec3(1e30f))), (std::vector<uint32_t>{0, 1, 2}));
  const float most = std::numeric_limits<float>::max();
  EXPECT_EQ(lod::orderInSpace(std::vector<vec3>{vec3(most), vec3(0), vec3(-most)}), (std::vector<uint32_t>{2, 1, 0}));
}

TEST(SwarmStores, GrainsThatMoveKeepTheirRows) {
  SwarmStore store;
  GrainShape shape;
  shape.levels = {{0, 0}};
  const uint32_t handle = store.addShape(shape);
  std::vector<SwarmGrain> grains(100);
  for (size_t k = 0; k < grains.size(); ++k) {
    grains[k].position = vec3(randomUnit(1, k, 0, 0), randomUnit(1, k, 0, 1), randomUnit(1, k, 0, 2));
    grains[k].seed = static_cast<uint16_t>(k);
  }
  const uint32_t swarm = store.add("moving", handle, grains);
  const auto seeds = [&] {
    std::vector<uint32_t> all;
    for (const rules::SwarmRecord& r : store.swarm(swarm).chunks[0]) all.push_back(r.size >> 16);
    return all;
  };
  const std::vector<uint32_t> before = seeds();
  for (SwarmGrain& grain : grains) grain.position = vec3(grain.position.y, -grain.position.z, grain.position.x);
  store.replace(swarm, grains);
  EXPECT_EQ(seeds(), before);
  SwarmGrain fresh = grains[0];
  fresh.seed = 100;
  grains.push_back(fresh);
  store.replace(swarm, grains);
  std::vector<uint32_t> now = seeds();
  EXPECT_EQ(now.back(), 100u) << "who joins is the last";
  now.pop_back();
  EXPECT_EQ(now, before);
  grains.resize(90);
  store.replace(swarm, grains);
  now = seeds();
  ASSERT_EQ(now.size(), 90u);
  int moved = 0;
  for (size_t row = 0; row < now.size(); ++row) {
    EXPECT_LT(now[row], 90u);
    moved += now[row] != before[row];
  }
  EXPECT_LE(moved, 10) << "those in the places of who left";
  EXPECT_EQ(std::set<uint32_t>(now.begin(), now.end()).size(), 90u);
  store.replace(swarm, {});
  EXPECT_EQ(store.swarm(swarm).count, 0u);
}

TEST(SwarmStores, RowsThatFitNoMoreAreSortedAnew) {
  SwarmStore store;
  GrainShape shape;
  shape.levels = {{0, 0}};
  const uint32_t handle = store.addShape(shape);
  std::vector<SwarmGrain> grains(20'000);
  for (size_t k = 0; k < grains.size(); ++k) grains[k].position = vec3(randomUnit(2, k, 0, 0), randomUnit(2, k, 0, 1), randomUnit(2, k, 0, 2));
  const uint32_t swarm = store.add("mixed", handle, grains);
  const auto widest = [&] {  // half of a run's box, along x, in the mean
    const std::vector<rules::SwarmRecord>& records = store.swarm(swarm).chunks[0];
    double sum = 0;
    for (size_t first = 0; first + 64 <= records.size(); first += 64) {
      const auto [low, high] = std::minmax_element(records.begin() + static_cast<long>(first), records.begin() + static_cast<long>(first) + 64, [](const auto& a, const auto& b) { return a.x < b.x; });
      sum += static_cast<double>(high->x - low->x);
    }
    return sum / static_cast<double>(records.size() / 64);
  };
  const double sorted = widest();
  std::rotate(grains.begin(), grains.begin() + 7'777, grains.end());
  for (size_t k = 0; k + 1 < grains.size(); k += 2) std::swap(grains[k], grains[grains.size() - 1 - k]);
  store.replace(swarm, grains);
  EXPECT_NEAR(widest(), sorted, 0.05 * sorted);
}

TEST(MeshLevels, ErrorsHoldAgainstTheMesh) {
  MeshStore meshes;
  GrainShape shape;
  const MeshData mesh = sphereMesh();
  ASSERT_TRUE(addLevels(meshes, shape, std::span(&mesh, 1)).ok());
  ASSERT_GE(shape.levels.size(), 3u);
  uint32_t before = 0xffffffffu;
  for (const GrainShape::Level& level : shape.levels) {
    const MeshPart& part = meshes.mesh(level.mesh).parts.front();
    EXPECT_LT(part.index_count, before);
    before = part.index_count;
    // Of a unit sphere the middles of the triangles are off most.
    const auto vertices = meshes.vertices(part);
    const auto indices = meshes.indices(part);
    double off = 0;
    for (size_t k = 0; k < indices.size(); k += 3) {
      const vec3 middle =
          (vertices[indices[k]].position + vertices[indices[k + 1]].position + vertices[indices[k + 2]].position) / 3.0f;
      off = std::max(off, 1.0 - static_cast<double>(glm::length(middle)));
    }
    std::printf("%u triangles: error stated %.4f, middles off %.4f\n", part.index_count / 3, level.error, off);
    if (&level != &shape.levels.front()) {
      EXPECT_GE(level.error, 0.98 * off - 1e-3);
      EXPECT_LT(level.error, 1.5 * off + 3e-3);
    }
  }
}

// Random triangles, against all points of a fine lattice on them.
TEST(SurfaceDistance, BoundsTheFarthestPoint) {
  const auto soup = [](uint64_t seed, size_t triangles) {
    MeshData mesh;
    for (size_t k = 0; k < 3 * triangles; ++k) {
      const auto unit = [&](uint64_t at) { return randomUnit(seed, k, 0, at); };
      mesh.vertices.push_back({.position = vec3(unit(0), unit(1), unit(2))});
      mesh.indices.push_back(static_cast<uint32_t>(k));
    }
    return mesh;
  };
  const auto farthest = [](const MeshData& from, const MeshData& to) {
    constexpr int kSteps = 60;
    double most = 0;
    const auto corner = [](const MeshData& mesh, size_t k) { return dvec3(mesh.vertices[k].position); };
    for (size_t t = 0; t < from.indices.size(); t += 3)
      for (int i = 0; i <= kSteps; ++i)
        for (int j = 0; i + j <= kSteps; ++j) {
          const double b = static_cast<double>(i) / kSteps, c = static_cast<double>(j) / kSteps;
          const dvec3 p = corner(from, t) * (1 - b - c) + corner(from, t + 1) * b + corner(from, t + 2) * c;
          double least = 1e9;
          for (size_t u = 0; u < to.indices.size(); u += 3)
            least = std::min(least, glm::length(p - nearestOnTriangle(p, corner(to, u), corner(to, u + 1), corner(to, u + 2)).point));
          most = std::max(most, least);
        }
    return most;
  };
  for (uint64_t k = 0; k < 40; ++k) {
    const MeshData a = soup(2 * k + 100, 1 + k % 5), b = soup(2 * k + 101, 1 + k % 7);
    const double expected = std::max(farthest(a, b), farthest(b, a)), bound = surfaceDistance(std::span(&a, 1), std::span(&b, 1));
    EXPECT_GE(bound, expected) << k;
    EXPECT_LE(bound, 1.06 * expected + 1e-3) << k;
  }
  const MeshData sheet = sheetMesh();
  EXPECT_LE(surfaceDistance(std::span(&sheet, 1), std::span(&sheet, 1)), 1e-3);
}

}  // namespace
}  // namespace scree::test
