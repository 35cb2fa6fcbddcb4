// Working memory of a search, which its phases share: each takes its part behind those that are still in use.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "modules/grains/room.h"

namespace scree::grains {

class Workspace {
 public:
  Workspace() = default;
  Workspace(Workspace&&) = default;
  Workspace& operator=(Workspace&&) = default;
  // Between searches there is nothing in it.
  Workspace(const Workspace&) {}
  Workspace& operator=(const Workspace&) { return *this; }

  // Takes back all that was given out.
  void reset() {
    // In one piece from now on.
    if (blocks_.size() > 1) {
      blocks_.clear();
      blocks_.emplace_back().extend(most_);
    } else if (!blocks_.empty()) {
      blocks_.front().remake(most_);
    }
    block_ = used_ = before_ = most_ = 0;
  }
  // n of them, contents undefined, until the next reset() or giveBack() to before.
  template <class T>
  std::span<T> take(size_t n) {
    const size_t bytes = (n * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
    while (block_ < blocks_.size() && used_ + bytes > blocks_[block_].capacity()) {
      before_ += used_;
      used_ = 0;
      ++block_;
    }
    if (block_ == blocks_.size()) blocks_.emplace_back().extend(bytes);
    T* const first = reinterpret_cast<T*>(blocks_[block_].data() + used_);
    used_ += bytes;
    most_ = std::max(most_, before_ + used_);
    return {first, n};
  }
  template <class T>
  std::span<T> take(size_t n, const T& value) {
    const std::span<T> all = take<T>(n);
    std::ranges::fill(all, value);
    return all;
  }
  // After giveBack(): takes room for what is still wanted of what was given back, and moves it there. Parts
  // in the order in which they were taken.
  template <class T>
  std::span<T> keep(std::span<T> part) {
    const std::span<T> kept = take<T>(part.size());
    std::memmove(kept.data(), part.data(), part.size_bytes());
    return kept;
  }
  struct Mark {
    size_t block, used, before;
  };
  Mark mark() const { return {block_, used_, before_}; }
  void giveBack(const Mark& to) {
    block_ = to.block;
    used_ = to.used;
    before_ = to.before;
  }
  void release() { *this = Workspace(); }
  size_t memoryBytes() const {
    size_t bytes = 0;
    for (const Room<std::byte>& block : blocks_) bytes += block.memoryBytes();
    return bytes;
  }

 private:
  static constexpr size_t kAlignment = 64;

  std::vector<Room<std::byte>> blocks_;
  size_t block_ = 0, used_ = 0;  // of it
  size_t before_ = 0;            // used of the blocks before it
  size_t most_ = 0;              // in use at a time, since the last reset()
};

}  // namespace scree::grains
