// The state hash covers every value and nothing else.
#include <gtest/gtest.h>

#include <cstring>

#include "engine/core/parallel.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

void fillBytes(void* memory, int byte, size_t size) {
  std::memset(memory, byte, size);
}

// A value whose padding is `byte`.
void assignFields(Everything& to, const Everything& from) {
  for (const FieldInfo& field : findComponent("Everything")->fields)
    std::memcpy(reinterpret_cast<std::byte*>(&to) + field.offset,
                reinterpret_cast<const std::byte*>(&from) + field.offset, field.size());
}

TEST(StateHash, DoesNotDependOnThreads) {
  World world;
  const TableRows rows = world.spawnMany<Position, Velocity>(200000);
  for (size_t i = 0; i < rows.size(); ++i)
    rows.column<Position>()[i].position = vec3(i, i % 7, -0.5f);
  setThreadCount(1);
  const uint64_t expected = world.stateHashFromScratch();
  for (int threads : {2, 3, 8}) {
    setThreadCount(threads);
    EXPECT_EQ(world.stateHashFromScratch(), expected);
    static_cast<void>(world.find<Position>(rows.entities()[0]));  // the cached column is stale
    EXPECT_EQ(world.stateHash(), expected);
  }
  setThreadCount(0);
}

TEST(StateHash, DoesNotDependOnHistory) {
  World direct;
  const Entity a = direct.spawn(Position{{1, 2, 3}, 4}, Velocity{}, Asleep{});
  const Entity b = direct.spawn(Position{{5, 6, 7}, 8});
  World detour;
  const Entity a2 = detour.spawn();
  const Entity b2 = detour.spawn(Wide{}, Marked{});
  ASSERT_EQ(a, a2);
  ASSERT_EQ(b, b2);
  detour.spawn(Position{});
  detour.add<Asleep>(a2);
  detour.add(b2, Position{{5, 6, 7}, 8});
  detour.add(a2, Velocity{{9, 9, 9}, 9});
  EXPECT_NE(detour.stateHash(), direct.stateHash());
  detour.remove<Marked>(b2);
  detour.add(a2, Position{{1, 2, 3}, 4});
  *detour.find<Velocity>(a2) = Velocity{};
  detour.remove<Wide>(b2);
  detour.destroy(Entity{2, 1});
  EXPECT_GT(detour.tables().size(), direct.tables().size());
  EXPECT_EQ(detour.stateHash(), direct.stateHash());
}

TEST(StateHash, SeesEveryByteOfEveryFieldAndNoPadding) {
  World world;
  const Entity entity = world.spawn(Everything{});
  const uint64_t original = world.stateHash();
  std::vector<bool> is_value(sizeof(Everything));
  for (const FieldInfo& field : findComponent("Everything")->fields)
    for (size_t i = 0; i < field.size(); ++i) is_value[field.offset + i] = true;
  size_t padding = 0;
  for (size_t i = 0; i < sizeof(Everything); ++i) {
    // Bit 0 keeps a bool valid, and the text's length.
    reinterpret_cast<unsigned char*>(world.find<Everything>(entity))[i] ^= 1;
    const uint64_t changed = world.stateHash();
    EXPECT_EQ(changed, world.stateHashFromScratch());
    const bool behind_text = i == offsetof(Everything, text) + 12;
    if (!is_value[i]) {
      EXPECT_EQ(changed, original) << "byte " << i << " is padding";
    } else if (!behind_text) {
      EXPECT_NE(changed, original) << "byte " << i << " of a field";
    }
    padding += !is_value[i];
    reinterpret_cast<unsigned char*>(world.find<Everything>(entity))[i] ^= 1;
  }
  EXPECT_GT(padding, 10u);
  EXPECT_EQ(world.stateHash(), original);
}

TEST(StateHash, IgnoresGarbageInPaddingAndBehindTexts) {
  uint64_t hashes[2];
  for (int i = 0; i < 2; ++i) {
    World world;
    const TableRows rows = world.spawnMany<Everything>(10);
    for (Everything& value : rows.column<Everything>()) {
      fillBytes(&value, i ? 0xaa : 0x55, sizeof value);
      assignFields(value, Everything{});
      fillBytes(value.text, i ? 'x' : 'y', sizeof value.text);
      std::strcpy(value.text, "short");
    }
    fillBytes(&world.singleton<Everything>(), i ? 0xaa : 0x55, sizeof(Everything));
    assignFields(world.singleton<Everything>(), Everything{.i32 = 5});
    hashes[i] = world.stateHash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(StateHash, SeesWhoHasWhat) {
  World world;
  const Entity a = world.spawn(Position{{1, 0, 0}, 1});
  const Entity b = world.spawn(Position{{2, 0, 0}, 1});
  const uint64_t original = world.stateHash();
  std::swap(*world.find<Position>(a), *world.find<Position>(b));
  EXPECT_NE(world.stateHash(), original) << "values swapped between entities";
  std::swap(*world.find<Position>(a), *world.find<Position>(b));
  EXPECT_EQ(world.stateHash(), original);
  const Entity c = world.spawn();
  EXPECT_NE(world.stateHash(), original) << "an entity without components";
  const uint64_t with_c = world.stateHash();
  world.add<Asleep>(c);
  EXPECT_NE(world.stateHash(), with_c) << "a tag";
  world.destroy(c);
  EXPECT_EQ(world.stateHash(), original);
  const Entity d = world.spawn();
  EXPECT_EQ(d.index, c.index);
  EXPECT_NE(world.stateHash(), with_c) << "another generation is another entity";
}

TEST(StateHash, LeavesOutTransientComponents) {
  World world;
  const Entity entity = world.spawn(Position{});
  const uint64_t original = world.stateHash();
  world.add(entity, Cached{3});
  EXPECT_EQ(world.stateHash(), original);
  world.find<Cached>(entity)->slot = 4;
  world.singleton<Cached>().slot = 5;
  EXPECT_EQ(world.stateHash(), original);
}

TEST(StateHash, CoversDescribedSingletonsThatWereChanged) {
  World world;
  const uint64_t original = world.stateHash();
  world.singleton<Score>();
  world.singleton<std::string>() = "not described";
  EXPECT_EQ(world.stateHash(), original) << "looking at a singleton is no change of state";
  world.singleton<Score>().points = 5;
  const uint64_t five = world.stateHash();
  EXPECT_NE(five, original);
  world.setSingleton(Score{6});
  EXPECT_NE(world.stateHash(), five);
  world.setSingleton(Score{5});
  EXPECT_EQ(world.stateHash(), five);
  EXPECT_EQ(world.stateHashFromScratch(), five);
}

// State hashes are committed as goldens: a change of the hash's definition must be deliberate.
TEST(StateHash, IsTheSameOnEveryMachine) {
  World world;
  EXPECT_EQ(world.stateHash(), 0xe220a8397b1dcdafull) << "of nothing";
  world.spawn(Position{{1, 2, 3}, 4}, Asleep{});
  EXPECT_EQ(world.stateHash(), 0x79efdf102d4a677dull) << "computed from the definition by other code";
  world.spawn(Everything{});
  world.singleton<Score>().points = -7;
  EXPECT_EQ(world.stateHash(), 0x23bbfd7f7377e393ull);
}

}  // namespace
}  // namespace scree
