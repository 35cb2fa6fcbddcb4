// Many clumps: rest, sleep, bits, saves, and what would tear them.
#include <gtest/gtest.h>

#include <limits>

#include "engine/core/parallel.h"
#include "tests/grains/clump_field.h"

namespace scree::grains::test {
namespace {

ClumpField heap(int n, int height, uint64_t seed = 5) {
  ClumpField field;
  field.sleeps = true;
  field.parameters.damping = 0.05f;
  field.pourClumps(n, height, 0.05f, seed, {1000, 0.5f, 0.05f, 0});
  return field;
}

TEST(ClumpHeap, ComesToRestSleepsAndWakesWhereTouched) {
  ClumpField field = heap(8, 8);
  ASSERT_GE(field.first.size(), 500u);
  int slept = 0;
  double still = 0, deepest = 0;
  for (int tick = 0; tick < 3000 && slept == 0; ++tick) {
    field.step();
    if (field.asleep() == field.grain.size()) slept = tick;
    for (const size_t row : field.first)
      for (size_t k = row; k < row + field.members(row); ++k)
        ASSERT_EQ(field.rest[k].asleep, field.rest[row].asleep) << "half a clump sleeps";
    if (tick == 600) still = field.kineticEnergy() / field.totalMass();
    if (tick > 600) deepest = std::max(deepest, static_cast<double>(field.solver.stats().deepest_overlap));
  }
  std::printf("asleep after %d ticks; %.2e J/kg after 600; deepest overlap %.4f radii; floor bears %.5f\n", slept,
              still, deepest / 0.05, field.weightBorne() / field.totalMass());
  ASSERT_GT(slept, 0);
  EXPECT_NEAR(field.weightBorne() / field.totalMass(), 1, 0.003);
  EXPECT_LT(field.bent(), 1e-5);
  const std::vector<Grain> lay = field.grain;
  field.step(100);
  EXPECT_EQ(field.asleep(), field.grain.size());
  for (size_t k = 0; k < lay.size(); ++k) ASSERT_EQ(lay[k].position, field.grain[k].position);
  // One on top is thrown up: few wake, all sleep again, and bear the same.
  size_t top = 0;
  for (const size_t row : field.first)
    if (field.grain[row].position.y > field.grain[top].position.y) top = row;
  field.velocity[top].linear.y = 1;
  field.step();
  EXPECT_FALSE(field.rest[top].asleep);
  EXPECT_FALSE(field.rest[top + 1].asleep);
  const size_t awake = field.grain.size() - field.asleep();
  EXPECT_LT(awake, field.grain.size() / 10);
  for (int tick = 0; tick < 2000 && field.asleep() != field.grain.size(); ++tick) field.step();
  EXPECT_EQ(field.asleep(), field.grain.size());
  std::printf("%zu woke; then the floor bears %.5f\n", awake, field.weightBorne() / field.totalMass());
  EXPECT_NEAR(field.weightBorne() / field.totalMass(), 1, 0.003);
}

// What sleeps on one that goes wakes and falls, though only its other end was held by it.
TEST(ClumpHeap, WakesWhenWhatBearsItGoes) {
  ClumpField field;
  field.sleeps = true;
  const float r = 0.05f;
  const GrainMaterial m{1000, 0.8f, 0.2f, 0};
  const size_t left = field.addClump(rod(r, r), vec3(-0.1f, r, 0), glm::angleAxis(1.5707963f, vec3(0, 1, 0)), m);
  field.addClump(rod(r, r), vec3(0.1f, r, 0), glm::angleAxis(1.5707963f, vec3(0, 1, 0)), m);
  const size_t beam = field.addClump(std::vector<Sphere>{{vec3(-0.1f, 0, 0), r}, {vec3(0.1f, 0, 0), r}},
                                     vec3(0, 3 * r, 0), quat(1, 0, 0, 0), m);
  field.addBin(1, 0.8f);
  for (int tick = 0; tick < 600 && field.asleep() < 6; ++tick) field.step();
  ASSERT_EQ(field.asleep(), 6u);
  ASSERT_GT(field.grain[beam].position.y, 2.9f * r);
  // Its support is taken away whole.
  field.remove(left + 1);
  field.remove(left);
  field.step(100);
  EXPECT_LT(std::min(field.grain[beam - 2].position.y, field.grain[beam - 1].position.y), 1.5f * r);
}

uint64_t run(int threads, Lanes lanes, bool turn, int save_at, int ticks) {
  setThreadCount(threads);
  ClumpField field = heap(5, 4);
  field.addBox({-2, 0.2f, 0}, {0.02f, 0.15f, 0.2f}, 0.5f);
  field.parameters.lanes = lanes;
  if (turn) {
    const auto reverse = [](auto& list) { std::reverse(list.begin(), list.end()); };
    field.rows();
    reverse(field.entity);
    reverse(field.grain);
    reverse(field.velocity);
    reverse(field.spin);
    reverse(field.orientation);
    reverse(field.previous);
    reverse(field.material);
    reverse(field.clump);
    reverse(field.rest);
  }
  for (int tick = 0; tick < ticks; ++tick) {
    if (tick == save_at) {
      Result<GrainSolver> restored = GrainSolver::restored(field.solver.saved(), 4096);
      EXPECT_TRUE(restored.ok());
      if (restored.ok()) field.solver = std::move(restored).value();
    }
    Collider& box = field.colliders.back();
    box.position0 = box.position1;
    if (tick > ticks - 250) box.position1.x += 0.01f;
    field.step(1, tick % 3 == 0 && tick != save_at && tick > 0 ? RowsAre::AsLeft : RowsAre::Unknown);
  }
  setThreadCount(1);
  EXPECT_TRUE(field.finite());
  return field.state();
}

TEST(ClumpHeap, GivesTheSameBits) {
  for (const int ticks : {120, 900}) {
    const uint64_t want = run(1, Lanes::Widest, false, -1, ticks);
    EXPECT_EQ(run(2, Lanes::Widest, false, -1, ticks), want);
    EXPECT_EQ(run(4, Lanes::Widest, false, -1, ticks), want);
    EXPECT_EQ(run(1, Lanes::Baseline, false, -1, ticks), want);
    EXPECT_EQ(run(2, Lanes::Widest, true, -1, ticks), want) << "order of rows";
    for (const int save_at : {1, 37, 61, 90, 500, 640, 700, 800})
      if (save_at < ticks) {
        EXPECT_EQ(run(2, Lanes::Widest, false, save_at, ticks), want) << "saved at " << save_at;
      }
  }
}

TEST(ClumpHeap, StaysRigidWhileStirred) {
  ClumpField field = heap(4, 3);
  field.sleeps = false;
  Collider& blade = field.addBox({0, 0.1f, 0}, {0.3f, 0.1f, 0.02f}, 0.5f);
  double bent = 0, energy = 0;
  for (int tick = 0; tick < 10000; ++tick) {
    blade.rotation0 = blade.rotation1;
    blade.rotation1 = glm::angleAxis(0.05f * static_cast<float>(tick), vec3(0, 1, 0));
    field.step();
    if (tick % 100 == 0) bent = std::max(bent, field.bent());
    energy = std::max(energy, field.kineticEnergy() / field.totalMass());
  }
  std::printf("bent by %.2e radii at most; %.3f J/kg at most\n", bent, energy);
  EXPECT_LT(bent, 1e-5);
  EXPECT_TRUE(field.finite());
  for (const Grain& g : field.grain) {
    EXPECT_GT(g.position.y, 0);
    EXPECT_LT(std::max(std::abs(g.position.x), std::abs(g.position.z)), 0.6f);
  }
}

TEST(ClumpHostile, StaysFinite) {
  const float r = 0.05f;
  const std::vector<std::vector<Sphere>> forms{
      {{vec3(0), r}, {vec3(0), r}},
      {{vec3(0), r}, {vec3(0), r}, {vec3(0), r}, {vec3(0), r}},
      {{vec3(0), r}, {vec3(r, 0, 0), r / 20}},
      {{vec3(0), r}, {vec3(40 * r, 0, 0), r / 20}},
      {{vec3(0), r}, {vec3(0), r / 20}},
      rod(2 * r, r)};
  for (size_t f = 0; f < forms.size(); ++f) {
    ClumpField field;
    field.sleeps = true;
    for (int k = 0; k < 12; ++k) {
      const auto i = static_cast<float>(k);
      const float spin = k % 4 == 3 ? 1e4f : k % 4 == 2 ? 1e3f : i;
      field.addClump(forms[f], vec3(0.07f * i - 0.4f, 0.3f + 0.1f * i, 0.01f * i),
                     glm::normalize(quat(1, i, -0.3f * i, 2)), {k % 2 == 0 ? 1e-3f : 1e6f, 0.5f, 0.1f, 0.2f},
                     vec3(0, -i, 0), vec3(spin, -0.5f * spin, 0.1f));
    }
    field.addBin(1, 0.5f);
    for (int tick = 0; tick < 600; ++tick) {
      field.step();
      ASSERT_TRUE(field.finite()) << "form " << f << " tick " << tick;
    }
    ASSERT_TRUE(field.solver.refused().empty()) << "form " << f;
    for (const Grain& g : field.grain) EXPECT_GT(g.position.y, -g.radius) << "form " << f;
    EXPECT_LT(field.bent(), f == 3 ? 1e-4 : 1e-5) << "form " << f;  // arms of 800 small radii
  }
}

TEST(ClumpHostile, FallsApartWhenAMemberGoes) {
  ClumpField field = heap(3, 2);
  field.step(5);
  const size_t row = field.first[4];
  field.remove(row + 1);
  field.clump[row].count = 9;  // and nonsense in what is left of it
  field.step();
  EXPECT_EQ(field.solver.broken().size(), 1u + (field.clump[row + 1].first == field.clump[row].first ? 2 : 0));
  for (const Entity broken : field.solver.broken())
    for (size_t k = 0; k < field.entity.size(); ++k)
      if (field.entity[k] == broken) field.clump[k].first = Entity::kNone;
  field.step(300);
  EXPECT_TRUE(field.finite());
}

TEST(ClumpHostile, RefusedMembersLeaveTheOthersFree) {
  ClumpField field;
  const size_t row = field.addClump(rod(0.1f, 0.05f), vec3(0, 1, 0));
  field.step();
  field.velocity[row].linear.x = std::numeric_limits<float>::quiet_NaN();
  field.step();
  ASSERT_EQ(field.solver.refused().size(), 1u);
  ASSERT_EQ(field.solver.broken().size(), 2u);
  field.clump.clear();
  field.first.clear();
  field.grain.resize(2);
  field.step(10);
  EXPECT_TRUE(std::isfinite(field.grain[row + 1].position.y));
  EXPECT_LT(field.grain[row + 1].position.y, 1);
}

// One member leaves the bounds: all are lost.
TEST(ClumpHostile, IsLostWhole) {
  ClumpField field;
  field.parameters.bounds_max.x = 1;
  field.addClump(crooked(0.05f), vec3(0.95f, 0, 0), quat(1, 0, 0, 0), {}, vec3(0.6f, 0, 0));
  field.addClump(rod(0.1f, 0.05f), vec3(0, 1, 0));
  for (int tick = 0; tick < 60 && field.solver.lost().empty(); ++tick) field.step();
  EXPECT_EQ(field.solver.lost().size(), 4u);
}

// Thin walls and fast blades: no member ends on the wrong side, and nothing bends.
TEST(ClumpHostile, DoesNotTunnel) {
  for (const bool moving : {false, true}) {
    ClumpField field;
    field.parameters.gravity = vec3(0);
    for (int k = 0; k < 40; ++k) {
      const float x = 0.3f * static_cast<float>(k % 8), y = 0.3f * static_cast<float>(k / 8);
      field.addClump(k % 2 == 0 ? crooked(0.05f) : rod(0.1f, 0.05f), {x, y, -1},
                     glm::normalize(quat(1, unit(3, static_cast<uint64_t>(k), 1), 0.4f, -0.7f)), {1000, 0.5f, 0, 0.2f},
                     moving ? vec3(0) : vec3(0, 0, 50), vec3(5, 20, 3));
    }
    Collider& wall = field.addBox({1, 0.6f, moving ? -2.0f : 0.0f}, {4, 4, 0.002f}, 0.5f);
    for (int tick = 0; tick < 60; ++tick) {
      wall.position0 = wall.position1;
      if (moving && tick < 30) wall.position1.z += 50.0f / 60;
      field.step();
      for (size_t k = 0; k < field.grain.size(); ++k) {
        const float side = field.grain[k].position.z - wall.position1.z;
        ASSERT_TRUE(moving ? side > 0 : side < 0) << "moving " << moving << " tick " << tick << " grain " << k;
      }
    }
    EXPECT_LT(field.bent(), 1e-5);
  }
}

}  // namespace
}  // namespace scree::grains::test
