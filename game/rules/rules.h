// The rules of Hourglass: a creature shoulders grains onto a scale before the time runs out.
//
// Components are attached by the level's node extras; addRules registers the systems that move them.
// Headings and rotations use no transcendental functions, so that a run is the same everywhere.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/app/app.h"
#include "engine/core/math.h"
#include "engine/core/result.h"
#include "engine/ecs/component.h"

namespace scree::hourglass {

// The player's beast, at its feet; faces +Z of its Transform.
struct Creature {
  float walk_speed_m_s = 2.2f;
  float turn_speed_rad_s = 4.0f;
  float plough_width_m = 1.6f;  // tip to tip
  float height_m = 0.9f;
};
std::string fault(const Creature& creature);
SCREE_COMPONENT(Creature, (walk_speed_m_s, "m/s"), (turn_speed_rad_s, "rad/s"),
                (plough_width_m, "m"), (height_m, "m"));

// How a creature moves now.
struct CreatureMotion {
  vec3 velocity{0};       // m/s
  vec2 heading{0, 1};     // unit, (x, z): where it faces
  bool grounded = false;
};
std::string fault(const CreatureMotion& motion);
SCREE_COMPONENT(CreatureMotion, (velocity, "m/s"), (heading, ""), (grounded, ""));

// A capsule of the plough: keeps the creature's Transform.
struct PloughPart {
  Entity creature = Entity::kNone;
};
std::string fault(const PloughPart& part);
SCREE_COMPONENT(PloughPart, (creature, ""));

// A camera that keeps behind its target.
struct FollowCamera {
  Entity target = Entity::kNone;
  vec2 heading{0, 1};      // unit, (x, z): where it looks, seen from above
  float distance_m = 6.2f;
  float height_m = 3.4f;
  float look_ahead_m = 1.2f;
};
std::string fault(const FollowCamera& camera);
SCREE_COMPONENT(FollowCamera, (target, ""), (heading, ""), (distance_m, "m"), (height_m, "m"),
                (look_ahead_m, "m"));

// The scale to fill: it weighs by the force of grains on the level's LoadSensors.
struct Scale {
  float target_kg = 1000;
  float hold_s = 1;        // the target must be shown for this long
};
std::string fault(const Scale& scale);
SCREE_COMPONENT(Scale, (target_kg, "kg"), (hold_s, "s"));

struct ScaleReading {
  float mass_kg = 0;  // smoothed
  float held_s = 0;   // for how long it has been at the target
};
std::string fault(const ScaleReading& reading);
SCREE_COMPONENT(ScaleReading, (mass_kg, "kg"), (held_s, "s"));

// A dial's needle: turns about its local +Z, from where the level has it at 0 kg.
struct Needle {
  float turn_at_target_rad = 3.14159265f;
  float most_turn_rad = 4.71238898f;  // where the dial ends
};
std::string fault(const Needle& needle);
SCREE_COMPONENT(Needle, (turn_at_target_rad, "rad"), (most_turn_rad, "rad"));

// The needle's rotation at 0 kg.
struct NeedleZero {
  quat rotation{1, 0, 0, 0};
};
std::string fault(const NeedleZero& zero);
SCREE_COMPONENT(NeedleZero, (rotation, ""));

struct LevelRules {
  float time_limit_s = 120;
};
std::string fault(const LevelRules& rules);
SCREE_COMPONENT(LevelRules, (time_limit_s, "s"));

enum class MatchState : uint32_t { Playing, Won, Lost };

// World singleton: where the match stands.
struct Match {
  MatchState state = MatchState::Playing;
  float elapsed_s = 0;  // since the start; stands still once won or lost
};
SCREE_COMPONENT(Match, (state, ""), (elapsed_s, "s"));

// World singleton: the indices of the game's actions.
struct Controls {
  ActionId move_x = 0, move_y = 0, look_x = 0;       // axes: right, forward, look right
  ActionId pause = 0, restart = 0, quit = 0, inspect = 0;  // buttons
};

// Declares the actions with their default keys and sets Controls.
void declareActions(App& app);

// Loads the level and registers the systems that act before the grains: hourglass.control (Input:
// pause, restart, quit), creature.walk, creature.look (Simulate).
Status addRules(App& app, const std::filesystem::path& level);
// Registers the systems that act after the grains: match.judge, scale.turn_needle (Simulate),
// hourglass.hud (Animate).
void addJudge(App& app);

// The match in a line: "won: 1204 kg of 1000 kg after 63.2 s".
std::string describeMatch(World& world);

}  // namespace scree::hourglass
