// A world with the grains module and without GL, for tests of what a level has grains do.
#pragma once

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/random.h"
#include "tests/grains/app.h"

namespace scree::grains::test {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInf = std::numeric_limits<float>::infinity();

struct Level {
  explicit Level(int threads = 1) : app(options(threads)), world(app.world()) {
    setThreadCount(threads);
    addScene(app);
    addDeferred(app);
    addGrains(app);
  }
  static AppOptions options(int threads) {
    AppOptions options;
    options.threads = threads;
    return options;
  }

  App app;
  World& world;

  void run(int ticks = 1) {
    for (int k = 0; k < ticks; ++k) app.tick();
  }
  // Without gravity and damping.
  GrainField& weightless() {
    GrainField& field = grainField(world);
    field.gravity = vec3(0);
    field.damping = 0;
    return field;
  }
  Entity grain(vec3 position, float radius = 0.05f, vec3 velocity = vec3(0), GrainMaterial material = {}) {
    GrainSpec spec;
    spec.grain = {position, radius};
    spec.velocity.linear = velocity;
    spec.material = material;
    spawnGrains(world, {&spec, 1});
    Entity last;
    for (Table* table : world.query<With<Grain>>().tables())
      if (!table->empty()) last = table->entities().back();
    return last;
  }
  size_t count() { return world.query<const Grain>().count(); }
  uint64_t runs(std::string_view name) {
    for (const SystemReport& report : app.schedule().report())
      if (report.name == name) return report.runs;
    return ~uint64_t{0};
  }

  // By entity, whatever the order of the rows.
  struct Seen {
    vec3 position, velocity, spin;
    float radius, density;
    bool asleep;
    bool operator==(const Seen&) const = default;
  };
  std::map<Entity, Seen> seen() {
    std::map<Entity, Seen> all;
    world.query<const Grain, const GrainVelocity, const GrainSpin, const GrainMaterial, const GrainRest>().each(
        [&](Entity e, const Grain& g, const GrainVelocity& v, const GrainSpin& w, const GrainMaterial& m,
            const GrainRest& r) {
          all[e] = {g.position, v.linear, w.angular, g.radius, m.density, r.asleep};
        });
    return all;
  }
  static double massOf(const Seen& s) {
    const double r = static_cast<double>(s.radius);
    return 4.0 / 3 * 3.14159265358979323846 * r * r * r * static_cast<double>(s.density);
  }
  dvec3 momentum() {
    dvec3 sum(0);
    for (const auto& [entity, s] : seen()) sum += massOf(s) * dvec3(s.velocity);
    return sum;
  }
  // Reverses the rows of the grains.
  void turnRows() {
    for (Table* table : world.query<With<Grain>>().tables()) {
      std::vector<uint32_t> order(table->size());
      for (uint32_t k = 0; k < order.size(); ++k) order[k] = static_cast<uint32_t>(order.size()) - 1 - k;
      if (!table->empty()) world.permute(*table, order);
    }
  }
  size_t asleep() {
    size_t n = 0;
    world.query<const GrainRest>().each([&](const GrainRest& r) { n += r.asleep; });
    return n;
  }
  // The deepest overlap of two grains, m, by brute force in double.
  double deepestOverlap() {
    std::vector<Grain> all;
    world.query<const Grain>().each([&](const Grain& g) { all.push_back(g); });
    double worst = 0;
    for (size_t i = 0; i < all.size(); ++i)
      for (size_t j = i + 1; j < all.size(); ++j)
        worst = std::max(worst, static_cast<double>(all[i].radius) + static_cast<double>(all[j].radius) -
                                    glm::length(dvec3(all[i].position) - dvec3(all[j].position)));
    return worst;
  }
  // A heap at rest on a floor whose top is at y = 0.
  void heap(dvec3 place, std::array<int32_t, 3> count) {
    GrainBlock block;
    block.count = count;
    block.radius_jitter = 0.2f;
    block.rolling_friction = 0.05f;
    world.spawn(at(place + dvec3(0, 0.06 * count[1] + 0.1, 0)), block);
    world.spawn(at(place + dvec3(0, -0.5, 0)), BoxCollider{.half_extent = vec3(20, 0.5f, 20)});
  }
  // Ticks until all sleep, at most `most`.
  int sleep(int most = 3000) {
    for (int k = 1; k <= most; ++k) {
      run();
      const GrainStats& stats = world.singleton<const GrainStats>();
      if (stats.grains > 0 && stats.asleep == stats.grains) return k;
    }
    return most + 1;
  }
};

}  // namespace scree::grains::test
