// Singletons: one value a type, owned by the World.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/ecs/access.h"

namespace scree {

struct SingletonHolder {
  virtual ~SingletonHolder() = default;
  virtual void* value() = 0;
};

template <class T>
struct SingletonOf final : SingletonHolder {
  SingletonOf() = default;
  explicit SingletonOf(T initial) : content(std::move(initial)) {}
  void* value() override { return &content; }
  T content{};
};

using MakeSingleton = std::unique_ptr<SingletonHolder> (*)();

// Null if T has no default constructor.
template <class T>
constexpr MakeSingleton singletonMaker() {
  if constexpr (std::is_default_constructible_v<T>)
    return [] { return std::unique_ptr<SingletonHolder>(std::make_unique<SingletonOf<T>>()); };
  else
    return nullptr;
}

// Values live at fixed addresses until set() replaces them; destroyed in the reverse order of their
// making. Making one is safe while systems run in parallel. Values of component types are made from
// their description, so that load() can make what the program has not asked for yet.
class Singletons {
 public:
  ~Singletons();
  // `type` from singletonTypeId; `make` is unused for component types. Ends the program if the
  // value does not exist and cannot be made.
  void* get(uint32_t type, MakeSingleton make, bool writes);
  void* set(uint32_t type, std::unique_ptr<SingletonHolder> holder);
  bool has(uint32_t type) const { return values_[type].load(std::memory_order_acquire) != nullptr; }
  // nullptr if it was not made yet.
  void* find(uint32_t type) const { return values_[type].load(std::memory_order_acquire); }

 private:
  struct Entry {
    uint32_t type;
    std::unique_ptr<SingletonHolder> holder;
  };
  std::mutex mutex_;
  std::vector<Entry> entries_;  // in the order of making
  std::array<std::atomic<void*>, kMaxSingletonTypes> values_{};
};

}  // namespace scree
