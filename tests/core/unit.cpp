// Hashes, random numbers, results, logging and the conventions of the mathematics.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <set>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/core/math.h"
#include "engine/core/random.h"
#include "engine/core/result.h"

#include <glm/gtc/matrix_transform.hpp>

namespace scree {
namespace {

TEST(Hash, MixIsSplitMix64) {
  // The first outputs of the published generator, seed 0.
  constexpr uint64_t kStep = 0x9e3779b97f4a7c15ull;
  EXPECT_EQ(mix64(0), 0xe220a8397b1dcdafull);
  EXPECT_EQ(mix64(kStep), 0x6e789e6aa1b965f4ull);
  EXPECT_EQ(mix64(2 * kStep), 0x06c45d188009454full);
}

TEST(Hash, NamesAreMixedFnv1a) {
  EXPECT_EQ(hashName(""), mix64(0xcbf29ce484222325ull));
  EXPECT_EQ(hashName("a"), mix64(0xaf63dc4c8601ec8cull));
  EXPECT_EQ(hashName("foobar"), mix64(0x85944171f73967e8ull));
}

// Flips each input bit of many buffers: about half of the output bits flip, each about as often.
TEST(Hash, EveryInputBitReachesEveryOutputBit) {
  const int kTrials = 200;
  for (size_t size : {1, 3, 8, 13, 24}) {
    std::vector<int> flips(64);
    int total = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<uint8_t> bytes(size);
      for (size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<uint8_t>(randomBits(1, size, static_cast<uint64_t>(trial), i));
      const uint64_t before = hashBytes(bytes.data(), size);
      for (size_t bit = 0; bit < size * 8; ++bit) {
        bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ 1u << bit % 8);
        const uint64_t changed = before ^ hashBytes(bytes.data(), size);
        bytes[bit / 8] = static_cast<uint8_t>(bytes[bit / 8] ^ 1u << bit % 8);
        ++total;
        for (int out = 0; out < 64; ++out) flips[static_cast<size_t>(out)] += changed >> out & 1;
      }
    }
    for (int count : flips) EXPECT_NEAR(count * 1.0 / total, 0.5, 0.07) << size << " bytes";
  }
}

TEST(Hash, LengthSeedAndAlignmentOfTheBuffer) {
  const std::string zeros(64, '\0');
  std::set<uint64_t> hashes;
  for (size_t size = 0; size <= 64; ++size) hashes.insert(hashBytes(zeros.data(), size));
  EXPECT_EQ(hashes.size(), 65u) << "zeros of every length differ";
  EXPECT_NE(hashBytes("abc", 3, 1), hashBytes("abc", 3, 2));
  const std::string text = "..the same bytes at two addresses";
  const std::string copy = text.substr(1);
  EXPECT_EQ(hashBytes(text.data() + 1, 20), hashBytes(copy.data(), 20));
  EXPECT_NE(hashCombine(1, 2), hashCombine(2, 1));
  EXPECT_EQ(hashBytes("scree", 5), 0xd8e409ab5c3c6fc6ull) << "a changed definition breaks committed goldens";
}

TEST(Random, IsAPureFunctionOfItsKey) {
  std::set<uint64_t> seen;
  for (uint64_t seed = 0; seed < 10; ++seed)
    for (uint64_t entity = 0; entity < 10; ++entity)
      for (uint64_t tick = 0; tick < 10; ++tick)
        for (uint64_t draw = 0; draw < 10; ++draw) {
          seen.insert(randomBits(seed, entity, tick, draw));
          EXPECT_EQ(randomBits(seed, entity, tick, draw), randomBits(seed, entity, tick, draw));
        }
  EXPECT_EQ(seen.size(), 10000u) << "each part of the key matters";
}

TEST(Random, UnitIsUniformInEachPartOfTheKey) {
  for (int part = 0; part < 4; ++part) {
    const int kBins = 64;
    const int kDraws = 64000;
    std::vector<int> bins(kBins);
    double sum = 0;
    double product = 0;
    float previous = 0.5f;
    for (uint64_t i = 0; i < kDraws; ++i) {
      uint64_t key[4] = {5, 6, 7, 8};
      key[part] = i;
      const float value = randomUnit(key[0], key[1], key[2], key[3]);
      ASSERT_GE(value, 0.0f);
      ASSERT_LT(value, 1.0f);
      ++bins[static_cast<size_t>(value * kBins)];
      sum += value;
      product += (value - 0.5) * (previous - 0.5);
      previous = value;
    }
    double chi_square = 0;
    for (int count : bins) chi_square += (count - 1000.0) * (count - 1000.0) / 1000.0;
    EXPECT_LT(chi_square, 120) << "63 degrees of freedom, p < 2e-5; key part " << part;
    EXPECT_NEAR(sum / kDraws, 0.5, 0.006);
    EXPECT_NEAR(product / kDraws * 12, 0, 0.02) << "neighbouring keys are not correlated";
  }
}

TEST(Random, TheLargestUnitIsBelowOne) {
  EXPECT_LT(static_cast<float>(~uint64_t{0} >> 40) * 0x1p-24f, 1.0f);
}

TEST(ResultTest, HoldsAValueOrAnError) {
  Result<int> good = 5;
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(*good, 5);
  *good = 6;
  EXPECT_EQ(good.value(), 6);
  const Result<std::string> bad = Error{"file.x: too big"};
  EXPECT_FALSE(bad);
  EXPECT_EQ(bad.error(), "file.x: too big");
  Result<std::unique_ptr<int>> movable = std::make_unique<int>(7);
  const std::unique_ptr<int> taken = std::move(movable).value();
  EXPECT_EQ(*taken, 7);
  const Status done = Done{};
  EXPECT_TRUE(done.ok());
}

TEST(ResultTest, TheValueOfAnErrorEndsTheProgram) {
  const Result<int> bad = Error{"no"};
  EXPECT_DEATH(static_cast<void>(bad.value()), "");
}

TEST(Log, WritesOneLineAtOrAboveTheLevel) {
  ::testing::internal::CaptureStderr();
  logInfo("grains {} of {}", 3, 4);
  logDebug("not written");
  setLogLevel(LogLevel::Error);
  logWarning("not written");
  logError("bad {}", "thing");
  setLogLevel(LogLevel::Info);
  const std::string written = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(written.find("info: grains 3 of 4\n"), std::string::npos) << written;
  EXPECT_NE(written.find("error: bad thing\n"), std::string::npos) << written;
  EXPECT_EQ(written.find("not written"), std::string::npos);
}

TEST(Log, FailEndsTheProgramWithItsLine) {
  EXPECT_DEATH(fail("the reason"), "error: the reason");
}

TEST(MathConventions, DepthIsZeroToOneAndAnglesAreRadians) {
  const mat4 clip_from_view = glm::perspective(1.0f, 1.0f, 1.0f, 10.0f);
  const vec4 near_point = clip_from_view * vec4(0, 0, -1, 1);
  const vec4 far_point = clip_from_view * vec4(0, 0, -10, 1);
  EXPECT_NEAR(near_point.z / near_point.w, 0, 1e-6);
  EXPECT_NEAR(far_point.z / far_point.w, 1, 1e-6);
  const quat quarter = glm::angleAxis(1.57079632679f, vec3(0, 1, 0));
  const vec3 turned = quarter * vec3(0, 0, -1);
  EXPECT_NEAR(turned.x, -1, 1e-6) << "right-handed: a quarter turn about +Y takes -Z to -X";
}

}  // namespace
}  // namespace scree
