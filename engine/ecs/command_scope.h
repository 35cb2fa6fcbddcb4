// CommandScope: whose code runs on this thread, which decides where its commands go, in which
// order they are applied, and what the code may touch.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "engine/ecs/access.h"

namespace scree {

class Commands;
struct WorldState;

// Parallel iterations nested in one another within a system; deeper ends the program.
inline constexpr size_t kMaxCommandDepth = 4;

// Commands are applied in ascending order of their keys. Each level holds the sequence number of a
// call in its scope, and the index of the system or chunk.
using CommandKey = std::array<uint64_t, kMaxCommandDepth>;

// What a system that is not exclusive declared.
struct SystemAccess {
  std::string name;
  std::array<uint64_t, (kMaxAccessIds + 63) / 64> reads{};
  std::array<uint64_t, (kMaxAccessIds + 63) / 64> writes{};
};

class CommandScope {
 public:
  // The scope of code outside systems and chunks; not on any thread's stack.
  explicit CommandScope(WorldState& world) : world_(world) {}
  // The scope of system or chunk `index` of a call that `parent` made with number `sequence`; it is
  // the thread's current scope while it lives.
  CommandScope(const CommandScope& parent, uint32_t sequence, uint32_t index,
               const SystemAccess* access);
  ~CommandScope();
  CommandScope(const CommandScope&) = delete;
  CommandScope& operator=(const CommandScope&) = delete;

  // Number of the next call; what is recorded later is applied later.
  uint32_t beginCall() {
    open_ = nullptr;
    return ++sequence_;
  }
  Commands& commands();
  // After a flush: numbers begin anew.
  void restart() {
    open_ = nullptr;
    sequence_ = 0;
  }
  // Null: may touch everything.
  const SystemAccess* access() const { return access_; }

  // This thread's innermost scope of that World; nullptr outside systems and chunks.
  static CommandScope* current(const WorldState& world);
  // This thread's innermost scope.
  static const CommandScope* current();

 private:
  WorldState& world_;
  const SystemAccess* access_ = nullptr;
  CommandScope* outer_ = nullptr;
  bool on_stack_ = false;
  CommandKey prefix_{};
  size_t depth_ = 0;
  uint32_t sequence_ = 0;
  Commands* open_ = nullptr;
};

}  // namespace scree
