// The game's own bindings, played with a gamepad that is made of code.
#include <gtest/gtest.h>

#include "engine/platform/gamepads.h"
#include "game/rules/rules.h"

namespace scree::hourglass {
namespace {

GLFWgamepadstate pad;
bool present = false;

int readPad(int id, GLFWgamepadstate* state) {
  if (id != GLFW_JOYSTICK_1 || !present) return GLFW_FALSE;
  *state = pad;
  return GLFW_TRUE;
}

class Gamepad : public testing::Test {
 protected:
  void SetUp() override {
    declareActions(app_);
    controls_ = app_.world().singleton<const Controls>();
    present = true;
    pad = {};
    pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] = pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = -1;
  }
  void tick() {
    RawInput input;
    gamepads_.poll(readPad, input.events);
    sampler_.feed(input);
    sampler_.tick(state_);
  }

  App app_{{}};
  Controls controls_;
  Gamepads gamepads_;
  ActionSampler sampler_{app_.actions()};
  ActionState state_;
};

TEST_F(Gamepad, SticksWalkAndLook) {
  tick();
  for (const ActionId action : {controls_.move_x, controls_.move_y, controls_.look_x, controls_.pause,
                                controls_.restart, controls_.quit, controls_.inspect})
    EXPECT_FALSE(state_.down(action)) << "at rest";
  // Sticks seldom come back to exactly 0.
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = 0.1f;
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y] = -0.1f;
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X] = 0.14f;
  tick();
  for (const ActionId action : {controls_.move_x, controls_.move_y, controls_.look_x})
    EXPECT_FALSE(state_.down(action)) << "inside the dead zone";
  // Right and up: right, forward, look right.
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = 1;
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y] = -1;
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X] = 1;
  tick();
  for (const ActionId action : {controls_.move_x, controls_.move_y, controls_.look_x})
    EXPECT_EQ(state_.value(action), 1.0f) << app_.actions().actions()[action].name;
  present = false;
  tick();
  for (const ActionId action : {controls_.move_x, controls_.move_y, controls_.look_x})
    EXPECT_EQ(state_.value(action), 0.0f) << "unplugged while it walks";
}

TEST_F(Gamepad, StartPausesAndBackRestarts) {
  for (const auto& [button, action] : {std::pair{GLFW_GAMEPAD_BUTTON_START, controls_.pause},
                                       {GLFW_GAMEPAD_BUTTON_BACK, controls_.restart}}) {
    pad.buttons[button] = GLFW_PRESS;
    tick();
    for (const ActionId other : {controls_.pause, controls_.restart, controls_.quit, controls_.inspect})
      EXPECT_EQ(state_.pressed(other), other == action);
    // Unplugged while held: released once, and not pressed again by coming back.
    present = false;
    tick();
    EXPECT_TRUE(state_.released(action));
    present = true;
    pad.buttons[button] = GLFW_RELEASE;
    tick();
    EXPECT_FALSE(state_.down(action));
  }
}

}  // namespace
}  // namespace scree::hourglass
