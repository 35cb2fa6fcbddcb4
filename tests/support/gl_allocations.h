// Counts heap allocations of one thread, for tests of "the steady state allocates nothing".
// A test that uses it gets counting versions of operator new and delete.
#pragma once

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

}  // namespace scree::test
