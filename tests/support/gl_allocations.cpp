// Counting operator new and delete.
#include "tests/support/gl_allocations.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {
thread_local bool counting = false;
thread_local int allocations = 0;
std::atomic<std::size_t> bytes_in_use = 0;

void* taken(void* memory) {
  if (!memory) throw std::bad_alloc();
  if (counting) ++allocations;
  bytes_in_use.fetch_add(malloc_usable_size(memory), std::memory_order_relaxed);
  return memory;
}
void giveBack(void* memory) {
  if (memory) bytes_in_use.fetch_sub(malloc_usable_size(memory), std::memory_order_relaxed);
  std::free(memory);
}
}  // namespace

void* operator new(std::size_t bytes) {
  return taken(std::malloc(std::max<std::size_t>(bytes, 1)));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  return taken(std::aligned_alloc(unit, (std::max<std::size_t>(bytes, 1) + unit - 1) / unit * unit));
}
void operator delete(void* memory) noexcept {
  giveBack(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  giveBack(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  giveBack(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  giveBack(memory);
}

namespace scree::test {

AllocationCount::AllocationCount() {
  allocations = 0;
  counting = true;
}
AllocationCount::~AllocationCount() {
  counting = false;
}
int AllocationCount::count() const {
  return allocations;
}

std::size_t bytesInUse() {
  return bytes_in_use;
}

}  // namespace scree::test
