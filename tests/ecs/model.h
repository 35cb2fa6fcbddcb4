// Fuzzer: random operations on a World and on a naive model of it, compared as they go.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <random>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "tests/ecs/components.h"

namespace scree {

// One entity of the model: what it should hold.
struct ModelEntity {
  std::optional<Position> position;
  std::optional<Velocity> velocity;
  std::optional<double> wide;
  std::optional<uint32_t> link;  // weight; the target is compared apart
  Entity link_to;
  bool asleep = false;
  bool marked = false;
};

class Fuzzer {
 public:
  explicit Fuzzer(uint64_t seed) : random_(seed) {}

  // Runs `operations` random operations; compares everything now and then and at the end.
  void run(size_t operations) {
    for (size_t i = 0; i < operations && !::testing::Test::HasFailure(); ++i) {
      SCOPED_TRACE("operation " + std::to_string(i));
      step();
      if (i % 8192 == 8191) compare();
    }
    compare();
  }

  // The naive model's answer to a query against the World's.
  void compare();

 private:
  uint32_t below(uint32_t n) { return static_cast<uint32_t>(random_() % n); }
  bool chance(uint32_t percent) { return below(100) < percent; }
  float number() { return static_cast<float>(below(1000)) * 0.25f; }
  Position position() { return {{number(), number(), number()}, number()}; }
  Velocity velocity() { return {{number(), number(), number()}, number()}; }

  // A handle that is alive four times out of five, dead or made up otherwise.
  Entity anyHandle() {
    if (!alive_.empty() && chance(80)) return alive_[below(static_cast<uint32_t>(alive_.size()))];
    if (!dead_.empty() && chance(90)) return dead_[below(static_cast<uint32_t>(dead_.size()))];
    return {below(100000), below(4)};
  }
  ModelEntity* find(Entity entity) {
    const auto found = model_.find(entity);
    return found == model_.end() ? nullptr : &found->second;
  }
  void born(Entity entity, const ModelEntity& content) {
    ASSERT_TRUE(ever_.insert(entity).second) << "a handle was given out twice";
    model_.emplace(entity, content);
    place_[entity] = alive_.size();
    alive_.push_back(entity);
  }
  void died(Entity entity) {
    model_.erase(entity);
    const size_t at = place_.at(entity);
    place_[alive_.back()] = at;
    alive_[at] = alive_.back();
    alive_.pop_back();
    place_.erase(entity);
    dead_.push_back(entity);
  }

  void step();
  void spawnOne();
  void spawnMany();
  void destroyOne();
  void destroyMany();
  void addOne();
  void removeOne();
  void writeOne();
  void permuteOne();
  void recordAndFlush();
  void iterate();

  std::mt19937_64 random_;
  World world_;
  std::unordered_map<Entity, ModelEntity> model_;
  std::vector<Entity> alive_;
  std::unordered_map<Entity, size_t> place_;
  std::vector<Entity> dead_;
  std::unordered_set<Entity> ever_;
  uint32_t serial_ = 1u << 20;
  // Made at the start, so that they have to follow all tables that appear later.
  Query<Position> positions_ = world_.query<Position>();
  Query<const Position, Velocity, Without<Asleep>> moving_ =
      world_.query<const Position, Velocity, Without<Asleep>>();
  Query<With<Marked>> marked_ = world_.query<With<Marked>>();
};

}  // namespace scree
