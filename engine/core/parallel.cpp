// Parallel loops on oneTBB, whose idle threads park.
#include "engine/core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>

#ifdef SCREE_SANITIZE_THREAD
#include <sanitizer/tsan_interface.h>
#endif

namespace scree {
namespace {

// Tells TSan, which does not see into oneTBB, what that keeps in order: the chunks of a loop run after
// what came before it, and before what comes after it; of each other they know nothing.
#ifdef SCREE_SANITIZE_THREAD
class LoopOrder {
 public:
  LoopOrder() { __tsan_release(&before_); }
  ~LoopOrder() { __tsan_acquire(&after_); }
  void beginChunk() { __tsan_acquire(&before_); }
  void endChunk() { __tsan_release(&after_); }

 private:
  char before_ = 0, after_ = 0;
};
#else
struct LoopOrder {
  void beginChunk() {}
  void endChunk() {}
};
#endif

struct Threads {
  explicit Threads(int wanted)
      : count(std::clamp(wanted > 0 ? wanted : tbb::info::default_concurrency(), 1, 256)),
        limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(count)),
        arena(count) {}
  int count;
  tbb::global_control limit;
  tbb::task_arena arena;  // oneTBB's own has no more threads than the machine has cores
};

std::unique_ptr<Threads>& threads() {
  static auto instance = std::make_unique<Threads>(0);
  return instance;
}

}  // namespace

void setThreadCount(int count) {
  threads().reset();  // of two limits at a time the smaller would hold
  threads() = std::make_unique<Threads>(count);
}

int threadCount() {
  return threads()->count;
}

size_t threadIndex() {
  // A loop on the caller's thread alone is outside the arena, or inside somebody else's.
  const int index = tbb::this_task_arena::current_thread_index();
  return static_cast<size_t>(std::clamp(index, 0, threadCount() - 1));
}

void parallelChunks(size_t count, size_t chunk_size,
                    const std::function<void(size_t, size_t, size_t)>& body, Worth worth) {
  const size_t chunks = (count + chunk_size - 1) / chunk_size;
  const auto run = [&](size_t chunk) {
    body(chunk, chunk * chunk_size, std::min(count, (chunk + 1) * chunk_size));
  };
  if (chunks <= 1 || worth == Worth::OneThread || threadCount() == 1) {
    for (size_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  LoopOrder order;
  const auto run_in_order = [&](size_t chunk) {
    order.beginChunk();
    run(chunk);
    order.endChunk();
  };
  threads()->arena.execute([&] { tbb::parallel_for(size_t{0}, chunks, run_in_order); });
}

}  // namespace scree
