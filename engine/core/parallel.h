// Parallel loops whose work division never depends on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace scree {

// Lets parallel loops use `count` threads (1 to 256, also more than there are cores); 0 = one per
// core. Not while a loop runs.
void setThreadCount(int count);
int threadCount();
// Inside a loop: the number of the thread, below threadCount(), which no other thread of the loop has.
size_t threadIndex();

// Whether a loop is long enough for more than one thread: to wake one costs some 10 us.
enum class Worth { Threads, OneThread };

// Calls body(chunk, begin, end) for every chunk of `chunk_size` items of [0, count), in any order
// and on any thread; chunk boundaries depend only on count and chunk_size. With one thread, with
// one chunk, or if no more are worth it, the calls are made in order on the caller's thread.
void parallelChunks(size_t count, size_t chunk_size,
                    const std::function<void(size_t chunk, size_t begin, size_t end)>& body,
                    Worth worth = Worth::Threads);

}  // namespace scree
