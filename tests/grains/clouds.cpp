// Many grains: conservation, neighbours against brute force, robustness, weight, threads.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "engine/core/parallel.h"
#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

TEST(Cloud, ConservesMomentum) {
  Field field;
  field.parameters.gravity = vec3(0);
  constexpr uint64_t kSeed = 11;
  for (uint64_t k = 0; k < 400; ++k) {
    const vec3 at = (unitCube(kSeed, k) - 0.5f) * 1.2f;
    const float radius = 0.03f + 0.03f * unit(kSeed, k, 7);
    field.add(at, radius, {1000, 0.4f, 0.01f, 0.5f}, -2.0f * at + (unitCube(kSeed, k, 3) - 0.5f));
  }
  const glm::dvec3 linear = field.momentum();
  double scale = 0;
  for (size_t k = 0; k < field.grain.size(); ++k)
    scale += field.mass(k) * static_cast<double>(glm::length(field.velocity[k].linear));
  const double start = field.kineticEnergy();
  double last = start;
  for (int tick = 0; tick < 120; ++tick) {
    field.step();
    const double now = field.kineticEnergy();
    EXPECT_LT(now, last + 1e-4 * start) << "energy grew at tick " << tick;
    last = now;
  }
  EXPECT_TRUE(field.finite());
  EXPECT_LT(glm::length(field.momentum() - linear) / scale, 1e-5);
  EXPECT_LT(last, 0.9 * start);
}

TEST(Cloud, ConservesAngularMomentumWhileNothingOverlaps) {
  // Loose, so that hardly any overlap has to be undone (that shift is the one step which moves
  // mass without an impulse).
  Field field;
  field.parameters.gravity = vec3(0);
  field.parameters.substeps = 16;
  constexpr uint64_t kSeed = 12;
  for (int x = 0; x < 5; ++x)
    for (int y = 0; y < 5; ++y)
      for (int z = 0; z < 5; ++z) {
        const vec3 at = 0.16f * (vec3(x, y, z) - 2.0f);
        const uint64_t k = field.grain.size();
        field.add(at, 0.05f, {1000, 0.4f, 0, 0},
                  glm::cross(vec3(0, 1, 0), at) * 2.0f + 0.5f * (unitCube(kSeed, k) - 0.5f));
      }
  const glm::dvec3 before = field.angularMomentum();
  field.step(60);
  EXPECT_LT(glm::length(field.angularMomentum() - before) / glm::length(before), 2e-4);
}

// Pairs by brute force, with the same test of single-precision numbers.
std::vector<std::pair<uint32_t, uint32_t>> bruteForce(const Field& field, float margin_share) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t i = 0; i < field.grain.size(); ++i)
    for (uint32_t j = i + 1; j < field.grain.size(); ++j) {
      const Grain &a = field.grain[i], &b = field.grain[j];
      const vec3 d = b.position - a.position;
      const float reach = (a.radius + margin_share * a.radius) + (b.radius + margin_share * b.radius);
      if (d.x * d.x + d.y * d.y + d.z * d.z < reach * reach) pairs.emplace_back(i, j);
    }
  return pairs;
}

// One search over the field as it stands, without the rest of the solver.
std::vector<std::pair<uint32_t, uint32_t>> search(const Field& field, float margin_share) {
  const uint32_t n = static_cast<uint32_t>(field.grain.size());
  Bodies bodies, sorted;
  bodies.count = sorted.count = n;
  bodies.body.resize(n);
  bodies.margin.resize(n);
  bodies.entity = field.entity;
  for (const GrainMaterial& material : field.material)
    bodies.material.push_back(bodies.materials.numberOf(material));
  sorted.materials = bodies.materials;
  for (uint32_t k = 0; k < n; ++k) {
    bodies.body[k].position = field.grain[k].position;
    bodies.body[k].radius = field.grain[k].radius;
    bodies.margin[k] = margin_share * field.grain[k].radius;
  }
  Grid grid;
  Workspace workspace;
  const std::vector<uint32_t> before(n, kNoSlot);
  for (const uint32_t from : grid.plan(bodies, workspace)) {
    sorted.body.push_back(bodies.body[from]);
    sorted.entity.push_back(bodies.entity[from]);
    sorted.material.push_back(bodies.material[from]);
    sorted.margin.push_back(bodies.margin[from]);
  }
  grid.read(sorted);
  PairLists lists, none;
  lists.build(grid, sorted, none, before, {}, workspace);
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (uint32_t s = 0; s < lists.slab_count; ++s) {
    const PairSlab& slab = lists.slab[s];
    const uint32_t above = grid.slabAbove(s);
    for (uint32_t c = 0; c < slab.count; c += kBatch) {
      std::set<uint32_t> batch;
      for (uint32_t k = c; k < c + kBatch; ++k) {
        // Lanes of a batch never share a body.
        EXPECT_TRUE(batch.insert(slab.i[k]).second && batch.insert(slab.j[k]).second);
        if (slab.i[k] >= n) continue;
        const uint32_t a = sorted.entity[slab.i[k]].index, b = sorted.entity[slab.j[k]].index;
        pairs.emplace_back(std::min(a, b), std::max(a, b));
        // A slab touches its own grains and those of the slab above.
        for (const uint32_t slot : {slab.i[k], slab.j[k]})
          EXPECT_TRUE(grid.slabOf(slot) == s || grid.slabOf(slot) == above);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(Neighbours, AreThoseOfBruteForce) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Field field;
    for (uint64_t k = 0; k < 1500; ++k)
      field.add(unitCube(seed, k) * 2.0f - 1.0f, 0.03f + 0.02f * unit(seed, k, 3));
    EXPECT_EQ(search(field, 0.12f), bruteForce(field, 0.12f)) << "seed " << seed;
  }
}

TEST(Neighbours, OfAnyMixOfRadii) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Field field;
    for (uint64_t k = 0; k < 1500; ++k) {
      // 1 : 20, evenly over the logarithm; the last seeds 1 : 400 and one boulder.
      const double octaves = seed < 4 ? 20 : 400;
      const float radius = 0.01f * static_cast<float>(std::pow(octaves, static_cast<double>(unit(seed, k, 3))));
      field.add((unitCube(seed, k) * 2.0f - 1.0f) * 1.5f, seed == 6 ? 0.02f : radius);
    }
    if (seed == 6) field.add({0.2f, 0.3f, -0.1f}, 1.1f);
    EXPECT_EQ(search(field, 0.12f), bruteForce(field, 0.12f)) << "seed " << seed;
  }
}

TEST(Neighbours, AtNegativeAndHugeCoordinates) {
  // Clusters around cells up to +-2^31 and beyond, where one coordinate step is many cells, and
  // clusters whose cells share buckets.
  for (const float far : {1e3f, 1e5f, 1e7f, 2.3e8f, 9e8f}) {
    Field field;
    uint64_t k = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const vec3 at((corner & 1) != 0 ? far : -far, (corner & 2) != 0 ? far : -far,
                    (corner & 4) != 0 ? far : -far);
      for (int n = 0; n < 60; ++n, ++k)
        field.add(at + (unitCube(5, k) - 0.5f) * 0.8f, 0.05f);
    }
    for (int n = 0; n < 60; ++n, ++k) field.add((unitCube(5, k) - 0.5f) * 0.8f, 0.05f);
    EXPECT_EQ(search(field, 0.12f), bruteForce(field, 0.12f)) << "at " << far;
  }
}

TEST(Neighbours, AcrossSlabsAndWrappedTables) {
  // Long thin rows along each axis: more cells than the table has along it.
  for (int axis = 0; axis < 3; ++axis) {
    Field field;
    for (uint64_t k = 0; k < 3000; ++k) {
      vec3 at = (unitCube(8, k) - 0.5f) * 0.2f;
      at[axis] = (unit(8, k, 9) - 0.5f) * 400;
      field.add(at, 0.05f);
    }
    EXPECT_EQ(search(field, 0.3f), bruteForce(field, 0.3f)) << "axis " << axis;
  }
}

TEST(Robust, ThousandCoincidentCentres) {
  Field field;
  field.parameters.gravity = vec3(0);
  for (int k = 0; k < 1000; ++k) field.add({1, 2, 3}, 0.05f);
  for (int tick = 0; tick < 20; ++tick) {
    field.step();
    ASSERT_TRUE(field.finite()) << "tick " << tick;
  }
  EXPECT_LT(glm::length(field.momentum()), 1e-5 * 1000 * field.mass(0));
  // Bounded: nothing is thrown farther than the cloud that a thousand grains fill.
  glm::dvec3 centre(0);
  double reach = 0;
  for (const Grain& g : field.grain) centre += glm::dvec3(g.position) / 1000.0;
  for (const Grain& g : field.grain)
    reach = std::max(reach, glm::length(glm::dvec3(g.position) - glm::dvec3(1, 2, 3)));
  EXPECT_NEAR(glm::length(centre - glm::dvec3(1, 2, 3)), 0, 1e-3);
  EXPECT_LT(reach, 3.0);
  EXPECT_GT(reach, 0.2);
}

TEST(Robust, TickLengths) {
  for (const float dt : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), 1e-9f, 1e-4f, 0.1f,
                         10.0f, std::numeric_limits<float>::infinity()}) {
    Field field;
    pour(field, 5, 5, 0.05f, 3);
    field.step(60);
    const double energy = field.energy();
    field.parameters.dt = dt;
    double worst = energy;
    for (int tick = 0; tick < 30; ++tick) {
      field.step();
      ASSERT_TRUE(field.finite()) << "dt " << dt << " tick " << tick;
      worst = std::max(worst, field.energy());
    }
    // Undoing overlap may lift grains by parts of a radius, no more.
    EXPECT_LT(worst, energy + 0.02 * std::abs(energy)) << "dt " << dt;
    field.parameters.dt = 1.0f / 60;
    field.step(30);
    ASSERT_TRUE(field.finite());
    EXPECT_LT(field.energy(), energy + 0.02 * std::abs(energy)) << "dt " << dt;
  }
}

TEST(Robust, BadGrainsAreRefusedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinite = std::numeric_limits<float>::infinity();
  Field field;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
  field.add({0, 1, 0}, 0.05f);
  for (const float radius : {0.0f, -1.0f, nan, infinite, 1e-7f, 1e6f}) field.add({0, 2, 0}, radius);
  for (const float density : {0.0f, -1000.0f, nan, infinite})
    field.add({0, 2, 0}, 0.05f, {density, 0.5f, 0, 0});
  field.add({0, 2, 0}, 0.05f, {1000, -0.5f, 0, 0});
  field.add({0, 2, 0}, 0.05f, {1000, 0.5f, 0, 1.5f});
  field.add({nan, 2, 0}, 0.05f);
  field.add({0, 2, 0}, 0.05f, {}, {0, nan, 0});
  field.add({0, 2, 0}, 0.05f, {}, {0, 1e9f, 0});
  field.add({0, 3, 0}, 0.05f);
  field.step(60);
  EXPECT_EQ(field.solver.refused().size(), field.grain.size() - 2);
  EXPECT_EQ(field.solver.stats().grains, 2u);
  EXPECT_NEAR(field.grain[0].position.y, 0.05, 1e-3);
  EXPECT_LT(field.grain.back().position.y, 0.3f);
}

TEST(Robust, GrainsOutsideTheBoundsAreLost) {
  Field field;
  field.parameters.bounds_min = {-10, -5, -10};
  field.parameters.bounds_max = {10, 50, 10};
  field.add({0, 0, 0}, 0.05f);
  field.add({0, 0, 0.5f}, 0.05f, {}, {30, 0, 0});
  field.addPlane({0, -1, 0}, quat(1, 0, 0, 0), 0.5f);
  field.step(30);
  ASSERT_EQ(field.solver.lost().size(), 1u);
  EXPECT_EQ(field.solver.lost()[0], field.entity[1]);
}

TEST(Robust, BoulderOnOneLayer) {
  // A million times the mass: 100 times the radius. It must not sink through the layer.
  Field field;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.6f).sensed = true;
  const float r = 0.05f;
  for (int x = -12; x <= 12; ++x)
    for (int z = -12; z <= 12; ++z)
      field.add({0.1f * static_cast<float>(x), r, 0.1f * static_cast<float>(z)}, r, {1000, 0.6f, 0, 0});
  const float big = 100 * r;
  const size_t boulder = field.add({0.02f, 2 * r + big + 0.01f, 0.013f}, big, {1000, 0.6f, 0, 0});
  EXPECT_NEAR(field.mass(boulder) / field.mass(0), 1e6, 1);
  for (int tick = 0; tick < 240; ++tick) {
    field.step();
    ASSERT_TRUE(field.finite()) << tick;
    ASSERT_GT(field.grain[boulder].position.y, big + r) << "sunk at tick " << tick;
  }
  // It lies on its grains, whole and at rest but for a slow roll.
  EXPECT_LT(std::abs(field.velocity[boulder].linear.y), 0.02f);
  EXPECT_LT(glm::length(field.velocity[boulder].linear), 0.3f);
  double deepest = 0;
  for (size_t k = 0; k < boulder; ++k)
    deepest = std::max<double>(deepest, r + big - glm::length(field.grain[k].position -
                                                               field.grain[boulder].position));
  EXPECT_LT(deepest, 0.2 * static_cast<double>(r));
  // The floor feels the true weight.
  double load = 0;
  for (int tick = 0; tick < 60; ++tick) {
    field.step();
    load -= field.colliders[0].load.y;
  }
  const double mass = field.mass(boulder) + static_cast<double>(boulder) * field.mass(0);
  EXPECT_NEAR(load / (mass * 9.81), 1, 0.02);
}

TEST(Weight, FloorCarriesWhatLiesOnIt) {
  Field field;
  field.addBox({0, -0.5f, 0}, {5, 0.5f, 5}, 0.5f).sensed = true;
  constexpr uint64_t kSeed = 4;
  // A free heap: no walls that could carry a part of it.
  for (int y = 0; y < 6; ++y)
    for (int z = 0; z < 10 - y; ++z)
      for (int x = 0; x < 10 - y; ++x) {
        const uint64_t k = field.grain.size();
        field.add(vec3(static_cast<float>(x) + 0.5f * static_cast<float>(y), static_cast<float>(y) + 0.5f,
                       static_cast<float>(z) + 0.5f * static_cast<float>(y)) * 0.115f +
                      (unitCube(kSeed, k) - 0.5f) * 0.01f,
                  0.05f * (0.85f + 0.3f * unit(kSeed, k, 5)), {1000, 0.6f, 0.02f, 0});
      }
  double mass = 0;
  for (size_t k = 0; k < field.grain.size(); ++k) mass += field.mass(k);
  field.step(400);
  double impulse = 0;
  for (int tick = 0; tick < 60; ++tick) {
    field.step();
    const double now = -field.colliders[0].load.y * 60 / 9.81;
    EXPECT_NEAR(now / mass, 1, 0.005) << "tick " << tick;
    impulse += now / 60;
  }
  EXPECT_NEAR(impulse / mass, 1, 0.001);
  EXPECT_GT(field.colliders[0].load_contacts, 20u);
}

TEST(Heap, ComesToRest) {
  Field field;
  field.parameters.damping = 0.05f;
  pour(field, 8, 12, 0.05f, 6, 0.2f, {1000, 0.5f, 0.02f, 0});
  field.step(360);
  double mass = 0;
  for (size_t k = 0; k < field.grain.size(); ++k) mass += field.mass(k);
  double worst = 0;
  for (int tick = 0; tick < 120; ++tick) {
    field.step();
    worst = std::max(worst, field.kineticEnergy() / mass);
  }
  EXPECT_LT(worst, 1e-6);  // J/kg: 1.4 mm/s
  EXPECT_LT(field.deepestOverlap(), 0.01);
}

TEST(Heap, EnergyNeverGrows) {
  for (const float e : {0.0f, 0.6f}) {
    Field field;
    pour(field, 6, 10, 0.05f, 9, 0.2f, {1000, 0.4f, 0, e});
    for (Collider& c : field.colliders) c.restitution = e;
    double last = field.energy();
    const double start = last;
    for (int tick = 0; tick < 240; ++tick) {
      field.step();
      const double now = field.energy();
      EXPECT_LT(now, last + 1e-3 * start) << "restitution " << e << " tick " << tick;
      last = now;
    }
    EXPECT_LT(last, 0.8 * start);
  }
}

TEST(Heap, IsTheSameForEveryThreadCount) {
  uint64_t want = 0;
  for (const int threads : {1, 2, 4}) {
    setThreadCount(threads);
    Field field;
    pour(field, 9, 12, 0.05f, 21, 0.3f, {1000, 0.5f, 0.01f, 0.3f});
    field.step(90);
    EXPECT_GT(field.solver.stats().pairs, kFewPairs);  // else threads have nothing to do
    if (threads == 1) want = field.hash();
    EXPECT_EQ(field.hash(), want) << threads << " threads";
  }
  setThreadCount(0);
}

TEST(Heap, IsTheSameForEveryOrderOfRows) {
  uint64_t want = 0;
  for (uint64_t shuffle = 0; shuffle < 3; ++shuffle) {
    Field field;
    pour(field, 7, 8, 0.05f, 22, 0.3f);
    const size_t n = field.grain.size();
    const auto swapRows = [&](size_t a, size_t b) {
      std::swap(field.entity[a], field.entity[b]);
      std::swap(field.grain[a], field.grain[b]);
      std::swap(field.velocity[a], field.velocity[b]);
      std::swap(field.spin[a], field.spin[b]);
      std::swap(field.orientation[a], field.orientation[b]);
      std::swap(field.previous[a], field.previous[b]);
      std::swap(field.material[a], field.material[b]);
    };
    for (int tick = 0; tick < 80; ++tick) {
      // In the last run rows even change places while it runs.
      if (shuffle == 2 || (shuffle == 1 && tick == 0))
        for (size_t k = n - 1; k > 0; --k)
          swapRows(k, randomBits(shuffle, k, static_cast<uint64_t>(tick), 0) % (k + 1));
      field.step();
    }
    if (shuffle == 0) want = field.hash();
    EXPECT_EQ(field.hash(), want) << "shuffle " << shuffle;
  }
}

TEST(Heap, GrainsComeAndGo) {
  // Removing and adding rows keeps what the others carry: the pile under a removed grain stays.
  Field field;
  field.parameters.damping = 0.05f;
  pour(field, 6, 6, 0.05f, 23, 0.1f, {1000, 0.5f, 0.02f, 0});
  field.step(300);
  const auto erase = [&](size_t k) {
    field.entity.erase(field.entity.begin() + static_cast<long>(k));
    field.grain.erase(field.grain.begin() + static_cast<long>(k));
    field.velocity.erase(field.velocity.begin() + static_cast<long>(k));
    field.spin.erase(field.spin.begin() + static_cast<long>(k));
    field.orientation.erase(field.orientation.begin() + static_cast<long>(k));
    field.previous.erase(field.previous.begin() + static_cast<long>(k));
    field.material.erase(field.material.begin() + static_cast<long>(k));
  };
  size_t top = 0;
  for (size_t k = 0; k < field.grain.size(); ++k)
    if (field.grain[k].position.y > field.grain[top].position.y) top = k;
  const std::vector<Grain> before = field.grain;
  erase(top);
  field.step(10);
  EXPECT_EQ(field.solver.stats().grains, field.grain.size());
  // Away from where it lay, nothing has moved.
  double moved = 0;
  for (size_t k = 0; k < field.grain.size(); ++k) {
    const Grain& was = before[k + (k >= top ? 1 : 0)];
    if (glm::length(was.position - before[top].position) < 0.25f) continue;
    moved = std::max<double>(moved, glm::length(field.grain[k].position - was.position));
  }
  // A quarter of a radius: the pile resettles a little when its rows move, but nothing jumps.
  EXPECT_LT(moved, 0.0125);
  field.add({0, 2, 0}, 0.05f);
  field.step(60);
  EXPECT_TRUE(field.finite());
  EXPECT_LT(field.grain.back().position.y, 1.0f);
  field.grain.clear();  // and an empty field is fine
  field.entity.clear();
  field.velocity.clear();
  field.spin.clear();
  field.orientation.clear();
  field.previous.clear();
  field.material.clear();
  field.step(2);
  EXPECT_EQ(field.solver.stats().grains, 0u);
  field.add({0, 2, 0}, 0.05f);
  field.step(60);
  EXPECT_EQ(field.solver.stats().grains, 1u);
}

TEST(Heap, AllocatesNothingOnceItHasRun) {
  Field field;
  pour(field, 8, 10, 0.05f, 25);
  field.step(240);
  const uint64_t before = field.solver.stats().allocations;
  field.step(240);
  EXPECT_EQ(field.solver.stats().allocations, before);
}

TEST(Mix, OneToTwentyLiesWithoutOverlap) {
  Field field;
  field.parameters.damping = 0.05f;
  field.addBin(0.55f, 0.4f);
  constexpr uint64_t kSeed = 31;
  // Four great grains of 0.2 m among small ones of 0.01 to 0.03 m.
  for (int k = 0; k < 4; ++k)
    field.add({(k & 1) != 0 ? 0.25f : -0.25f, 0.25f, (k & 2) != 0 ? 0.25f : -0.25f}, 0.2f,
              {1000, 0.4f, 0, 0});
  for (int y = 0; y < 6; ++y)
    for (int z = 0; z < 14; ++z)
      for (int x = 0; x < 14; ++x) {
        const uint64_t k = field.grain.size();
        field.add(vec3(static_cast<float>(x) - 6.5f, static_cast<float>(y) + 7.5f,
                       static_cast<float>(z) - 6.5f) * 0.07f +
                      (unitCube(kSeed, k) - 0.5f) * 0.004f,
                  0.01f + 0.02f * unit(kSeed, k, 4), {1000, 0.4f, 0, 0});
      }
  field.step(240);
  EXPECT_TRUE(field.finite());
  EXPECT_LT(field.deepestOverlap(), 0.1);
  for (size_t k = 0; k < field.grain.size(); ++k) {
    const Grain& g = field.grain[k];
    EXPECT_GT(g.position.y, 0.9f * g.radius) << k;
    EXPECT_LT(std::abs(g.position.x), 0.55f) << k;
  }
}

}  // namespace
}  // namespace scree::grains::test
