// A player made of code: ploughs lane after lane to the edge, to record replays and to stress.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/app/app.h"
#include "game/rules/rules.h"

namespace scree::hourglass {

class Bot {
 public:
  // Lanes run along +Z, from `back_z` to `front_z` (world, metres), at these x, in this order.
  Bot(App& app, std::vector<double> lanes_x, double back_z, double front_z);

  // Decides this tick's actions from the state of the world, and begins them.
  void act(ActionState& actions);
  size_t lanesDone() const { return lanes_done_; }

 private:
  enum class Leg { ToLane, Push, Back };
  App& app_;
  std::vector<double> lanes_x_;
  double back_z_, front_z_;
  Leg leg_ = Leg::ToLane;
  size_t lane_ = 0, lanes_done_ = 0;
  uint64_t leg_ticks_ = 0;
};

}  // namespace scree::hourglass
