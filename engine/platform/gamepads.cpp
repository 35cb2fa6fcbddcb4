// Gamepads: what moved since the last look.
#include "engine/platform/gamepads.h"

#include <cmath>

namespace scree {
namespace {

struct Control {
  Source source;
  SourceGroup group;
  int code;
};
constexpr Control kControls[] = {
#define SCREE_SOURCE(identifier, name, group, code) {Source::identifier, SourceGroup::group, code},
#include "engine/platform/input_sources.h"
};

float positionOf(const Control& control, const GLFWgamepadstate& state) {
  if (control.group == SourceGroup::PadButton)
    return state.buttons[control.code] == GLFW_PRESS ? 1.0f : 0.0f;
  const float axis = state.axes[control.code];
  // GLFW's triggers rest at -1.
  const bool trigger = control.code == GLFW_GAMEPAD_AXIS_LEFT_TRIGGER ||
                       control.code == GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER;
  return trigger ? (axis + 1) / 2 : axis;
}

}  // namespace

void Gamepads::poll(Read read, std::vector<RawEvent>& events) {
  std::array<float, static_cast<size_t>(Source::Count)> now{};
  for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
    GLFWgamepadstate state;
    if (read(id, &state) != GLFW_TRUE) continue;
    for (const Control& control : kControls) {
      if (control.group != SourceGroup::PadButton && control.group != SourceGroup::PadAxis) continue;
      const float position = positionOf(control, state);
      float& largest = now[static_cast<size_t>(control.source)];
      if (std::abs(position) > std::abs(largest)) largest = position;
    }
  }
  for (size_t i = 0; i < now.size(); ++i)
    if (now[i] != position_[i]) events.push_back({static_cast<Source>(i), now[i]});
  position_ = now;
}

}  // namespace scree
