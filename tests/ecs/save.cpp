// Saved worlds come back exactly; damaged files are refused and change nothing.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

namespace fs = std::filesystem;

class Save : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder);
    fs::remove(path);
  }
  void write(const std::string& content) {
    std::ofstream(path, std::ios::binary)
        .write(content.data(), static_cast<std::streamsize>(content.size()));
  }
  std::string read() { return readText(path).value(); }
  // Corrects the size and the checksum, so that the checks behind them are reached.
  static std::string sealed(std::string content) {
    content.resize(content.size() - 8);
    const uint64_t size = content.size() + 8;
    std::memcpy(content.data() + 12, &size, 8);
    const uint64_t hash = hashBytes(content.data(), content.size());
    content.append(reinterpret_cast<const char*>(&hash), 8);
    return content;
  }
  // The error of loading `content`, which must be one line that names the file, and must leave the
  // world as it was.
  std::string refused(World& world, const std::string& content) {
    const uint64_t hash = world.stateHashFromScratch();
    const size_t count = world.entityCount();
    const size_t tables = world.tables().size();
    const Status status = world.loadBytes(content, "some.world");
    if (status.ok()) return "";
    EXPECT_EQ(status.error().find('\n'), std::string::npos);
    EXPECT_EQ(status.error().rfind("some.world: ", 0), 0u) << status.error();
    EXPECT_EQ(world.stateHashFromScratch(), hash);
    EXPECT_EQ(world.entityCount(), count);
    EXPECT_EQ(world.tables().size(), tables);
    return status.error().substr(12);
  }

  fs::path folder = fs::path(SCREE_BINARY_DIR) / "test_ecs_save";
  fs::path path =
      folder /
      (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + ".world");
};

// A world with a past: several tables, rows out of order, free and reused handles.
void fillWorld(World& world, uint64_t seed, size_t operations) {
  std::mt19937_64 random(seed);
  std::vector<Entity> entities;
  for (size_t i = 0; i < operations; ++i) {
    const auto x = static_cast<float>(random() % 1000);
    switch (random() % 8) {
      case 0:
        entities.push_back(world.spawn(Position{{x, 1, 2}, 3}, Velocity{{x, 0, 0}, 1}));
        break;
      case 1:
        entities.push_back(world.spawn(Position{{x, 1, 2}, 3}, Asleep{}));
        break;
      case 2:
        entities.push_back(world.spawn(Wide{x}));
        break;
      case 3:
        entities.push_back(world.spawn());
        break;
      case 4: {
        Everything value;
        value.f32 = x;
        value.flag = random() % 2;
        value.d3 = {x * 1e-9, -0.0, std::numeric_limits<double>::quiet_NaN()};
        if (!entities.empty()) value.other = entities[random() % entities.size()];
        std::strncpy(value.text, "name", sizeof value.text);
        entities.push_back(world.spawn(value));
        break;
      }
      case 5:
        if (!entities.empty()) world.destroy(entities[random() % entities.size()]);
        break;
      case 6:
        if (!entities.empty()) world.add(entities[random() % entities.size()], Link{{}, 5});
        break;
      default:
        if (!entities.empty()) world.remove<Position>(entities[random() % entities.size()]);
        break;
    }
  }
  world.singleton<Score>().points = 42;
}

void expectSame(World& a, World& b) {
  EXPECT_EQ(a.stateHashFromScratch(), b.stateHashFromScratch());
  EXPECT_EQ(a.stateHash(), b.stateHash());
  ASSERT_EQ(a.tables().size(), b.tables().size());
  for (size_t i = 0; i < a.tables().size(); ++i) {
    const Table& x = *a.tables()[i];
    const Table& y = *b.tables()[i];
    ASSERT_EQ(x.mask(), y.mask());
    ASSERT_EQ(std::vector(x.entities().begin(), x.entities().end()),
              std::vector(y.entities().begin(), y.entities().end()))
        << "rows keep their order";
    for (ComponentId id : x.componentIds())
      for (Entity entity : x.entities()) {
        const ComponentInfo& info = componentInfo(id);
        for (const FieldInfo& field : info.fields)
          ASSERT_EQ(std::memcmp(static_cast<const std::byte*>(a.peek(entity, id)) + field.offset,
                                static_cast<const std::byte*>(b.peek(entity, id)) + field.offset,
                                field.size()),
                    0)
              << info.name << "." << field.name;
      }
  }
}

TEST_F(Save, RoundTripIsExactAndTheFutureIsTheSame) {
  for (uint64_t seed : {1, 2, 3}) {
    World world;
    fillWorld(world, seed, 3000);
    ASSERT_TRUE(world.save(path).ok());
    World loaded;
    const auto query = loaded.query<const Position>();
    const Entity before = loaded.spawn(Position{}, Marked{});
    loaded.singleton<Score>().points = 1;
    const Version version = query.version();
    ASSERT_TRUE(loaded.load(path).ok());
    EXPECT_GT(query.version(), version);
    EXPECT_EQ(query.count(), world.query<const Position>().count());
    EXPECT_FALSE(query.empty());
    EXPECT_EQ(loaded.singleton<Score>().points, 42);
    EXPECT_EQ(loaded.has<Marked>(before), false);
    expectSame(world, loaded);
    // The same operations go on in the same way: same handles, same tables, same rows.
    fillWorld(world, seed + 100, 2000);
    fillWorld(loaded, seed + 100, 2000);
    expectSame(world, loaded);
    // And what is saved again is the same file.
    ASSERT_TRUE(world.save(path).ok());
    const std::string first = read();
    ASSERT_TRUE(loaded.save(path).ok());
    EXPECT_EQ(read(), first);
  }
}

TEST_F(Save, OfAnEmptyWorldEmptiesAWorld) {
  ASSERT_TRUE(World().save(path).ok());
  World world;
  fillWorld(world, 1, 100);
  const auto query = world.query<const Position>();
  const Version version = query.version();
  ASSERT_FALSE(query.empty());
  ASSERT_TRUE(world.load(path).ok());
  EXPECT_TRUE(query.empty());
  EXPECT_GT(query.version(), version) << "the rows are gone, which is a change";
  EXPECT_EQ(world.entityCount(), 0u);
  EXPECT_EQ(world.singleton<Score>().points, 0) << "not in the file: back to its default";
  EXPECT_EQ(world.stateHash(), World().stateHash());
}

TEST_F(Save, LeavesOutTransientComponents) {
  World world;
  const Entity a = world.spawn(Position{{1, 1, 1}, 1});
  const Entity b = world.spawn(Position{{2, 2, 2}, 2}, Cached{9});
  const Entity c = world.spawn(Cached{9});
  ASSERT_TRUE(world.save(path).ok());
  EXPECT_EQ(read().find("Cached"), std::string::npos);
  World loaded;
  ASSERT_TRUE(loaded.load(path).ok());
  EXPECT_EQ(loaded.stateHash(), world.stateHash());
  EXPECT_FALSE(loaded.has<Cached>(b));
  EXPECT_EQ(loaded.peek<Position>(b)->radius_m, 2);
  EXPECT_EQ(loaded.peek<Position>(a)->radius_m, 1);
  EXPECT_TRUE(loaded.alive(c));
}

TEST_F(Save, WritesNoPadding) {
  std::string contents[2];
  for (int i = 0; i < 2; ++i) {
    World world;
    const Entity entity = world.spawn(Everything{});
    auto* bytes = reinterpret_cast<unsigned char*>(world.find<Everything>(entity));
    std::vector<bool> is_value(sizeof(Everything));
    for (const FieldInfo& field : findComponent("Everything")->fields)
      for (size_t k = 0; k < field.size(); ++k) is_value[field.offset + k] = true;
    for (size_t k = 0; k < sizeof(Everything); ++k)
      if (!is_value[k]) bytes[k] = i ? 0xaa : 0x55;
    std::strcpy(world.find<Everything>(entity)->text, i ? "a\0bcd" : "a\0efgh");
    world.find<Everything>(entity)->text[5] = i ? 'x' : 'y';
    ASSERT_TRUE(world.save(path).ok());
    contents[i] = read();
  }
  EXPECT_EQ(contents[0], contents[1]);
}

TEST_F(Save, GenerationsEndThroughALoadedWorldToo) {
  World world;
  const Entity old = world.spawn();
  world.destroy(old);
  ASSERT_TRUE(world.save(path).ok());
  // header 20, no components, then handles: count, generation of handle 0
  std::string content = read();
  const uint32_t last = kLastGeneration;
  std::memcpy(content.data() + 20 + 4 + 4, &last, 4);
  write(sealed(content));
  ASSERT_TRUE(world.load(path).ok());
  const Entity ultimate = world.spawn();
  EXPECT_EQ(ultimate, (Entity{0, kLastGeneration}));
  EXPECT_TRUE(world.alive(ultimate));
  world.destroy(ultimate);
  EXPECT_FALSE(world.alive(ultimate));
  EXPECT_EQ(world.spawn(), (Entity{1, 1})) << "index 0 is retired";
  EXPECT_FALSE(world.alive(Entity{0, 1}));
  EXPECT_FALSE(world.alive(Entity{0, kPendingGeneration}));
  ASSERT_TRUE(world.save(path).ok());
  World again;
  ASSERT_TRUE(again.load(path).ok()) << "a retired handle is saved as such";
  EXPECT_EQ(again.spawn(), (Entity{2, 1}));
}

TEST_F(Save, RefusesWhatIsNoFileOrCannotBeWritten) {
  World world;
  EXPECT_NE(world.load(folder / "missing").error().find("missing: no such file"),
            std::string::npos);
  EXPECT_NE(world.load(folder).error().find("not a regular file"), std::string::npos);
  const Status status = world.save(folder / "no_folder" / "x.world");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("x.world"), std::string::npos);
}

TEST_F(Save, RefusesEveryTruncationAndEveryFlippedByte) {
  World world;
  fillWorld(world, 7, 15);
  ASSERT_TRUE(world.save(path).ok());
  const std::string content = read();
  for (size_t size = 0; size < content.size(); ++size)
    ASSERT_NE(refused(world, content.substr(0, size)), "") << size << " bytes";
  for (size_t i = 0; i < content.size(); ++i) {
    std::string damaged = content;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x40);
    ASSERT_NE(refused(world, damaged), "") << "byte " << i;
  }
  EXPECT_NE(refused(world, content + "x"), "");
  EXPECT_NE(refused(world, "SCREEWLD but in fact a text about it").find("version"),
            std::string::npos);
  EXPECT_EQ(refused(world, std::string(100, 'x')), "not a saved world");
  EXPECT_EQ(refused(world, ""), "0 bytes: too short for a saved world");
  EXPECT_EQ(refused(world, content), "") << "the file itself is fine";
  write(content.substr(0, 100));
  EXPECT_EQ(world.load(path).error(), fmt::format("{}: 100 bytes of {}: truncated or damaged",
                                                  path.string(), content.size()));
}

TEST_F(Save, SaysWhatIsWrong) {
  World world;
  const Entity entity = world.spawn(Everything{});
  ASSERT_TRUE(world.save(path).ok());
  const std::string content = read();
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string changed = content;
    changed.replace(changed.find(from), from.size(), to);
    return refused(world, sealed(changed));
  };
  EXPECT_EQ(replaced("Everything", "Anything_."),
            "component 'Anything_.' is unknown to this program");
  EXPECT_EQ(replaced("Everything", "Any\nthing."), "component type 0 has no plain name");
  EXPECT_EQ(
      replaced("i32", "i33"),
      "component 'Everything' has a field 'i33' of type 1[1] where this program's has 'i32' of "
      "type 1[1]");
  // The first packed value is that of `flag`.
  std::string changed = content;
  const size_t values = content.size() - 8 - 4 - [] {
    size_t size = 0;
    for (const FieldInfo& field : findComponent("Everything")->fields) size += field.size();
    return size;
  }();
  changed[values] = 2;
  EXPECT_EQ(refused(world, sealed(changed)),
            "component 'Everything', row 0, field 'flag': not a bool");
  changed = content;
  changed[values - 4] = 1;  // the row's handle
  EXPECT_EQ(refused(world, sealed(changed)),
            "table 0, row 0: handle 1 is out of range, free, or there twice");
  changed = content;
  changed[values - 8] = 2;  // the table's rows
  EXPECT_NE(refused(world, sealed(changed)), "");
  EXPECT_TRUE(world.alive(entity));
}

// A part that holds a text; it refuses "bad".
SavedPart partOf(std::string& text) {
  return {.save = [&] { return text; },
          .load = [&](std::string_view bytes, uint32_t handles) -> Result<std::function<void()>> {
            if (bytes == "bad") return Error{fmt::format("bad, of {} handles", handles)};
            return std::function<void()>([&text, now = std::string(bytes)] { text = now; });
          }};
}

TEST_F(Save, CarriesPartsAndRefusesWhatTheirOwnersRefuse) {
  World world;
  world.spawn(Marked{});
  const std::string without = world.saveBytes();
  std::string first = "", second = "of two\nlines";
  ASSERT_TRUE(world.setPart("first", partOf(first)).ok());
  ASSERT_TRUE(world.setPart("another", partOf(second)).ok());
  const std::string content = world.saveBytes();
  EXPECT_EQ(content.find("first"), std::string::npos) << "it has nothing to save";
  second = "changed";
  first = "changed";
  ASSERT_TRUE(world.loadBytes(content, "x").ok());
  EXPECT_EQ(first, "") << "not in the file";
  EXPECT_EQ(second, "of two\nlines");
  second = "";
  EXPECT_EQ(world.saveBytes(), without) << "no part, no byte";

  // Refused: the world and the other parts stay.
  second = "kept";
  second = "bad";
  const std::string refusing = world.saveBytes();
  second = "kept";
  EXPECT_EQ(refused(world, refusing), "part 'another': bad, of 1 handles");
  EXPECT_EQ(second, "kept");

  // Nobody's part is kept, until its owner comes or another file is loaded.
  second = "for later";
  const std::string later = world.saveBytes();
  World other;
  ASSERT_TRUE(other.loadBytes(later, "x").ok());
  EXPECT_EQ(other.saveBytes(), later);
  std::string came;
  ASSERT_TRUE(other.setPart("another", partOf(came)).ok());
  EXPECT_EQ(came, "for later");
  EXPECT_EQ(other.saveBytes(), later);
  World third;
  ASSERT_TRUE(third.loadBytes(later, "x").ok());
  ASSERT_TRUE(third.loadBytes(without, "x").ok());
  EXPECT_EQ(third.saveBytes(), without);
  ASSERT_TRUE(third.loadBytes(refusing, "x").ok());
  EXPECT_EQ(third.setPart("another", partOf(came)).error(), "part 'another': bad, of 1 handles");

  for (size_t size = without.size() - 8; size < content.size(); ++size) {
    const std::string cut = content.substr(0, size);
    ASSERT_NE(refused(world, cut), "") << size;
    if (size > without.size()) {
      ASSERT_NE(refused(world, sealed(cut)), "") << size;
    }
  }
  std::string nameless = content;
  nameless[content.find("another")] = ' ';
  EXPECT_EQ(refused(world, sealed(nameless)), "part 0 has no plain name");
  std::string none = without;
  none.insert(none.size() - 8, std::string("\0\0\0\0", 4));
  EXPECT_NE(refused(world, sealed(none)).find("unknown content"), std::string::npos);
}

TEST_F(Save, SurvivesRandomDamageBehindTheChecksum) {
  World world;
  fillWorld(world, 9, 200);
  ASSERT_TRUE(world.save(path).ok());
  const std::string content = read();
  const uint64_t seed = 20240517;
  printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  int refusals = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = content;
    for (uint64_t k = random() % 4 + 1; k > 0; --k) {
      // Mostly where the structure is.
      const size_t range = random() % 4 ? std::min<size_t>(content.size(), 2500) : content.size();
      char& byte = damaged[20 + random() % (range - 28)];
      const char interesting[] = {0, 1, 2, -1, 127, -128, static_cast<char>(random())};
      byte = interesting[random() % std::size(interesting)];
    }
    if (random() % 8 == 0) damaged.resize(28 + random() % (damaged.size() - 28));
    World victim;
    victim.spawn(Position{});
    if (!refused(victim, sealed(damaged)).empty()) {
      ++refusals;
      continue;
    }
    // What was accepted works.
    fillWorld(victim, 1, 50);
    EXPECT_EQ(victim.stateHash(), victim.stateHashFromScratch());
  }
  EXPECT_GT(refusals, 1000);
  EXPECT_LT(refusals, 3000) << "damaged values alone are not seen without the checksum";
}

}  // namespace
}  // namespace scree
