// Counts heap allocations of one thread and the bytes of all, for tests of "the steady state allocates nothing".
// A test that uses it gets counting versions of operator new and delete.
#pragma once

#include <cstddef>

namespace scree::test {

// Counts operator new of the constructing thread from construction on; one at a time.
class AllocationCount {
 public:
  AllocationCount();
  ~AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  AllocationCount& operator=(const AllocationCount&) = delete;
  int count() const;
};

// Bytes of what operator new gave to any thread and delete has not taken back. The C library's own sums (mallinfo)
// would count small blocks that it keeps for the next request.
std::size_t bytesInUse();

}  // namespace scree::test
