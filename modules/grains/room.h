// Arrays that a search makes anew as a whole: no more of them is kept than was needed of late.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace scree::grains {

// Capacity for n things whose number wavers a little.
constexpr size_t roomFor(size_t n) { return n + n / 16; }

// What was needed of late.
class Need {
 public:
  // Notes that n are needed now. The capacity to shrink to, or 0: what there is stays.
  size_t shrinks(size_t n, size_t capacity) {
    most_ = std::max(most_, n);
    if (++times_ < kTimes) return 0;
    const size_t wanted = roomFor(std::exchange(most_, 0));
    times_ = 0;
    return roomFor(wanted) < capacity ? std::max<size_t>(wanted, 1) : 0;
  }

 private:
  static constexpr uint32_t kTimes = 4;
  size_t most_ = 0;
  uint32_t times_ = 0;
};

// Lets a vector hold n, or one more, without doubling it.
template <class T>
void makeRoomFor(std::vector<T>& values, size_t n) {
  if (n > values.capacity()) values.reserve(std::max<size_t>(roomFor(n), 8));
}
// At least what is in it.
template <class T>
void shrinkTo(std::vector<T>& values, size_t capacity) {
  if (values.capacity() <= capacity) return;
  std::vector<T> smaller;
  smaller.reserve(std::max(capacity, values.size()));
  smaller.assign(values.begin(), values.end());
  values = std::move(smaller);
}
// Lets it hold about n: what is far beyond is given back.
template <class T>
void fitTo(std::vector<T>& values, size_t n) {
  constexpr size_t kLittle = 256;
  makeRoomFor(values, n);
  if (values.capacity() > std::max(2 * roomFor(n), kLittle)) shrinkTo(values, roomFor(n));
}
template <class T>
void append(std::vector<T>& values, const std::type_identity_t<T>& value) {
  const T kept = value;  // may lie in what is given up
  makeRoomFor(values, values.size() + 1);
  values.push_back(kept);
}

enum class Contents { Drop, Keep };

template <class T>
class Room {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  Room() = default;
  Room(Room&& other) noexcept { *this = std::move(other); }
  Room(const Room& other) { *this = other; }
  Room& operator=(const Room& other) {
    if (this == &other) return *this;
    data_ = other.capacity_ > 0 ? allocate(other.capacity_) : nullptr;
    std::copy_n(other.data_.get(), other.size_, data_.get());
    size_ = other.size_;
    capacity_ = other.capacity_;
    need_ = other.need_;
    return *this;
  }
  Room& operator=(Room&& other) noexcept {
    data_ = std::move(other.data_);
    size_ = std::exchange(other.size_, 0);
    capacity_ = std::exchange(other.capacity_, 0);
    need_ = other.need_;
    return *this;
  }

  // Makes it hold n, contents undefined.
  std::span<T> remake(size_t n) {
    size_t wanted = need_.shrinks(n, capacity_);
    if (n > capacity_) wanted = roomFor(n);
    if (wanted > 0) {
      data_.reset();  // before there is the other
      data_ = allocate(wanted);
      capacity_ = wanted;
    }
    size_ = n;
    return all();
  }
  std::span<T> remake(size_t n, const T& value) {
    std::ranges::fill(remake(n), value);
    return all();
  }
  // Makes it hold n, of which those that it holds are kept.
  std::span<T> extend(size_t n) {
    if (n > capacity_) {
      auto wider = allocate(roomFor(n));
      std::copy_n(data_.get(), size_, wider.get());
      data_ = std::move(wider);
      capacity_ = roomFor(n);
    }
    size_ = n;
    return all();
  }
  void release() { *this = Room(); }

  std::span<T> all() { return {data_.get(), size_}; }
  std::span<const T> all() const { return {data_.get(), size_}; }
  T* data() { return data_.get(); }
  T& operator[](size_t k) { return data_.get()[k]; }
  const T& operator[](size_t k) const { return data_.get()[k]; }
  size_t size() const { return size_; }
  size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  size_t memoryBytes() const { return capacity_ * sizeof(T); }

 private:
  // Of a cache line, so that no batch of lanes lies across two.
  static constexpr std::align_val_t kAlignment{64};

  struct Free {
    void operator()(T* data) const { ::operator delete(data, kAlignment); }
  };
  using Data = std::unique_ptr<T, Free>;
  static Data allocate(size_t n) {
    T* data = static_cast<T*>(::operator new(n * sizeof(T), kAlignment));
    std::uninitialized_default_construct_n(data, n);
    return Data(data);
  }

  Data data_;
  size_t size_ = 0, capacity_ = 0;
  Need need_;
};

}  // namespace scree::grains
