// The operations of the Fuzzer, each on the World and on the model.
#pragma once

#include <algorithm>
#include <numeric>

#include "tests/ecs/model.h"

namespace scree {

inline void Fuzzer::step() {
  // Grows up to some thousands of entities, then shrinks and grows.
  const uint32_t dice = below(1000);
  const bool crowded = alive_.size() > 3000;
  if (dice < (crowded ? 100u : 300u)) return spawnOne();
  if (dice < 305) return spawnMany();
  if (dice < 480) return destroyOne();
  if (dice < 483) return destroyMany();
  if (dice < 640) return addOne();
  if (dice < 760) return removeOne();
  if (dice < 960) return writeOne();
  if (dice < 962) return permuteOne();
  if (dice < 998) return recordAndFlush();
  if (dice < 999 || alive_.size() < 2000 || below(50)) return iterate();
  world_.clear();
  while (!alive_.empty()) died(alive_.back());
}

inline void Fuzzer::spawnOne() {
  ModelEntity content;
  switch (below(7)) {
    case 0:
      return born(world_.spawn(), content);
    case 1:
      content.position = position();
      return born(world_.spawn(*content.position), content);
    case 2:
      content.position = position();
      content.velocity = velocity();
      return born(world_.spawn(*content.position, *content.velocity), content);
    case 3:
      content.position = position();
      content.velocity = velocity();
      content.asleep = true;
      return born(world_.spawn(Asleep{}, *content.velocity, *content.position), content);
    case 4:
      content.wide = number();
      content.marked = true;
      return born(world_.spawn(Marked{}, Wide{*content.wide}), content);
    case 5:
      content.link = serial_++;
      content.link_to = anyHandle();
      return born(world_.spawn(Link{content.link_to, *content.link}), content);
    default:
      content.asleep = true;
      return born(world_.spawn(Asleep{}), content);
  }
}

inline void Fuzzer::spawnMany() {
  const size_t count = below(alive_.size() > 3000 ? 8 : 200);
  ModelEntity content;
  if (chance(50)) {
    content.position = position();
    content.marked = true;
    const TableRows rows = world_.spawnMany(count, *content.position, Marked{});
    for (Entity entity : rows.entities()) born(entity, content);
  } else {
    content.velocity = Velocity{};
    content.wide = Wide{}.value;
    const TableRows rows = world_.spawnMany<Velocity, Wide>(count);
    for (Entity entity : rows.entities()) born(entity, content);
  }
}

inline void Fuzzer::destroyOne() {
  const Entity entity = anyHandle();
  const bool expected = find(entity) != nullptr;
  ASSERT_EQ(world_.destroy(entity), expected);
  ASSERT_FALSE(world_.alive(entity));
  if (expected) died(entity);
}

inline void Fuzzer::destroyMany() {
  std::vector<Entity> doomed;
  if (chance(20) && !world_.tables().empty()) {  // a whole table
    const auto entities =
        world_.tables()[below(static_cast<uint32_t>(world_.tables().size()))]->entities();
    doomed.assign(entities.begin(), entities.end());
  }
  for (uint32_t i = below(100); i > 0; --i) doomed.push_back(anyHandle());
  const size_t before = model_.size();
  const size_t destroyed = world_.destroyMany(doomed);
  for (Entity entity : doomed)
    if (find(entity)) died(entity);
  ASSERT_EQ(destroyed, before - model_.size());
}

inline void Fuzzer::addOne() {
  const Entity entity = anyHandle();
  ModelEntity* content = find(entity);
  const bool expected = content != nullptr;
  switch (below(6)) {
    case 0: {
      const Position value = position();
      ASSERT_EQ(world_.add(entity, value) != nullptr, expected);
      if (content) content->position = value;
      break;
    }
    case 1: {
      const Velocity value = velocity();
      ASSERT_EQ(world_.add(entity, value) != nullptr, expected);
      if (content) content->velocity = value;
      break;
    }
    case 2: {
      const double value = number();
      ASSERT_EQ(world_.add(entity, Wide{value}) != nullptr, expected);
      if (content) content->wide = value;
      break;
    }
    case 3: {
      const Link value{anyHandle(), serial_++};
      ASSERT_EQ(world_.add(entity, value) != nullptr, expected);
      if (content) content->link = value.weight, content->link_to = value.to;
      break;
    }
    case 4:
      ASSERT_EQ(world_.add<Asleep>(entity) != nullptr, expected);
      if (content) content->asleep = true;
      break;
    default:
      ASSERT_EQ(findComponent("Marked")->addDefault(world_, entity) != nullptr, expected);
      if (content) content->marked = true;
      break;
  }
}

inline void Fuzzer::removeOne() {
  const Entity entity = anyHandle();
  ModelEntity* content = find(entity);
  ModelEntity nothing;
  ModelEntity& m = content ? *content : nothing;
  switch (below(6)) {
    case 0:
      ASSERT_EQ(world_.remove<Position>(entity), m.position.has_value());
      m.position = {};
      break;
    case 1:
      ASSERT_EQ(world_.remove<Velocity>(entity), m.velocity.has_value());
      m.velocity = {};
      break;
    case 2:
      ASSERT_EQ(world_.remove<Wide>(entity), m.wide.has_value());
      m.wide = {};
      break;
    case 3:
      ASSERT_EQ(world_.remove<Link>(entity), m.link.has_value());
      m.link = {};
      break;
    case 4:
      ASSERT_EQ(world_.remove<Asleep>(entity), m.asleep);
      m.asleep = false;
      break;
    default:
      ASSERT_EQ(world_.remove<Marked>(entity), m.marked);
      m.marked = false;
      break;
  }
}

inline void Fuzzer::writeOne() {
  const Entity entity = anyHandle();
  ModelEntity* content = find(entity);
  ASSERT_EQ(world_.alive(entity), content != nullptr);
  Position* found = world_.find<Position>(entity);
  ASSERT_EQ(found != nullptr, content && content->position);
  if (!found) return;
  ASSERT_EQ(*found, *content->position);
  *found = position();
  content->position = *found;
}

inline void Fuzzer::permuteOne() {
  if (world_.tables().empty()) return;
  Table& table = *world_.tables()[below(static_cast<uint32_t>(world_.tables().size()))];
  std::vector<uint32_t> order(table.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random_);
  world_.permute(table, order);
}

inline void Fuzzer::recordAndFlush() {
  Commands& commands = world_.commands();
  FlushResult expected;
  std::vector<std::pair<uint32_t, ModelEntity>> spawned;  // by their links' weights
  for (uint32_t i = below(12); i > 0; --i) {
    const Entity entity = anyHandle();
    ModelEntity* content = find(entity);
    switch (below(4)) {
      case 0: {
        // Links to itself, so that it can be found, and gets a velocity by its pending handle.
        ModelEntity fresh;
        fresh.link = serial_++;
        fresh.velocity = velocity();
        const Entity pending = commands.spawn(Marked{}, Link{Entity{}, 0});
        commands.add(pending, Link{pending, *fresh.link});
        commands.add(pending, *fresh.velocity);
        commands.remove<Marked>(pending);
        expected.applied += 4;
        spawned.emplace_back(*fresh.link, fresh);
        break;
      }
      case 1:
        commands.destroy(entity);
        ++(content ? expected.applied : expected.refused);
        if (content) died(entity);
        break;
      case 2: {
        const Position value = position();
        commands.add(entity, value);
        ++(content ? expected.applied : expected.refused);
        if (content) content->position = value;
        break;
      }
      default:
        commands.remove<Velocity>(entity);
        ++(content && content->velocity ? expected.applied : expected.refused);
        if (content) content->velocity = {};
        break;
    }
  }
  const FlushResult result = world_.flush();
  ASSERT_EQ(result.applied, expected.applied);
  ASSERT_EQ(result.refused, expected.refused);
  if (spawned.empty()) return;
  world_.query<const Link>().each([&](Entity entity, const Link& link) {
    for (auto& [weight, content] : spawned) {
      if (link.weight != weight) continue;
      EXPECT_EQ(link.to, entity) << "a pending handle in a component names the new entity";
      content.link_to = entity;
      born(entity, content);
    }
  });
}

inline void Fuzzer::iterate() {
  const float add = number();
  moving_.each([&](Entity entity, const Position& p, Velocity& v) {
    ModelEntity* content = find(entity);
    ASSERT_TRUE(content && content->position && content->velocity && !content->asleep);
    ASSERT_EQ(p, *content->position);
    ASSERT_EQ(v, *content->velocity);
    v.drag = add;
    content->velocity = v;
  });
}

inline void Fuzzer::compare() {
  ASSERT_EQ(world_.entityCount(), model_.size());
  size_t positions = 0;
  size_t moving = 0;
  size_t marked = 0;
  for (const auto& [entity, content] : model_) {
    ASSERT_TRUE(world_.alive(entity));
    const Position* p = world_.peek<Position>(entity);
    const Velocity* v = world_.peek<Velocity>(entity);
    const Wide* w = world_.peek<Wide>(entity);
    const Link* l = world_.peek<Link>(entity);
    ASSERT_EQ(p != nullptr, content.position.has_value());
    ASSERT_EQ(v != nullptr, content.velocity.has_value());
    ASSERT_EQ(w != nullptr, content.wide.has_value());
    ASSERT_EQ(l != nullptr, content.link.has_value());
    ASSERT_EQ(world_.has<Asleep>(entity), content.asleep);
    ASSERT_EQ(world_.has<Marked>(entity), content.marked);
    ASSERT_TRUE(!p || *p == *content.position);
    ASSERT_TRUE(!v || *v == *content.velocity);
    ASSERT_TRUE(!w || w->value == *content.wide);
    ASSERT_TRUE(!l || l->weight == *content.link);
    ASSERT_TRUE(!l || l->to == content.link_to);
    const size_t parts = size_t{p != nullptr} + (v != nullptr) + (w != nullptr) + (l != nullptr) +
                         content.asleep + content.marked;
    ASSERT_EQ(world_.componentIds(entity).size(), parts);
    positions += p != nullptr;
    moving += p && v && !content.asleep;
    marked += content.marked;
  }
  ASSERT_EQ(positions_.count(), positions);
  ASSERT_EQ(moving_.count(), moving);
  ASSERT_EQ(marked_.count(), marked);
  ASSERT_EQ(positions_.empty(), positions == 0);
  ASSERT_EQ(moving_.empty(), moving == 0);
  ASSERT_EQ(marked_.empty(), marked == 0);
  size_t visited = 0;
  positions_.eachParallel([](Position& p) { p.radius_m += 0; });
  positions_.each([&](Entity entity, Position& p) {
    ++visited;
    ASSERT_EQ(p, *find(entity)->position);
  });
  ASSERT_EQ(visited, positions);
  for (size_t i = 0; i < dead_.size(); i += 97) ASSERT_FALSE(world_.alive(dead_[i]));
  ASSERT_EQ(world_.stateHash(), world_.stateHashFromScratch());
}

}  // namespace scree
