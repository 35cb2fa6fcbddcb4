// The thread beside its owner: one job at a time, waited for, and what a job throws.
#include "engine/core/background.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

namespace scree {
namespace {

TEST(Background, WaitWithoutAJobReturns) {
  Background beside;
  beside.wait();
}

TEST(Background, JobsRunOneAfterAnotherOnOneOtherThread) {
  Background beside;
  std::vector<std::thread::id> threads;
  for (int i = 0; i < 1000; ++i) {
    beside.start([&] { threads.push_back(std::this_thread::get_id()); });
    beside.wait();
    ASSERT_EQ(threads.size(), static_cast<size_t>(i) + 1);
  }
  EXPECT_NE(threads.front(), std::this_thread::get_id());
  for (const std::thread::id& id : threads) ASSERT_EQ(id, threads.front());
}

TEST(Background, JobRunsWhileItsOwnerGoesOn) {
  Background beside;
  std::promise<void> from_owner, from_job;
  std::future<void> owner_was_here = from_owner.get_future();
  beside.start([&] {
    from_job.set_value();
    owner_was_here.wait();
  });
  EXPECT_EQ(from_job.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
  from_owner.set_value();
  beside.wait();
}

TEST(Background, DestructionWaitsForTheJob) {
  bool done = false;
  {
    Background beside;
    beside.start([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      done = true;
    });
  }
  EXPECT_TRUE(done);
}

TEST(Background, WhatAJobThrowsReachesTheOwnerOnce) {
  Background beside;
  beside.start([] { throw std::runtime_error("spilt"); });
  EXPECT_THROW(beside.wait(), std::runtime_error);
  beside.wait();
  bool again = false;
  beside.start([&] { again = true; });
  beside.wait();
  EXPECT_TRUE(again);
}

TEST(BackgroundDeathTest, RefusesASecondJob) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        Background beside;
        std::promise<void> never;
        std::future<void> gate = never.get_future();
        beside.start([&] { gate.wait(); });
        beside.start([] {});
      },
      "a job is started while another runs");
}

}  // namespace
}  // namespace scree
