// GL debug output: messages become log lines and a count, so that tests can fail on any.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace scree::gpu {

// Starts synchronous debug output; notifications and performance hints are ignored. Messages of
// one id are logged at most kMaxLogsPerId times, but always counted.
inline constexpr int kMaxLogsPerId = 8;
void enableDebugOutput();

// Debug messages, and misuse found by this library itself (unbound samplers), since the start.
uint64_t debugMessageCount();
// The newest one, empty if there was none.
const std::string& lastDebugMessage();

// Logs and counts a fault that this library found, as if GL had reported it.
void reportFault(std::string_view line);

// Number of pending glGetError codes, each logged; clears them.
int drainErrors();

// Labels a GL object for debuggers; `kind` is GL_BUFFER, GL_TEXTURE, ...
void labelObject(unsigned kind, unsigned id, std::string_view label);

// A named group of GL calls, seen in debuggers and in messages.
class DebugGroup {
 public:
  explicit DebugGroup(std::string_view name);
  ~DebugGroup();
  DebugGroup(const DebugGroup&) = delete;
  DebugGroup& operator=(const DebugGroup&) = delete;
};

}  // namespace scree::gpu
