// A solver that was saved goes on to the bit as the one that was not; damaged bytes are refused or
// harmless.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "engine/core/parallel.h"
#include "tests/grains/resting.h"

namespace scree::grains::test {
namespace {

struct Bed : RestingField {
  // Of all that a tick puts out.
  uint64_t state() const {
    uint64_t sum = hash();
    for (size_t k = 0; k < rest.size(); ++k)
      sum += hashCombine(hashBytes(&rest[k].anchor, sizeof(vec3) + sizeof(float), entity[k].index),
                         rest[k].asleep ? 1 : 0);
    for (const Collider& c : colliders)
      sum = hashCombine(sum, hashBytes(&c.load, sizeof c.load, c.load_contacts));
    return sum;
  }
};

struct Scene {
  const char* name;
  std::function<void(Bed&)> fill;
  std::function<void(Bed&, int tick)> act;  // before the tick
  int ticks;
};

void moveBox(Bed& bed, vec3 way) {
  Collider& box = bed.colliders.back();
  box.position0 = box.position1;
  box.position1 += way;
}
void sense(Bed& bed) {
  for (Collider& c : bed.colliders) c.sensed = true;
}
vec3 shake(int tick) {
  return {0.01f * std::sin(0.4f * static_cast<float>(tick)), 0, 0.004f * std::cos(0.3f * static_cast<float>(tick))};
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all{
      {"flow",
       [](Bed& bed) {
         pour(bed, 8, 8, 0.05f, 6, 0.3f, {1000, 0.5f, 0.02f, 0});
         bed.addBox({0, 0.2f, 0}, {0.1f, 0.1f, 0.4f}, 0.5f);
         sense(bed);
       },
       [](Bed& bed, int tick) { moveBox(bed, shake(tick)); }, 400},
      {"rake",
       [](Bed& bed) {
         pour(bed, 10, 4, 0.05f, 6, 0.2f, {1000, 0.5f, 0.02f, 0});
         bed.addBox({-2, 0.2f, 0}, {0.02f, 0.15f, 0.2f}, 0.5f);
         sense(bed);
       },
       [](Bed& bed, int tick) { moveBox(bed, {tick > 250 ? 0.006f : 0.0f, 0, 0}); }, 1000},
      {"sleep",
       [](Bed& bed) {
         pour(bed, 6, 4, 0.05f, 9, 0.2f, {1000, 0.5f, 0.05f, 0});
         sense(bed);
       },
       [](Bed& bed, int tick) {
         if (tick == 900) bed.velocity[5].linear.y = 2;
       },
       1000},
      {"sizes, bounces and strays",
       [](Bed& bed) {
         for (uint64_t k = 0; k < 300; ++k)
           bed.add(unitCube(4, k) * vec3(1, 2, 1) - vec3(0.5f, -0.3f, 0.5f),
                   0.01f * std::exp2(3 * unit(4, k, 3)), {1000, 0.4f, 0.01f, 0.3f});
         bed.addBin(0.6f, 0.4f);
         bed.colliders[2].restitution = 0.8f;
         sense(bed);
       },
       [](Bed& bed, int tick) {
         if (tick % 40 == 20)
           bed.add({-0.3f, 2, 0.2f}, 0.03f, {1000, 0.4f, 0, 0.5f},
                   {static_cast<float>(tick % 7) - 3, 5, 1});
       },
       500},
      {"falls together",
       [](Bed& bed) {
         pour(bed, 6, 5, 0.05f, 6, 0.3f, {1000, 0.5f, 0.02f, 0});
         for (Grain& grain : bed.grain) grain.position.y += 1.5f;
         for (GrainVelocity& v : bed.velocity) v.linear.y = -2;
         bed.addBox({0, 0.3f, 0}, {0.15f, 0.01f, 0.15f}, 0.5f);
         sense(bed);
       },
       [](Bed& bed, int tick) { moveBox(bed, shake(tick) + vec3(0, 0.002f, 0)); }, 150},
      {"comings and goings",
       [](Bed& bed) {
         bed.parameters.bounds_min.y = -0.3f;
         pour(bed, 7, 3, 0.05f, 12, 0.2f, {1000, 0.6f, 0.1f, 0});
         bed.addBox({0.2f, 0.02f, 0}, {0.1f, 0.1f, 0.1f}, 0.5f);
         sense(bed);
       },
       [](Bed& bed, int tick) {
         // The caller takes out what was lost, and others; the floor goes for a while; the box jumps.
         for (size_t k = bed.grain.size(); k-- > 0;)
           if (bed.grain[k].position.y < -0.3f) bed.remove(k);
         if (tick % 150 == 149) bed.remove(static_cast<size_t>(tick) % bed.grain.size());
         if (tick % 100 == 50)
           bed.add({0.01f * static_cast<float>(tick % 30), 0.9f, 0}, 0.04f, {1200, 0.5f, 0, 0});
         if (tick == 640) bed.colliders.erase(bed.colliders.begin());
         if (tick == 330) moveBox(bed, {-0.1f, 0, 0});
         if (tick == 331) moveBox(bed, {0, 0, 0});
         if (tick == 500) bed.parameters.gravity.x = 1;
         if (tick == 560) bed.parameters.substeps = 6;
         if (tick == 600) bed.material[3].friction = 0.1f;
         if (tick == 610) bed.grain[4].radius *= 0.9f;
       },
       700},
  };
  return all;
}

// What goes on is the same from wherever it was saved; the state that each scene is meant for occurs.
TEST(Save, GoesOnToTheBit) {
  for (const Scene& scene : scenes()) {
    for (const int threads : {1, 2, 4}) {
      setThreadCount(threads);
      std::mt19937_64 random(static_cast<uint64_t>(threads));
      Bed bed;
      bed.parameters.damping = 0.05f;
      scene.fill(bed);
      struct Run {
        Bed bed;
        int from;
      };
      std::vector<Run> runs;
      int next = 1;
      size_t flowing = 0, half = 0, sleeping = 0, saved = 0, with_sleepers = 0;
      for (int tick = 0; tick < scene.ticks; ++tick) {
        if (tick == next) {
          // Half of them between a change of the rows and the tick that sees it.
          Run run{bed, tick};
          const std::string bytes = bed.solver.saved();
          auto solver = GrainSolver::restored(bytes, bed.next);
          ASSERT_TRUE(solver.ok()) << scene.name << " at " << tick << ": " << solver.error();
          EXPECT_TRUE(solver->saved() == bytes) << scene.name << " at " << tick;
          run.bed.solver = std::move(solver).value();
          runs.push_back(std::move(run));
          ++saved;
          with_sleepers += bed.asleep() > 0;
          next += 1 + static_cast<int>(random() % (scene.ticks < 200 ? 10 : 60));
        }
        const bool as_left = bed.entity.size() == bed.rest.size() && tick % 3 == 0 && scene.ticks == 1000;
        scene.act(bed, tick);
        bed.step(1, as_left && tick != 900 ? RowsAre::AsLeft : RowsAre::Unknown);
        const uint64_t want = bed.state();
        for (Run& run : runs) {
          if (run.from + 200 <= tick) continue;
          scene.act(run.bed, tick);
          run.bed.step();
          ASSERT_EQ(run.bed.state(), want) << scene.name << ", " << threads << " threads, saved at " << run.from
                                           << ", differs at " << tick;
        }
        std::erase_if(runs, [&](const Run& run) { return run.from + 200 <= tick; });
        const size_t asleep = bed.asleep();
        ++(asleep == 0 ? flowing : asleep < bed.grain.size() ? half : sleeping);
      }
      if (threads == 1)
        std::printf("%s: %zu saves, %zu with sleepers; ticks flowing %zu, half asleep %zu, all asleep %zu\n",
                    scene.name, saved, with_sleepers, flowing, half, sleeping);
      EXPECT_GT(saved, 10u);
    }
  }
  setThreadCount(0);
}

// A small heap, some of it asleep, with a new grain that comes down on it.
Bed smallBed(int ticks) {
  Bed bed;
  pour(bed, 4, 3, 0.05f, 3, 0.2f, {1000, 0.5f, 0.05f, 0});
  for (int tick = 0; tick < ticks; ++tick) {
    if (tick % 130 == 120) bed.add({0, 0.6f, 0}, 0.05f, {1000, 0.5f, 0.05f, 0.2f});
    bed.step();
  }
  return bed;
}

TEST(Save, NothingBeforeTheFirstTick) {
  EXPECT_EQ(GrainSolver().saved(), "");
  EXPECT_TRUE(GrainSolver::restored("", 0).ok());
}

TEST(Save, SaysWhatIsWrong) {
  const Bed bed = smallBed(300);
  const std::string bytes = bed.solver.saved();
  ASSERT_TRUE(GrainSolver::restored(bytes, bed.next).ok());
  const auto why = [&](const std::string& damaged, uint32_t handles) {
    const auto result = GrainSolver::restored(damaged, handles);
    return result.ok() ? std::string("nothing") : result.error();
  };
  EXPECT_EQ(why(std::string("\5\0\0\0", 4) + bytes.substr(4), bed.next), "version 5; this program reads 4");
  EXPECT_EQ(why(bytes + "x", bed.next), "unknown content at byte " + std::to_string(bytes.size()));
  EXPECT_NE(why(bytes, 3).find("entity"), std::string::npos);
  std::string nan = bytes;
  const float value = std::nanf("");
  std::memcpy(nan.data() + 20, &value, 4);  // the drift
  EXPECT_NE(why(nan, bed.next).find("drift"), std::string::npos);
  for (size_t size = 1; size < bytes.size(); ++size)
    ASSERT_FALSE(GrainSolver::restored(bytes.substr(0, size), bed.next).ok()) << size << " bytes";
}

TEST(Save, SurvivesRandomDamage) {
  for (const int ticks : {20, 150, 300, 400}) {
    const Bed bed = smallBed(ticks);
    const std::string bytes = bed.solver.saved();
    std::printf("after %d ticks: %zu of %zu asleep, %zu bytes\n", ticks, bed.asleep(), bed.grain.size(),
                bytes.size());
    std::mt19937_64 random(static_cast<uint64_t>(ticks));
    int refusals = 0;
    constexpr int kTrials = 3000;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::string damaged = bytes;
      for (uint64_t k = random() % 3 + 1; k > 0; --k) {
        const size_t at = random() % damaged.size();
        const char interesting[] = {0, 1, 2, -1, 127, -128, 8, static_cast<char>(random())};
        damaged[at] = interesting[random() % std::size(interesting)];
        // Whole numbers, mostly small: counts and slots that are nearly right.
        if (random() % 2 == 0 && at + 4 <= damaged.size()) {
          const uint32_t number = random() % 4 == 0 ? static_cast<uint32_t>(random()) : static_cast<uint32_t>(random() % 70);
          std::memcpy(damaged.data() + at / 4 * 4, &number, std::min<size_t>(4, damaged.size() - at / 4 * 4));
        }
      }
      if (random() % 16 == 0) damaged.resize(random() % damaged.size() + 1);
      auto solver = GrainSolver::restored(damaged, bed.next);
      if (!solver.ok()) {
        ASSERT_EQ(solver.error().find('\n'), std::string::npos);
        ++refusals;
        continue;
      }
      Bed victim = bed;
      victim.solver = std::move(solver).value();
      for (int tick = 0; tick < 6; ++tick) {
        if (tick == 3) victim.velocity[7].linear.y = 1;
        victim.step();
        for (const Entity lost : victim.solver.lost())
          victim.remove(static_cast<size_t>(
              std::find(victim.entity.begin(), victim.entity.end(), lost) - victim.entity.begin()));
        ASSERT_TRUE(victim.finite()) << "trial " << trial << " after " << ticks;
      }
    }
    EXPECT_GT(refusals, kTrials / 4);
    EXPECT_LT(refusals, kTrials);
  }
}

}  // namespace
}  // namespace scree::grains::test
