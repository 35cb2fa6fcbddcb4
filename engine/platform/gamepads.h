// Private to engine/platform: from the state of gamepads, as GLFW gives it, to raw events.
#pragma once

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <array>
#include <vector>

#include "engine/platform/input.h"

namespace scree {

class Gamepads {
 public:
  // Fills `state` and returns GLFW_TRUE if there is a gamepad `id`, GLFW_JOYSTICK_1 to
  // GLFW_JOYSTICK_LAST: glfwGetGamepadState.
  using Read = int (*)(int id, GLFWgamepadstate* state);

  // Reads all and appends an event for each control that moved since the last call. All gamepads
  // act as one: of each control, the largest deflection counts. One that is gone rests.
  void poll(Read read, std::vector<RawEvent>& events);

 private:
  std::array<float, static_cast<size_t>(Source::Count)> position_{};
};

}  // namespace scree
