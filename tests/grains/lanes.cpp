// Instruction sets: the same bits from each.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <span>
#include <vector>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

// The hash of every tick of a pour, summed.
uint64_t hashOf(Lanes lanes, GrainMaterial material, float radius_jitter) {
  Field field;
  field.parameters.lanes = lanes;
  pour(field, 9, 10, 0.05f, 41, radius_jitter, material);
  for (Collider& c : field.colliders) c.restitution = material.restitution;
  uint64_t sum = 0;
  for (int tick = 0; tick < 100; ++tick) {
    field.step();
    sum = hashCombine(sum, field.hash());
  }
  return sum;
}

// Those of this machine beside the baseline; none: nothing to compare.
std::vector<Lanes> widerSets() {
  std::vector<Lanes> sets;
  for (const Lanes lanes : {Lanes::Avx2, Lanes::Avx512})
    if (kernelsOf(lanes) != nullptr) sets.push_back(lanes);
  return sets;
}

const char* nameOf(Lanes lanes) { return lanes == Lanes::Avx2 ? "AVX2" : "AVX-512"; }

TEST(Lanes, WideAndBaselineGiveTheSameBits) {
  if (widerSets().empty()) GTEST_SKIP() << "no wider set on this machine";
  for (const GrainMaterial material :
       {GrainMaterial{1000, 0.5f, 0, 0}, {1000, 0.5f, 0.02f, 0}, {1000, 0.4f, 0.02f, 0.6f},
        {1000, 0.4f, 0.02f, 0, 500}, {1000, 0.4f, 0.02f, 0.6f, 500}})
    for (const float jitter : {0.0f, 0.7f}) {
      const uint64_t want = hashOf(Lanes::Baseline, material, jitter);
      for (const Lanes lanes : widerSets())
        EXPECT_EQ(hashOf(lanes, material, jitter), want)
            << nameOf(lanes) << ", rolling friction " << material.rolling_friction << ", restitution "
            << material.restitution << ", cohesion " << material.cohesion << ", radius jitter " << jitter;
    }
}

TEST(Lanes, CoincidentCentresToo) {
  if (widerSets().empty()) GTEST_SKIP() << "no wider set on this machine";
  const auto hash = [](Lanes lanes) {
    Field field;
    field.parameters.lanes = lanes;
    field.parameters.gravity = vec3(0);
    for (int k = 0; k < 300; ++k) field.add({1, 2, 3}, 0.05f, {1000, 0.3f, 0, 0.5f});
    field.step(20);
    return field.hash();
  };
  for (const Lanes lanes : widerSets()) EXPECT_EQ(hash(lanes), hash(Lanes::Baseline)) << nameOf(lanes);
}

// Pairs of a slab, in batches of which some act, some are idle to the last lane, and some overlap; and
// the bodies.
struct Scene {
  std::vector<uint32_t> i, j;
  std::vector<ImpulseBatch> impulse;
  std::vector<uint8_t> trust;
  std::vector<RollingBatch> rolling;
  std::vector<BouncingBatch> bouncing;
  std::vector<CohesionBatch> cohesion;
  PairSlab slab;  // of these
  std::vector<Body> body;
  std::vector<Entity> entity;
};

vec3 normalOf(uint32_t k) {
  const vec3 v = unitCube(19, k) - 0.5f;
  return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

Scene makeScene(uint32_t batches, const PassSettings& settings) {
  Scene scene;
  PairSlab& slab = scene.slab;
  slab.count = batches * kBatch;
  const auto have = [](auto& values, size_t n) {
    values.resize(n);
    return std::span(values);
  };
  slab.i = have(scene.i, slab.count);
  slab.j = have(scene.j, slab.count);
  slab.impulse = have(scene.impulse, batches);
  slab.trust = have(scene.trust, batches);
  slab.rolling = have(scene.rolling, settings.rolling ? batches : 0);
  slab.bouncing = have(scene.bouncing, settings.bouncing ? batches : 0);
  slab.cohesion = have(scene.cohesion, settings.cohesive ? batches : 0);
  constexpr float kRadius = 0.05f;
  for (uint32_t k = 0; k < slab.count; ++k) {
    const uint32_t b = k / kBatch, lane = k % kBatch;
    // By batch: far apart; near each other; a few near, and the rest far; all in one point.
    const float kind = unit(5, b, 0);
    const bool near = kind < 0.5f || (kind > 0.7f && unit(6, k, 0) < 0.2f);
    for (uint32_t side = 0; side < 2; ++side) {
      Body body;
      body.radius = kRadius * (0.6f + 0.4f * unit(7, 2 * k + side, 0));
      body.inverse_mass = 1 / (4000 * body.radius * body.radius * body.radius);
      body.friction_root = 0.7f;
      const vec3 place(static_cast<float>(b), static_cast<float>(lane), 0);
      const float away = near ? 0.8f + 0.6f * unit(8, k, 0) : 5.0f;
      if (kind < 0.95f) body.position = place + static_cast<float>(side) * away * kRadius * 1.5f * normalOf(k);
      // Bodies at rest have zeros of either sign, which idle batches must leave as they are.
      const vec3 still(-0.0f, unit(9, 2 * k + side, 0) < 0.5f ? 0.0f : -0.0f, -0.0f);
      body.velocity = body.spin = body.velocity_before = still;
      if (near || unit(10, b, 0) < 0.3f) {
        body.velocity = 4.0f * (unitCube(11, 2 * k + side) - 0.5f);
        body.spin = 20.0f * (unitCube(12, 2 * k + side) - 0.5f);
        body.velocity_before = body.velocity + 0.1f * (unitCube(13, 2 * k + side) - 0.5f);
      }
      (side == 0 ? slab.i : slab.j)[k] = static_cast<uint32_t>(scene.body.size());
      scene.body.push_back(body);
      scene.entity.push_back({2 * k + side, 1});
    }
    if (settings.rolling) slab.rolling[b].friction[lane] = 0.05f;
    if (settings.bouncing) slab.bouncing[b].restitution[lane] = 0.7f;
    if (settings.cohesive) slab.cohesion[b].pull[lane] = unit(14, k, 0) < 0.5f ? 0.0f : 20.0f;
    if (near && unit(15, k, 0) < 0.5f) {
      for (int axis = 0; axis < 3; ++axis)
        slab.impulse[b].impulse[axis][lane] = 0.01f * (unit(16, k, uint32_t(axis)) - 0.5f);
      if (unit(17, k, 0) < 0.7f) slab.trust[b] = static_cast<uint8_t>(slab.trust[b] | 1u << lane);
    }
    // Colours of one batch and more, and of none; the last lanes need not be used.
    if (lane + 1 == kBatch && (b + 1 == batches || unit(18, b, 0) < 0.3f)) {
      slab.colour_end.push_back(k - static_cast<uint32_t>(5 * unit(18, b, 1)));
      if (unit(18, b, 2) < 0.2f) slab.colour_end.push_back(k + 1);
    }
  }
  return scene;
}

template <class T>
void expectSame(const std::vector<T>& got, const std::vector<T>& want, const char* what) {
  ASSERT_EQ(got.size(), want.size()) << what;
  for (size_t k = 0; k < got.size(); ++k)
    ASSERT_EQ(std::memcmp(&got[k], &want[k], sizeof(T)), 0) << what << ' ' << k;
}

void runPasses(const Kernels& kernels, Scene& scene, PassSettings settings) {
  kernels.applyKept(scene.slab, scene.body.data(), settings);
  for (int pass = 0; pass < 3; ++pass) {
    settings.first_pass = pass == 0;
    kernels.relax(scene.slab, scene.body.data(), scene.entity.data(), settings);
  }
}

TEST(Lanes, EachBatchIsLeftAsAloneWhateverTheOneBesideItDoes) {
  if (widerSets().empty()) GTEST_SKIP() << "no wider set on this machine";
  for (const auto& [rolling, bouncing, cohesive] :
       {std::array{false, false, false}, {true, false, false}, {true, true, false}, {true, false, true},
        {true, true, true}})
    for (const uint32_t batches : {1u, 2u, 7u, 300u, 1500u}) {
      PassSettings settings;
      settings.h = 1.0f / 240;
      settings.inverse_h = 240;
      settings.bounce_speed = 0.1f;
      settings.rolling = rolling;
      settings.bouncing = bouncing;
      settings.cohesive = cohesive;
      Scene want = makeScene(batches, settings);
      runPasses(kBaselineKernels, want, settings);
      if (batches > 100) {
        EXPECT_GT(want.slab.carried, batches / 2);
        EXPECT_GT(want.slab.deepest, 0.01f);
        EXPECT_EQ(want.slab.bounces.size() > batches / 20, bouncing);
      }
      for (const Lanes lanes : widerSets()) {
        SCOPED_TRACE(nameOf(lanes));
        Scene got = makeScene(batches, settings);
        runPasses(*kernelsOf(lanes), got, settings);
        expectSame(got.body, want.body, "body");
        expectSame(got.impulse, want.impulse, "impulses of batch");
        expectSame(got.rolling, want.rolling, "rolling of batch");
        expectSame(got.bouncing, want.bouncing, "bouncing of batch");
        expectSame(got.trust, want.trust, "trust of batch");
        expectSame(got.slab.bounces, want.slab.bounces, "bounce");
        EXPECT_EQ(got.slab.carried, want.slab.carried);
        EXPECT_EQ(got.slab.deepest, want.slab.deepest);
      }
    }
}

}  // namespace
}  // namespace scree::grains::test
