// A thread that does one job at a time beside its owner.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace scree {

// Started with the first job; parked between jobs.
class Background {
 public:
  Background() = default;
  // Waits for the job.
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  // The job before must have been waited for.
  void start(std::function<void()> job);
  // Until the job is done; throws what it threw. Without a job it returns at once.
  void wait();

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> job_;  // empty: none
  std::exception_ptr thrown_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace scree
