// Recorded actions, tick by tick: the same run again, from a text file.
//
//   scree-replay 2                      format and version
//   level level1.glb                    what was played; the rest of the line
//   content 0123456789abcdef            hash of what the level's file held
//   rate 60                             ticks a second
//   seed 0                              of the level's random numbers
//   action move_x axis                  one line an action, in the map's order
//   action pause button
//   begin
//   12 move_x -32767                    tick (1 = first), action, value in 1/32767 steps: changes
//   40 move_x 0                         only, ticks never go back, actions of a tick in order
//   end 1800 checksum 0123456789abcdef  ticks in all; hash of every byte before the 16 digits
//
// Lines end with '\n'; other control characters are refused. All values are 0 before tick 1.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"
#include "engine/platform/input.h"

namespace scree {

// Longer recordings are refused: 24 hours at 60 ticks a second.
inline constexpr uint64_t kMaxReplayTicks = 24ull * 60 * 60 * 60;
// Larger files are refused.
inline constexpr uint64_t kMaxReplayBytes = 64ull << 20;
// Longer lines are refused.
inline constexpr size_t kMaxReplayLine = 320;
// Longer level names are refused.
inline constexpr size_t kMaxLevelName = 256;

struct ReplayAction {
  std::string name;
  ActionKind kind = ActionKind::Button;
  bool operator==(const ReplayAction&) const = default;
};

// From `tick` on, the action has this value.
struct ReplayChange {
  uint64_t tick = 1;
  uint32_t action = 0;  // index into Replay::actions
  int16_t value = 0;
  bool operator==(const ReplayChange&) const = default;
};

struct Replay {
  std::string level;
  uint64_t content = 0;
  uint32_t ticks_per_second = 60;
  uint64_t seed = 0;
  std::vector<ReplayAction> actions;
  std::vector<ReplayChange> changes;  // sorted by (tick, action)
  uint64_t ticks = 0;
  bool operator==(const Replay&) const = default;
};

// Reads a replay. Anything that is not exactly the format is refused with "file:line: reason". With
// `map`, an action that the map does not have, or has with another kind, is refused too.
Result<Replay> readReplay(const std::filesystem::path& path, const ActionMap* map = nullptr);
Result<Replay> parseReplay(std::string_view text, std::string_view file,
                           const ActionMap* map = nullptr);
std::string formatReplay(const Replay& replay);
// Writes beside the target, then renames. Refuses what readReplay would refuse.
Status writeReplay(const std::filesystem::path& path, const Replay& replay);

// Notes the actions of each tick. Allocates only when values change.
class ReplayRecorder {
 public:
  ReplayRecorder(const ActionMap& map, std::string level, uint64_t content, uint64_t seed = 0,
                 uint32_t ticks_per_second = 60);
  // Once a tick, in order, after ActionState::begin.
  void record(const ActionState& state);
  const Replay& replay() const { return replay_; }

 private:
  Replay replay_;
  std::array<int16_t, kMaxActions> values_{};
};

// Plays a replay back, one tick a call.
class ReplayPlayer {
 public:
  // Every action of the replay must be in the map: readReplay(path, &map) checks that.
  ReplayPlayer(Replay replay, const ActionMap& map);
  const Replay& replay() const { return replay_; }
  uint64_t tickIndex() const { return tick_; }  // ticks played
  bool finished() const { return tick_ >= replay_.ticks; }
  // Begins the next tick in `state`; after the last one, all values are 0.
  void tick(ActionState& state);

 private:
  Replay replay_;
  std::vector<ActionId> ids_;  // in the map, of each action of the replay
  uint64_t tick_ = 0;
  size_t next_change_ = 0;
  std::array<int16_t, kMaxActions> values_{};
};

}  // namespace scree
