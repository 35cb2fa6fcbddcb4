// Three legs a lane: beside the heap to the lane's start, push to the edge, and back.
#include "tests/game/support/bot.h"

#include <algorithm>
#include <cmath>

#include "modules/scene/scene.h"

namespace scree::hourglass {
namespace {

constexpr double kReached = 0.25;       // m
constexpr uint64_t kPatience = 60 * 8;  // ticks after which a leg that goes nowhere is given up

}  // namespace

Bot::Bot(App& app, std::vector<double> lanes_x, double back_z, double front_z)
    : app_(app), lanes_x_(std::move(lanes_x)), back_z_(back_z), front_z_(front_z) {}

void Bot::act(ActionState& actions) {
  World& world = app_.world();
  const Controls& controls = world.singleton<const Controls>();
  dvec3 position{0};
  world.query<const Creature, const Transform>().each(
      [&](const Creature&, const Transform& transform) { position = transform.position; });
  vec2 view{0, 1};
  world.query<const FollowCamera>().each([&](const FollowCamera& camera) { view = camera.heading; });

  const double x = lanes_x_[lane_ % lanes_x_.size()];
  const auto legDone = [&] {
    const bool given_up = ++leg_ticks_ > kPatience;
    switch (leg_) {
      case Leg::ToLane: return given_up || std::abs(position.x - x) < kReached;
      case Leg::Push: return given_up || position.z >= front_z_;
      case Leg::Back: return given_up || position.z <= back_z_;
    }
    return true;
  };
  if (legDone()) {
    leg_ticks_ = 0;
    if (leg_ == Leg::Back) {
      ++lane_;
      ++lanes_done_;
    }
    leg_ = leg_ == Leg::ToLane ? Leg::Push : leg_ == Leg::Push ? Leg::Back : Leg::ToLane;
  }
  const double goal_x = lanes_x_[lane_ % lanes_x_.size()];
  const double goal_z = leg_ == Leg::Push ? front_z_ + 1 : leg_ == Leg::Back ? back_z_ - 1 : back_z_;
  vec2 wanted{static_cast<float>(goal_x - position.x), static_cast<float>(goal_z - position.z)};
  const float length = std::sqrt(wanted.x * wanted.x + wanted.y * wanted.y);
  if (length > 1e-3f) wanted = wanted / length;

  std::array<int16_t, kMaxActions> values{};
  values[controls.move_x] = quantise(-wanted.x * view.y + wanted.y * view.x);
  values[controls.move_y] = quantise(wanted.x * view.x + wanted.y * view.y);
  actions.begin(values);
}

}  // namespace scree::hourglass
