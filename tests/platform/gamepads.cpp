// Gamepads without hardware: states as GLFW would give them, through events and bindings to actions.
#include "engine/platform/gamepads.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace scree {
namespace {

// What is plugged in, by GLFW's number.
std::array<std::optional<GLFWgamepadstate>, GLFW_JOYSTICK_LAST + 1> plugged;

int readPlugged(int id, GLFWgamepadstate* state) {
  if (id < GLFW_JOYSTICK_1 || id > GLFW_JOYSTICK_LAST) ADD_FAILURE() << "no such gamepad: " << id;
  if (!plugged[static_cast<size_t>(id)]) return GLFW_FALSE;
  *state = *plugged[static_cast<size_t>(id)];
  return GLFW_TRUE;
}

// A gamepad that nobody touches: GLFW's triggers rest at -1.
GLFWgamepadstate atRest() {
  GLFWgamepadstate state{};
  state.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] = state.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = -1;
  return state;
}

class GamepadTest : public testing::Test {
 protected:
  void SetUp() override { plugged.fill(std::nullopt); }

  GLFWgamepadstate& plug(int id) { return plugged[static_cast<size_t>(id)].emplace(atRest()); }
  void unplug(int id) { plugged[static_cast<size_t>(id)].reset(); }

  // The events of one look.
  std::map<Source, float> poll() {
    RawInput input;
    gamepads_.poll(readPlugged, input.events);
    std::map<Source, float> moved;
    for (const RawEvent& event : input.events)
      EXPECT_TRUE(moved.emplace(event.source, event.value).second) << sourceName(event.source);
    sampler_.feed(input);
    return moved;
  }
  // A look and a tick; the actions then.
  const ActionState& tick() {
    poll();
    sampler_.tick(state_);
    return state_;
  }

  Gamepads gamepads_;
  ActionMap map_;
  ActionId walk_ = map_.add({"walk", ActionKind::Axis, {{Source::PadLeftX, 1, 0.2f}}});
  ActionId forward_ = map_.add({"forward", ActionKind::Axis, {{Source::PadLeftY, -1}}});
  ActionId jump_ = map_.add({"jump", ActionKind::Button, {{Source::PadA}, {Source::PadRightTrigger}}});
  ActionSampler sampler_{map_};
  ActionState state_;
};

using Event = std::map<Source, float>;

TEST_F(GamepadTest, WithoutOneAndWithOneAtRestNothingHappens) {
  EXPECT_EQ(poll(), Event{});
  plug(GLFW_JOYSTICK_3);
  EXPECT_EQ(poll(), Event{}) << "triggers rest at -1";
  EXPECT_EQ(poll(), Event{});
}

TEST_F(GamepadTest, EachButtonIsItsOwnSource) {
  constexpr Source kButtons[] = {
      Source::PadA,     Source::PadB,         Source::PadX,          Source::PadY,    Source::PadLeftBumper,
      Source::PadRightBumper, Source::PadBack, Source::PadStart,     Source::PadGuide, Source::PadLeftThumb,
      Source::PadRightThumb,  Source::PadUp,   Source::PadRight,     Source::PadDown, Source::PadLeft};
  static_assert(std::size(kButtons) == GLFW_GAMEPAD_BUTTON_LAST + 1);
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_1);
  for (size_t button = 0; button < std::size(kButtons); ++button) {
    pad.buttons[button] = GLFW_PRESS;
    EXPECT_EQ(poll(), (Event{{kButtons[button], 1}})) << button;
    EXPECT_EQ(poll(), Event{}) << "held";
    pad.buttons[button] = GLFW_RELEASE;
    EXPECT_EQ(poll(), (Event{{kButtons[button], 0}})) << button;
  }
}

TEST_F(GamepadTest, EachAxisIsItsOwnSourceAndTriggersGoFromZeroToOne) {
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_LAST);
  constexpr Source kSticks[] = {Source::PadLeftX, Source::PadLeftY, Source::PadRightX, Source::PadRightY};
  for (size_t axis = 0; axis < std::size(kSticks); ++axis) {
    for (const float position : {0.5f, -1.0f, 1.0f, 0.0f}) {
      pad.axes[axis] = position;
      EXPECT_EQ(poll(), (Event{{kSticks[axis], position}})) << axis;
    }
  }
  for (const auto& [axis, source] : {std::pair{GLFW_GAMEPAD_AXIS_LEFT_TRIGGER, Source::PadLeftTrigger},
                                     {GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER, Source::PadRightTrigger}}) {
    for (const float position : {0.0f, 1.0f, -1.0f}) {
      pad.axes[axis] = position;
      EXPECT_EQ(poll(), (Event{{source, (position + 1) / 2}})) << axis;
    }
  }
}

TEST_F(GamepadTest, TheStickHasADeadZoneAndReachesItsEnd) {
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_1);
  const auto at = [&](float position) {
    pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = position;
    return tick().value(walk_);
  };
  // A worn stick that trembles about its rest moves nothing.
  for (const float position : {0.05f, -0.13f, 0.2f, -0.2f, 0.0f}) EXPECT_EQ(at(position), 0.0f) << position;
  EXPECT_GT(at(0.21f), 0.0f) << "no step at its edge";
  EXPECT_LT(at(0.21f), 0.02f);
  EXPECT_NEAR(at(0.6f), 0.5f, 1e-4f);
  EXPECT_NEAR(at(-0.6f), -0.5f, 1e-4f);
  EXPECT_EQ(at(1.0f), 1.0f);
  EXPECT_EQ(at(-1.0f), -1.0f);
  float before = -1;
  for (int i = -100; i <= 100; ++i) {
    const float now = at(static_cast<float>(i) / 100);
    EXPECT_GE(now, before) << i;
    before = now;
  }
  // GLFW's sticks point down; forward is up.
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y] = -1;
  EXPECT_EQ(tick().value(forward_), 1.0f);
}

TEST_F(GamepadTest, ButtonsAndTriggersPressActions) {
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_2);
  EXPECT_FALSE(tick().down(jump_)) << "a trigger at rest is no press";
  pad.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_PRESS;
  EXPECT_TRUE(tick().pressed(jump_));
  EXPECT_FALSE(tick().pressed(jump_));
  EXPECT_TRUE(state_.down(jump_));
  pad.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_RELEASE;
  EXPECT_TRUE(tick().released(jump_));
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = -0.2f;
  EXPECT_FALSE(tick().down(jump_)) << "0.4 of the way";
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = 0.8f;
  EXPECT_TRUE(tick().pressed(jump_));
}

TEST_F(GamepadTest, APulledPlugLetsGoOfEverything) {
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_1);
  pad.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_PRESS;
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = 1;
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] = 1;
  EXPECT_TRUE(tick().down(jump_));
  EXPECT_EQ(state_.value(walk_), 1.0f);
  unplug(GLFW_JOYSTICK_1);
  EXPECT_EQ(poll(), (Event{{Source::PadA, 0}, {Source::PadLeftX, 0}, {Source::PadLeftTrigger, 0}}));
  EXPECT_TRUE(tick().released(jump_));
  EXPECT_EQ(state_.value(walk_), 0.0f);
  // Plugged in again, elsewhere and with the button held, it plays on.
  plug(GLFW_JOYSTICK_4).buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_PRESS;
  EXPECT_TRUE(tick().pressed(jump_));
}

TEST_F(GamepadTest, OfTwoTheLargerDeflectionCounts) {
  GLFWgamepadstate& one = plug(GLFW_JOYSTICK_1);
  GLFWgamepadstate& two = plug(GLFW_JOYSTICK_2);
  one.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = 0.4f;
  two.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = -0.9f;
  one.buttons[GLFW_GAMEPAD_BUTTON_A] = two.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_PRESS;
  EXPECT_EQ(poll(), (Event{{Source::PadLeftX, -0.9f}, {Source::PadA, 1}}));
  two.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_RELEASE;
  EXPECT_EQ(poll(), Event{}) << "the other still holds it";
  unplug(GLFW_JOYSTICK_2);
  EXPECT_EQ(poll(), (Event{{Source::PadLeftX, 0.4f}}));
  one.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_RELEASE;
  EXPECT_EQ(poll(), (Event{{Source::PadA, 0}}));
}

TEST_F(GamepadTest, ABrokenDriverDoesNoHarm) {
  GLFWgamepadstate& pad = plug(GLFW_JOYSTICK_1);
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity(), -7.0f, 1e30f}) {
    for (float& axis : pad.axes) axis = bad;
    for (unsigned char& button : pad.buttons) button = 0xff;
    const ActionState& state = tick();
    for (const ActionId action : {walk_, forward_, jump_}) {
      EXPECT_LE(std::abs(state.value(action)), 1.0f) << bad;
    }
  }
  plug(GLFW_JOYSTICK_1);
  tick();
  for (int i = 0; i < 4; ++i) tick();
  for (const ActionId action : {walk_, forward_, jump_}) EXPECT_FALSE(state_.down(action));
}

}  // namespace
}  // namespace scree
