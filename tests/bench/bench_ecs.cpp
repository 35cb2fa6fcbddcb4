// The ECS against plain arrays and against its own slower ways: passes, creation, hashing, saving.
#include <memory>
#include <numeric>
#include <random>

#include "engine/core/hash.h"
#include "engine/core/parallel.h"
#include "engine/ecs/world.h"
#include "tests/bench/bench.h"

namespace scree {
namespace {

struct BenchPosition {
  vec4 position{0};
};
SCREE_COMPONENT(BenchPosition, (position, "m"));

struct BenchVelocity {
  vec4 velocity{0};
};
SCREE_COMPONENT(BenchVelocity, (velocity, "m/s"));

constexpr size_t kEntities = 1000000;
constexpr float kStep = 1.0f / 64;

vec4 startOf(size_t i) {
  return {i, i % 17, i % 5, 1};
}
vec4 velocityOf(size_t i) {
  return {i % 3, 1, -0.5f, 0};
}

void advance(vec4& position, const vec4& velocity) {
  position += velocity * kStep;
}

// What a program without an ECS would have: two arrays, or an object an entity.
struct Arrays {
  Arrays() : positions(kEntities), velocities(kEntities) {}
  std::vector<vec4> positions;
  std::vector<vec4> velocities;
};

struct Object {
  virtual ~Object() = default;
  virtual void update() { advance(position, velocity); }
  vec4 position;
  vec4 velocity;
};

void fill(World& world) {
  world.spawnMany<BenchPosition, BenchVelocity>(
      kEntities, [](size_t i, BenchPosition& p, BenchVelocity& v) {
        p.position = startOf(i);
        v.velocity = velocityOf(i);
      });
}

std::unique_ptr<World> filledWorld() {
  auto world = std::make_unique<World>();
  fill(*world);
  return world;
}

uint64_t hashPositions(World& world) {
  const auto positions = world.tables()[0]->read<BenchPosition>();
  return hashBytes(positions.data(), positions.size_bytes());
}

void benchPasses(bench::Bench& bench) {
  setThreadCount(1);
  const auto world = filledWorld();
  const auto query = world->query<BenchPosition, const BenchVelocity>();
  Arrays arrays;
  std::vector<std::unique_ptr<Object>> objects;
  for (size_t i = 0; i < kEntities; ++i) {
    arrays.positions[i] = startOf(i);
    arrays.velocities[i] = velocityOf(i);
    objects.push_back(std::make_unique<Object>());
    objects.back()->position = startOf(i);
    objects.back()->velocity = velocityOf(i);
  }
  // Objects of a program that has run for a while do not lie in the order of their list.
  std::shuffle(objects.begin(), objects.end(), std::mt19937(1));

  const auto arrays_pass = [&] {
    vec4* p = arrays.positions.data();
    const vec4* v = arrays.velocities.data();
    for (size_t i = 0; i < kEntities; ++i) advance(p[i], v[i]);
  };
  const auto each_pass = [&] {
    query.each([](BenchPosition& p, const BenchVelocity& v) { advance(p.position, v.velocity); });
  };
  const auto spans_pass = [&] {
    query.spans([](auto, std::span<BenchPosition> p, std::span<const BenchVelocity> v) {
      for (size_t i = 0; i < p.size(); ++i) advance(p[i].position, v[i].velocity);
    });
  };
  const auto parallel_pass = [&] {
    query.eachParallel(
        [](BenchPosition& p, const BenchVelocity& v) { advance(p.position, v.velocity); });
  };
  const auto objects_pass = [&] {
    for (const auto& object : objects) object->update();
  };

  // The same passes give the same bytes.
  arrays_pass();
  each_pass();
  const uint64_t expected = hashBytes(arrays.positions.data(), kEntities * sizeof(vec4));
  bench.claimAtMost("bytes after `each` differ from the arrays'", hashPositions(*world) != expected,
                    0);
  arrays_pass();
  spans_pass();
  arrays_pass();
  parallel_pass();
  const uint64_t expected3 = hashBytes(arrays.positions.data(), kEntities * sizeof(vec4));
  bench.claimAtMost("bytes after `spans` and `eachParallel` differ from the arrays'",
                    hashPositions(*world) != expected3, 0);

  const bench::Paired timed = bench.paired({{"arrays", arrays_pass},
                                            {"each", each_pass},
                                            {"spans", spans_pass},
                                            {"eachParallel, 1 thread", parallel_pass},
                                            {"objects", objects_pass}});
  for (size_t i = 0; i < timed.variants.size(); ++i)
    bench.row({.scenario = "pass over 1 M entities, two components of 16 bytes",
               .label = timed.variants[i].name,
               .time_ms = timed.variants[i].median_ms,
               .error_kind = "difference of the bytes",
               .hash = expected,
               .baseline = i == 0 || i == 4});
  bench.claimAtMost("pass: each / arrays", timed.ratio(1, 0).median, 1.15);
  bench.claimAtMost("pass: spans / arrays", timed.ratio(2, 0).median, 1.15);
  bench.claimAtMost("pass: each / objects", timed.ratio(1, 4).median, 0.5);
  setThreadCount(0);
}

void benchCreation(bench::Bench& bench) {
  std::unique_ptr<World> world;
  std::vector<Entity> entities;
  const auto fresh = [&] { world = std::make_unique<World>(); };
  const auto filled = [&] {
    world = filledWorld();
    const auto all = world->tables()[0]->entities();
    entities.assign(all.begin(), all.end());
    std::shuffle(entities.begin(), entities.end(), std::mt19937(2));
  };
  const auto one_by_one = [&] {
    for (size_t i = 0; i < kEntities; ++i)
      world->spawn(BenchPosition{startOf(i)}, BenchVelocity{velocityOf(i)});
  };
  const auto bulk = [&] { fill(*world); };
  fresh();
  one_by_one();
  const uint64_t hash = world->stateHash();
  fresh();
  bulk();
  bench.claimAtMost("world created in bulk differs from one by one", world->stateHash() != hash, 0);

  const bench::Paired created =
      bench.paired({{"one by one", one_by_one, fresh}, {"spawnMany", bulk, fresh}});
  for (size_t i = 0; i < 2; ++i)
    bench.row({.scenario = "creating 1 M entities with values",
               .label = created.variants[i].name,
               .time_ms = created.variants[i].median_ms,
               .error_kind = "difference of the state hash",
               .hash = hash,
               .baseline = i == 0});
  bench.claimAtLeast("creation: one by one / spawnMany", created.ratio(0, 1).median, 5);

  const bench::Paired destroyed =
      bench.paired({{"one by one",
                     [&] {
                       for (Entity entity : entities) world->destroy(entity);
                     },
                     filled},
                    {"destroyMany", [&] { world->destroyMany(entities); }, filled},
                    {"clear", [&] { world->clear(); }, filled}});
  for (size_t i = 0; i < 3; ++i)
    bench.row({.scenario = "destroying 1 M entities in random order",
               .label = destroyed.variants[i].name,
               .time_ms = destroyed.variants[i].median_ms,
               .error_kind = "entities left",
               .hash = World().stateHash(),
               .baseline = i == 0});
  bench.claimAtLeast("destruction: one by one / destroyMany", destroyed.ratio(0, 1).median, 1.5);
}

void benchState(bench::Bench& bench) {
  const auto world = filledWorld();
  const auto query = world->query<BenchPosition>();
  std::vector<uint32_t> order(kEntities);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  Table& table = *world->tables()[0];
  std::string saved;
  World loaded;
  const uint64_t hash = world->stateHash();
  float sum = 0;
  const auto read_all = [&] {
    for (const BenchPosition& p : table.read<BenchPosition>()) sum += p.position.x;
    for (const BenchVelocity& v : table.read<BenchVelocity>()) sum += v.velocity.x;
  };

  const bench::Paired timed =
      bench.paired({{"hash, all columns", [&] { world->stateHashFromScratch(); }},
                    {"hash, one column of two changed", [&] { world->stateHash(); },
                     [&] {
                       world->stateHash();  // the round's permutation changed both
                       query.spans([](auto, std::span<BenchPosition>) {});
                     }},
                    {"hash, nothing changed", [&] { world->stateHash(); }},
                    {"read all", read_all},
                    {"permute at random", [&] { world->permute(table, order); }},
                    {"save to memory", [&] { saved = world->saveBytes(); }},
                    {"load from memory", [&] {
                       if (!loaded.loadBytes(saved, "memory").ok()) std::abort();
                     }}});
  bench.fact("sum of what was read", sum);  // so that it is read
  bench.claimAtMost("state hash after permuting, saving and loading differs",
                    world->stateHash() != hash || loaded.stateHash() != hash, 0);
  for (size_t i = 0; i < timed.variants.size(); ++i)
    bench.row({.scenario = "state of 1 M entities, two components of 16 bytes",
               .label = timed.variants[i].name,
               .knobs = {{"threads", threadCount()}},
               .time_ms = timed.variants[i].median_ms,
               .error_kind = "difference of the state hash",
               .hash = hash,
               .baseline = i == 3});
  bench.claimAtMost("hash: nothing changed / all columns", timed.ratio(2, 0).median, 0.001);
  bench.claimAtMost("hash: one column changed / all columns", timed.ratio(1, 0).median, 0.8);
}

}  // namespace

SCREE_BENCH(ecs, "passes, bulk creation, state hash and saving of 1 M entities") {
  benchPasses(bench);
  benchCreation(bench);
  benchState(bench);
}

}  // namespace scree
