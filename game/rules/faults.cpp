// What a level may say of the game's components.
#include "engine/ecs/range.h"
#include "game/rules/rules.h"

namespace scree::hourglass {
namespace {

constexpr const char* kOwn = "is kept by the game itself; must be left out";

}  // namespace

std::string fault(const Creature& creature) {
  return firstFault({{"walk_speed_m_s", creature.walk_speed_m_s, 0, 50},
                     {"turn_speed_rad_s", creature.turn_speed_rad_s, 0, 100},
                     {"plough_width_m", creature.plough_width_m, 0.1f, 20},
                     {"height_m", creature.height_m, 0.1f, 20}});
}
std::string fault(const Scale& scale) {
  return firstFault({{"target_kg", scale.target_kg, 0.001f, 1e9f}, {"hold_s", scale.hold_s, 0, 3600}});
}
std::string fault(const Needle& needle) {
  return firstFault({{"turn_at_target_rad", needle.turn_at_target_rad, -6.2831854f, 6.2831854f},
                     {"most_turn_rad", needle.most_turn_rad, 0, 6.2831854f}});
}
std::string fault(const LevelRules& rules) {
  return firstFault({{"time_limit_s", rules.time_limit_s, 1, 86400}});
}
std::string fault(const FollowCamera& camera) {
  return firstFault({{"distance_m", camera.distance_m, 0.1f, 1000},
                     {"height_m", camera.height_m, -1000, 1000},
                     {"look_ahead_m", camera.look_ahead_m, -1000, 1000}});
}
std::string fault(const CreatureMotion&) { return kOwn; }
std::string fault(const PloughPart&) { return kOwn; }
std::string fault(const ScaleReading&) { return kOwn; }
std::string fault(const NeedleZero&) { return kOwn; }

}  // namespace scree::hourglass
