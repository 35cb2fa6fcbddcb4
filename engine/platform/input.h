// From keys, mouse and gamepads to named actions: what the simulation sees of the player.
//
// A context appends RawEvents; an ActionSampler turns them into one ActionState a tick, as an
// ActionMap says. Values are multiples of 1/32767, so that a replay repeats them exactly.
//
// Bindings file (JSON; actions that it does not name keep their bindings; an empty list unbinds):
//   { "version": 1,
//     "actions": {
//       "pause":  ["key.p", "pad.start"],
//       "move_x": ["key.d", {"source": "key.a", "scale": -1},
//                  {"source": "pad.left_x", "dead_zone": 0.2}] } }
//   source     a name of input_sources.h
//   scale      -100 to 100, not 0, default 1: what a fully pressed source, or one pixel of mouse
//              motion, or one notch of the wheel, adds to the action
//   dead_zone  0 to 0.9, default 0.15: gamepad axes only
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"

namespace scree {

enum class Source : uint16_t {
#define SCREE_SOURCE(identifier, name, group, code) identifier,
#include "engine/platform/input_sources.h"
  Count
};
enum class SourceGroup : uint8_t { Key, MouseButton, MouseMotion, PadButton, PadAxis };

// "key.a", "mouse.left", "pad.left_x"; Source::Count for a name that does not exist.
std::string_view sourceName(Source source);
Source findSource(std::string_view name);
SourceGroup sourceGroup(Source source);

struct RawEvent {
  Source source;
  // Keys and buttons: 1 down, 0 up. Gamepad axes: the position, -1 to 1 (triggers: 0 to 1).
  // Mouse motion: the amount, in pixels (right and down positive) or notches (away positive).
  float value;
};

// What happened, in order. The owner clears `events` after feeding them to a sampler.
struct RawInput {
  std::vector<RawEvent> events;
};

enum class ActionKind : uint8_t {
  Button,  // 0 or 1: down while some bound source times its scale is at least 0.5
  Axis,    // -1 to 1: the sum over the bound sources of value times scale, clamped
};

struct Binding {
  Source source = Source::Count;
  float scale = 1;
  float dead_zone = 0.15f;  // gamepad axes: positions below it are 0, the rest is stretched
};

inline constexpr size_t kMaxActionName = 31;
// 1 to kMaxActionName lower-case letters, digits and '_'.
bool isActionName(std::string_view name);

struct ActionDesc {
  std::string name;  // see isActionName
  ActionKind kind = ActionKind::Button;
  std::vector<Binding> bindings;
};

// Index of an action in its ActionMap.
using ActionId = uint32_t;
// Actions of one map; declaring more ends the program.
inline constexpr size_t kMaxActions = 64;
// Bindings of one action; a file that gives more is refused.
inline constexpr size_t kMaxBindings = 16;
inline constexpr float kMaxBindingScale = 100;
inline constexpr float kMaxDeadZone = 0.9f;
// The value of a button that is down, and of an axis at its end.
inline constexpr int16_t kFullValue = 32767;

// The nearest step; NaN is 0; values outside -1..1 are clamped.
int16_t quantise(float value);
constexpr float actionValue(int16_t quantised) {
  return static_cast<float>(quantised) / static_cast<float>(kFullValue);
}

class ActionMap {
 public:
  // Declares an action with its default bindings. A name that is taken or malformed, or a binding
  // that the file format would refuse, ends the program.
  ActionId add(ActionDesc action);
  // A declared action's index; a name that was not declared ends the program.
  ActionId id(std::string_view name) const;
  bool has(std::string_view name) const;
  std::span<const ActionDesc> actions() const { return actions_; }

  // Replaces the bindings of the actions that the file names: of all, or, on an error, of none.
  // The error names file, action, field, value and what is allowed.
  Status loadBindings(const std::filesystem::path& path);
  Status parseBindings(std::string_view json, std::string_view file);
  // The bindings as such a file, with every action: a start for a player's own.
  std::string formatBindings() const;

 private:
  std::vector<ActionDesc> actions_;
};

// World singleton: the actions of the current tick; set before Phase::Input.
class ActionState {
 public:
  // -1 to 1 (axis), 0 or 1 (button); 0 for an action that never had a value.
  float value(ActionId action) const { return actionValue(now_[action]); }
  int16_t quantised(ActionId action) const { return now_[action]; }
  bool down(ActionId action) const { return now_[action] != 0; }
  // True in the one tick in which the value left, or returned to, 0.
  bool pressed(ActionId action) const { return now_[action] != 0 && before_[action] == 0; }
  bool released(ActionId action) const { return now_[action] == 0 && before_[action] != 0; }

  // Begins a tick: what was `now` is `before`; values beyond the span are 0.
  void begin(std::span<const int16_t> values);

 private:
  std::array<int16_t, kMaxActions> now_{};
  std::array<int16_t, kMaxActions> before_{};
};

// Gathers raw events between ticks. No press is lost: a button pressed and released between two
// ticks is down in the next tick and up in the one after; mouse motion is kept until a tick takes
// it, and what is beyond an axis' range goes to the ticks after (up to kMaxMotionTicks of them).
class ActionSampler {
 public:
  static constexpr float kMaxMotionTicks = 4;

  // `map` must outlive the sampler; bindings may be reloaded, actions may be added.
  explicit ActionSampler(const ActionMap& map);
  void feed(const RawInput& input);
  // Takes one tick's worth and begins the tick in `state`.
  void tick(ActionState& state);
  // Forgets what is held and what is pending: after a pause or a change of bindings.
  void reset();

 private:
  const ActionMap* map_;
  std::array<float, static_cast<size_t>(Source::Count)> position_{};  // of what stays where it is
  std::array<float, kMaxActions> motion_{};                           // not yet taken, action units
  std::array<bool, static_cast<size_t>(Source::Count)> tapped_{};  // went down since the last tick
  std::array<uint8_t, kMaxActions> down_{};                        // buttons, after all events
  std::array<uint8_t, kMaxActions> changes_{};  // presses and releases not yet taken by a tick
  std::array<int16_t, kMaxActions> values_{};   // of the last tick
};

}  // namespace scree
