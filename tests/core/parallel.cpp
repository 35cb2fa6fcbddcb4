// Parallel loops: every item once, chunks that do not depend on the threads.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "engine/core/parallel.h"

namespace scree {
namespace {

class Parallel : public ::testing::Test {
 protected:
  void TearDown() override { setThreadCount(0); }
};

TEST_F(Parallel, ChunksAreTheSameForEveryThreadCount) {
  for (size_t count : {0, 1, 9, 10, 11, 1000, 1001})
    for (size_t chunk_size : {1, 10, 999, 5000}) {
      std::set<std::tuple<size_t, size_t, size_t>> expected;
      for (size_t begin = 0, chunk = 0; begin < count; begin += chunk_size, ++chunk)
        expected.emplace(chunk, begin, std::min(begin + chunk_size, count));
      for (int threads : {1, 2, 4}) {
        setThreadCount(threads);
        std::mutex mutex;
        std::multiset<std::tuple<size_t, size_t, size_t>> calls;
        parallelChunks(count, chunk_size, [&](size_t chunk, size_t begin, size_t end) {
          const std::lock_guard lock(mutex);
          calls.emplace(chunk, begin, end);
        });
        ASSERT_EQ(calls.size(), expected.size()) << count << " by " << chunk_size;
        ASSERT_TRUE(std::equal(calls.begin(), calls.end(), expected.begin()));
      }
    }
}

TEST_F(Parallel, NoTwoThreadsOfALoopHaveTheSameIndex) {
  for (int threads : {1, 2, 4}) {
    setThreadCount(threads);
    std::vector<std::atomic<int>> inside(static_cast<size_t>(threads));
    std::atomic<int> met = 0;
    parallelChunks(400, 1, [&](size_t, size_t, size_t) {
      const size_t index = threadIndex();
      ASSERT_LT(index, inside.size());
      met += inside[index]++ != 0;
      std::this_thread::sleep_for(std::chrono::microseconds(20));
      --inside[index];
    });
    EXPECT_EQ(met, 0) << threads << " threads";
  }
}

TEST_F(Parallel, OneThreadRunsInOrderOnTheCaller) {
  setThreadCount(1);
  std::vector<size_t> order;  // unprotected: only this thread may touch it
  parallelChunks(100, 3, [&](size_t chunk, size_t, size_t) { order.push_back(chunk); });
  ASSERT_EQ(order.size(), 34u);
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

TEST_F(Parallel, WhatIsNotWorthThreadsRunsInOrderOnTheCaller) {
  setThreadCount(4);
  std::vector<size_t> order;  // unprotected: only this thread may touch it
  const auto caller = std::this_thread::get_id();
  parallelChunks(
      100, 3,
      [&](size_t chunk, size_t, size_t) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        order.push_back(chunk);
      },
      Worth::OneThread);
  ASSERT_EQ(order.size(), 34u);
  for (size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

TEST_F(Parallel, NestsAndCountsRight) {
  for (int threads : {1, 2, 4}) {
    setThreadCount(threads);
    std::atomic<size_t> sum{0};
    parallelChunks(50, 1, [&](size_t outer, size_t, size_t) {
      parallelChunks(40, 7, [&](size_t, size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) sum += outer * 40 + i;
      });
    });
    EXPECT_EQ(sum, 1999u * 2000u / 2);
  }
}

// Else the tests with more threads than cores would test nothing.
TEST_F(Parallel, MoreThreadsThanCoresCanMeet) {
  setThreadCount(4);
  std::mutex mutex;
  std::condition_variable condition;
  size_t inside = 0;
  bool met = false;
  parallelChunks(4, 1, [&](size_t, size_t, size_t) {
    std::unique_lock lock(mutex);
    met = ++inside == 4 || met;
    condition.notify_all();
    condition.wait_for(lock, std::chrono::seconds(60), [&] { return met; });
    --inside;
  });
  EXPECT_TRUE(met);
}

TEST_F(Parallel, ThreadCountIsKeptInBounds) {
  setThreadCount(3);
  EXPECT_EQ(threadCount(), 3);
  setThreadCount(100000);
  EXPECT_EQ(threadCount(), 256);
  setThreadCount(-5);
  EXPECT_GE(threadCount(), 1);
  setThreadCount(0);
  EXPECT_GE(threadCount(), 1);
}

#ifdef __SANITIZE_THREAD__
// Else a run of the tests under TSan that reports nothing would say nothing.
TEST(ParallelDeathTest, TsanSeesARaceBetweenChunks) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto race = [] {
    setThreadCount(2);
    std::atomic<int> inside = 0;
    int shared = 0;
    parallelChunks(2, 1, [&](size_t, size_t, size_t) {
      inside.fetch_add(1, std::memory_order_relaxed);
      while (inside.load(std::memory_order_relaxed) < 2) std::this_thread::yield();
      ++shared;
    });
    std::exit(shared == 0);  // 66 for 0 where TSan has reported something
  };
  EXPECT_EXIT(race(), ::testing::ExitedWithCode(66), "data race");
}
#endif

}  // namespace
}  // namespace scree
