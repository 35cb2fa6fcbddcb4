// Grids of volume fraction and mean velocity, against the cloud-in-cell sum in double.
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

const GrainGridValues& valuesOf(Level& level, Entity e) { return *level.world.singleton<const GrainGrids>().of(e); }

double volumeOf(float radius) { return 4.0 / 3 * 3.14159265358979323846 * std::pow(static_cast<double>(radius), 3); }

struct Want {
  std::vector<double> volume;
  std::vector<dvec3> flux;  // volume x velocity
  double inside = 0;        // m^3
};

// Grain by grain, cell by cell.
Want bruteForce(Level& level, Entity e) {
  const GrainGrid& grid = *level.world.peek<GrainGrid>(e);
  const Transform& transform = *level.world.peek<Transform>(e);
  const glm::dmat3 world_from_local = glm::mat3_cast(glm::dquat(glm::normalize(transform.rotation)));
  const dvec3 centre = transform.position - grainField(level.world).origin;
  const dvec3 half(grid.half_extent * glm::abs(transform.scale));
  const glm::ivec3 n(grid.cells[0], grid.cells[1], grid.cells[2]);
  Want want;
  want.volume.resize(static_cast<size_t>(n.x * n.y * n.z));
  want.flux.resize(want.volume.size(), dvec3(0));
  for (const auto& [entity, s] : level.seen()) {
    const dvec3 local = (dvec3(s.position) - centre) * world_from_local;
    if (std::abs(local.x) > half.x || std::abs(local.y) > half.y || std::abs(local.z) > half.z) continue;
    want.inside += volumeOf(s.radius);
    const dvec3 place = (local + half) / (2.0 * half) * dvec3(n) - 0.5;
    for (int z = 0; z < n.z; ++z)
      for (int y = 0; y < n.y; ++y)
        for (int x = 0; x < n.x; ++x) {
          // The tent of each axis, held at the rim.
          double weight = 1;
          const glm::ivec3 cell(x, y, z);
          for (int axis = 0; axis < 3; ++axis) {
            const double p = std::clamp(place[axis], 0.0, n[axis] - 1.0);
            weight *= std::max(0.0, 1 - std::abs(p - cell[axis]));
          }
          const auto at = static_cast<size_t>(x + n.x * (y + n.y * z));
          want.volume[at] += weight * volumeOf(s.radius);
          want.flux[at] += weight * volumeOf(s.radius) * dvec3(s.velocity);
        }
  }
  return want;
}

void expectGrid(Level& level, Entity e, double largest) {
  const GrainGridValues& now = valuesOf(level, e);
  const Want want = bruteForce(level, e);
  ASSERT_EQ(now.fraction.size(), want.volume.size());
  double total = 0;
  for (size_t k = 0; k < want.volume.size(); ++k) {
    const double volume = now.fraction[k] * now.cell_volume;
    total += volume;
    ASSERT_NEAR(volume, want.volume[k], 1e-5 * largest) << k;
    ASSERT_LT(glm::length(volume * dvec3(now.velocity[k]) - want.flux[k]), 1e-4 * largest) << k;
    ASSERT_GE(now.fraction[k], 0);
  }
  ASSERT_NEAR(total, want.inside, 1e-12 * want.inside);
}

TEST(Grid, OneGrainByHand) {
  Level level;
  level.weightless();
  level.grain({0.5f, 0.5f, 0.5f}, 0.1f, {1, -2, 3});
  const Entity e = level.world.spawn(at({1, 1, 1}), GrainGrid{.half_extent = vec3(1), .cells = {2, 2, 2}});
  level.world.find<GrainField>(*level.world.query<With<GrainField>>().tables()[0]->entities().data())->substeps = 1;
  level.run();
  // It has gone 1/60 (1, -2, 3) m in cells of 1 m, from the centre of cell 0.
  const double x = 1.0 / 60, z = 3.0 / 60;
  const GrainGridValues& now = valuesOf(level, e);
  EXPECT_EQ(now.cell_volume, 1);
  const double v = volumeOf(0.1f);
  EXPECT_NEAR(now.fraction[0], v * (1 - x) * (1 - z), 1e-5 * v);
  EXPECT_NEAR(now.fraction[1], v * x * (1 - z), 1e-5 * v);
  EXPECT_EQ(now.fraction[2], 0);  // below the lowest centres: all of it in the lowest cells
  EXPECT_NEAR(now.fraction[4], v * (1 - x) * z, 1e-5 * v);
  EXPECT_NEAR(now.fraction[5], v * x * z, 1e-5 * v);
  for (const size_t k : {0u, 1u, 4u, 5u}) EXPECT_LT(glm::length(now.velocity[k] - vec3(1, -2, 3)), 1e-4f);
  EXPECT_EQ(now.velocity[2], vec3(0));
}

TEST(Grid, EqualsBruteForceForAStreamOntoAHeap) {
  for (const dvec3 place : {dvec3(0, 0, 0), dvec3(-1e6, 1e6, 1e6)}) {
    Level level(2);
    level.heap(place, {6, 3, 6});
    GrainEmitter emitter{.rate = 200, .mouth = 0.2f, .velocity = {0, -2, 0}, .radius = 0.03f};
    emitter.radius_jitter = 0.8f;
    level.world.spawn(at(place + dvec3(0, 1.5, 0)), emitter);
    level.world.spawn(at(place), GrainSink{.half_extent = {0.1f, 0.2f, 0.1f}});
    Transform turned = at(place + dvec3(0.1, 0.3, 0));
    turned.rotation = glm::angleAxis(0.5f, glm::normalize(vec3(1, 2, -1)));
    turned.scale = {1, 2, 0.5f};
    const Entity a = level.world.spawn(turned, GrainGrid{.half_extent = {0.5f, 0.3f, 0.7f}, .cells = {5, 7, 4}});
    const Entity b = level.world.spawn(at(place), GrainGrid{.half_extent = vec3(30), .cells = {1, 1, 1}});
    const Entity c = level.world.spawn(at(place), GrainGrid{.half_extent = vec3(0.4f), .cells = {1, 2, 16}});
    for (int tick = 0; tick < 90; ++tick) {
      level.run();
      if (tick % 6 != 0) continue;
      for (const Entity e : {a, b, c}) expectGrid(level, e, volumeOf(0.06f));
    }
    EXPECT_GT(level.count(), 200u);
    level.sleep(300);
    EXPECT_GT(level.asleep(), 0u);
    for (const Entity e : {a, b, c}) expectGrid(level, e, volumeOf(0.06f));
  }
  setThreadCount(0);
}

TEST(Grid, DustBesideABoulderIsNotLost) {
  Level level;
  level.weightless();
  level.grain({-50, 0, 0}, 10);
  for (int k = 0; k < 100; ++k) level.grain({0.1f * static_cast<float>(k), 0, 0}, 1e-3f);
  const Entity e = level.world.spawn(at({0, 0, 0}), GrainGrid{.half_extent = vec3(100), .cells = {20, 20, 20}});
  level.run();
  const GrainGridValues& now = valuesOf(level, e);
  double all = 0, near = 0;
  for (size_t k = 0; k < now.fraction.size(); ++k) {
    all += now.fraction[k] * now.cell_volume;
    if (k % 20 > 8) near += now.fraction[k] * now.cell_volume;
  }
  EXPECT_NEAR(all, volumeOf(10) + 100 * volumeOf(1e-3f), 1e-12 * all);
  // A sum in double of all would round each grain to 2^-53 of it: no worse than that.
  EXPECT_NEAR(near, 100 * volumeOf(1e-3f), 100 * 0x1p-53 * all);
  EXPECT_GT(near, 99 * volumeOf(1e-3f));
}

TEST(Grid, AtItsIntervalAndWhenItChanges) {
  Level level;
  level.grain({0, 0, 0}, 0.05f);
  grainField(level.world).bounds_min = vec3(-1e4f);
  const Entity e = level.world.spawn(at({0, 0, 0}), GrainGrid{.half_extent = vec3(2000), .cells = {2, 2, 2}, .every = 10});
  level.run();
  EXPECT_EQ(valuesOf(level, e).tick, 1u);
  level.run(8);
  EXPECT_EQ(valuesOf(level, e).tick, 1u);
  level.run();
  EXPECT_EQ(valuesOf(level, e).tick, 10u);
  level.run(3);
  level.world.find<GrainGrid>(e)->cells = {3, 1, 1};
  level.run();
  EXPECT_EQ(valuesOf(level, e).tick, 14u);
  EXPECT_EQ(valuesOf(level, e).fraction.size(), 3u);
  // Without grains it reads zero.
  std::vector<Entity> all;
  level.world.query<With<Grain>>().each([&](Entity grain) { all.push_back(grain); });
  level.world.destroyMany(all);
  level.run(10);
  for (const double f : valuesOf(level, e).fraction) EXPECT_EQ(f, 0);
  level.world.remove<GrainGrid>(e);
  level.run();
  EXPECT_EQ(level.world.singleton<const GrainGrids>().of(e), nullptr);
}

TEST(Grid, BadOnesAreRefused) {
  Level level;
  level.weightless();
  level.grain({0, 0, 0});
  std::vector<Entity> bad;
  const auto refused = [&](GrainGrid grid, Transform transform = {}) { bad.push_back(level.world.spawn(transform, grid)); };
  refused({.half_extent = vec3(0)});
  refused({.half_extent = {1, kNan, 1}});
  refused({.half_extent = {1, kInf, 1}});
  refused({.cells = {0, 1, 1}});
  refused({.cells = {-4, -4, 1}});
  refused({.cells = {2000000000, 2000000000, 2000000000}});
  refused({.cells = {1024, 1024, 2}});
  refused({.every = 0});
  Transform flat;
  flat.scale = {1, 0, 1};
  refused({}, flat);
  refused({}, at({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  const Entity good = level.world.spawn(Transform{}, GrainGrid{});
  level.run(2);
  EXPECT_EQ(level.world.singleton<const GrainGrids>().grids.size(), 1u);
  for (const Entity e : bad) EXPECT_EQ(level.world.singleton<const GrainGrids>().of(e), nullptr);
  expectGrid(level, good, 1);
}

}  // namespace
}  // namespace scree::grains::test
