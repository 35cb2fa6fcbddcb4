// From raw events to the values of one tick.
#include <algorithm>
#include <cmath>

#include "engine/platform/input.h"

namespace scree {
namespace {

// A button's presses and releases that may wait for ticks; more are dropped in pairs.
constexpr uint8_t kMaxChanges = 3;
constexpr float kButtonThreshold = 0.5f;

float withoutDeadZone(float position, float dead_zone) {
  const float size = std::min(std::abs(position), 1.0f);
  if (size <= dead_zone) return 0;
  return std::copysign((size - dead_zone) / (1 - dead_zone), position);
}

float bound(const Binding& binding, float position) {
  if (sourceGroup(binding.source) == SourceGroup::PadAxis)
    position = withoutDeadZone(position, binding.dead_zone);
  return position * binding.scale;
}

size_t index(Source source) {
  return static_cast<size_t>(source);
}

}  // namespace

void ActionState::begin(std::span<const int16_t> values) {
  before_ = now_;
  const size_t count = std::min(values.size(), now_.size());
  std::copy_n(values.begin(), count, now_.begin());
  std::fill(now_.begin() + static_cast<std::ptrdiff_t>(count), now_.end(), int16_t{0});
}

ActionSampler::ActionSampler(const ActionMap& map) : map_(&map) {}

void ActionSampler::reset() {
  position_ = {};
  tapped_ = {};
  motion_ = {};
  down_ = {};
  changes_ = {};
  values_ = {};
}

void ActionSampler::feed(const RawInput& input) {
  const auto change = [&](size_t action, int count) {
    changes_[action] = static_cast<uint8_t>(changes_[action] + count);
    while (changes_[action] > kMaxChanges)
      changes_[action] = static_cast<uint8_t>(changes_[action] - 2);
  };
  for (const RawEvent& event : input.events) {
    if (event.source >= Source::Count || !std::isfinite(event.value)) continue;
    const SourceGroup group = sourceGroup(event.source);
    const bool moves = group == SourceGroup::MouseMotion;
    if (!moves) {
      position_[index(event.source)] = event.value;
      if (group != SourceGroup::PadAxis && event.value != 0) tapped_[index(event.source)] = true;
    }
    for (size_t i = 0; i < map_->actions().size(); ++i) {
      const ActionDesc& action = map_->actions()[i];
      bool down = false;
      for (const Binding& binding : action.bindings) {
        if (moves && binding.source == event.source) {
          const float amount = event.value * binding.scale;
          if (action.kind == ActionKind::Axis)
            motion_[i] = std::clamp(motion_[i] + amount, -kMaxMotionTicks, kMaxMotionTicks);
          else if (amount >= kButtonThreshold && !down_[i])
            change(i, 2);  // a notch of the wheel is a press and a release
        }
        if (sourceGroup(binding.source) != SourceGroup::MouseMotion)
          down = down || bound(binding, position_[index(binding.source)]) >= kButtonThreshold;
      }
      if (action.kind == ActionKind::Button && down != (down_[i] != 0)) {
        down_[i] = down;
        change(i, 1);
      }
    }
  }
}

void ActionSampler::tick(ActionState& state) {
  const std::span<const ActionDesc> actions = map_->actions();
  for (size_t i = 0; i < actions.size(); ++i) {
    if (actions[i].kind == ActionKind::Button) {
      if (changes_[i] == 0) continue;
      --changes_[i];
      values_[i] = values_[i] == 0 ? kFullValue : int16_t{0};
      continue;
    }
    float held = 0;
    for (const Binding& binding : actions[i].bindings) {
      if (sourceGroup(binding.source) == SourceGroup::MouseMotion) continue;
      const size_t source = index(binding.source);
      held += bound(binding, tapped_[source] ? 1.0f : position_[source]);
    }
    const int held_steps = quantise(held);
    const int steps = std::clamp(static_cast<int>(std::lround(motion_[i] * kFullValue)),
                                 -kFullValue - held_steps, kFullValue - held_steps);
    motion_[i] -= static_cast<float>(steps) / static_cast<float>(kFullValue);
    values_[i] = static_cast<int16_t>(held_steps + steps);
  }
  tapped_ = {};
  state.begin(std::span(values_).first(actions.size()));
}

}  // namespace scree
