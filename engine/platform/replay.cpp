// Recording and playing back actions, and writing the replay format.
#include "engine/platform/replay.h"

#include <fmt/format.h>

#include <iterator>

#include "engine/core/file.h"
#include "engine/core/hash.h"

namespace scree {

std::string formatReplay(const Replay& replay) {
  std::string text;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "scree-replay 2\nlevel {}\ncontent {:016x}\nrate {}\nseed {}\n", replay.level,
                 replay.content, replay.ticks_per_second, replay.seed);
  for (const ReplayAction& action : replay.actions)
    fmt::format_to(out, "action {} {}\n", action.name,
                   action.kind == ActionKind::Axis ? "axis" : "button");
  fmt::format_to(out, "begin\n");
  for (const ReplayChange& change : replay.changes)
    fmt::format_to(out, "{} {} {}\n", change.tick, replay.actions[change.action].name,
                   change.value);
  fmt::format_to(out, "end {} checksum ", replay.ticks);
  const uint64_t checksum = hashBytes(text.data(), text.size());
  fmt::format_to(out, "{:016x}\n", checksum);
  return text;
}

Status writeReplay(const std::filesystem::path& path, const Replay& replay) {
  const std::string text = formatReplay(replay);
  if (Result<Replay> read = parseReplay(text, path.string()); !read) return read.takeError();
  return writeFile(path, text);
}

ReplayRecorder::ReplayRecorder(const ActionMap& map, std::string level, uint64_t content, uint64_t seed,
                               uint32_t ticks_per_second) {
  replay_.level = std::move(level);
  replay_.content = content;
  replay_.seed = seed;
  replay_.ticks_per_second = ticks_per_second;
  for (const ActionDesc& action : map.actions())
    replay_.actions.push_back({action.name, action.kind});
}

void ReplayRecorder::record(const ActionState& state) {
  ++replay_.ticks;
  for (uint32_t i = 0; i < replay_.actions.size(); ++i) {
    const int16_t value = state.quantised(i);
    if (value == values_[i]) continue;
    values_[i] = value;
    replay_.changes.push_back({replay_.ticks, i, value});
  }
}

ReplayPlayer::ReplayPlayer(Replay replay, const ActionMap& map) : replay_(std::move(replay)) {
  for (const ReplayAction& action : replay_.actions) ids_.push_back(map.id(action.name));
}

void ReplayPlayer::tick(ActionState& state) {
  if (finished()) {
    values_ = {};
  } else {
    ++tick_;
    for (; next_change_ < replay_.changes.size() && replay_.changes[next_change_].tick == tick_;
         ++next_change_) {
      const ReplayChange& change = replay_.changes[next_change_];
      values_[ids_[change.action]] = change.value;
    }
  }
  state.begin(values_);
}

}  // namespace scree
