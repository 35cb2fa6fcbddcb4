// The match: weighs the grains by the force on the scale, and judges.
#include <fmt/format.h>

#include <algorithm>

#include "game/rules/heading.h"
#include "game/rules/hud.h"
#include "game/rules/rules.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"

namespace scree::hourglass {
namespace {

// Standard gravity, by which the dial converts newtons to kilograms, m/s^2.
constexpr float kDialGravity = 9.81f;
// The dial's inertia: it shows a mean over about this time, seconds.
constexpr float kDialTime = 0.4f;

void judge(World& world) {
  const auto dt = static_cast<float>(world.singleton<const Tick>().dt_s);
  float impulse = 0;
  world.query<const LoadSensor>().each(
      [&](const LoadSensor& sensor) { impulse -= sensor.impulse.y; });
  const float mass = std::max(0.0f, impulse / (dt * kDialGravity));

  Match& match = world.singleton<Match>();
  bool filled = false;
  world.query<const Scale, ScaleReading>().each([&](const Scale& scale, ScaleReading& reading) {
    reading.mass_kg += (mass - reading.mass_kg) * std::min(1.0f, dt / kDialTime);
    const bool enough = reading.mass_kg >= scale.target_kg;
    reading.held_s = enough ? reading.held_s + dt : 0.0f;
    filled |= enough && reading.held_s >= scale.hold_s;
  });
  if (match.state != MatchState::Playing) return;
  match.elapsed_s += dt;
  if (filled) {
    match.state = MatchState::Won;
    return;
  }
  world.query<const LevelRules>().each([&](const LevelRules& rules) {
    if (match.elapsed_s >= rules.time_limit_s) match.state = MatchState::Lost;
  });
}

// Half the needle's turn in small steps, as headings turn: without transcendental functions.
quat aboutZ(float turn_rad) {
  constexpr int kSteps = 32;
  vec2 half{0, 1};  // sine and cosine of half the turn
  for (int i = 0; i < kSteps; ++i) half = turn(half, 0.5f * turn_rad / kSteps);
  return {half.y, 0, 0, half.x};
}

void turnNeedle(World& world) {
  float share = 0;
  world.query<const Scale, const ScaleReading>().each(
      [&](const Scale& scale, const ScaleReading& reading) {
        share = reading.mass_kg / std::max(scale.target_kg, 1e-3f);
      });
  world.query<const Needle, const NeedleZero, Transform>().each(
      [&](const Needle& needle, const NeedleZero& zero, Transform& transform) {
        const float most = needle.most_turn_rad;
        transform.rotation =
            zero.rotation * aboutZ(std::clamp(share * needle.turn_at_target_rad, -most, most));
      });
}

}  // namespace

std::string describeMatch(World& world) {
  const Match& match = world.singleton<const Match>();
  const char* state = match.state == MatchState::Won    ? "won"
                      : match.state == MatchState::Lost ? "lost"
                                                        : "playing";
  std::string text = fmt::format("{} after {:.1f} s", state, match.elapsed_s);
  world.query<const Scale, const ScaleReading>().each(
      [&](const Scale& scale, const ScaleReading& reading) {
        text = fmt::format("{}: {:.0f} kg of {:.0f} kg after {:.1f} s", state, reading.mass_kg,
                           scale.target_kg, match.elapsed_s);
      });
  return text;
}

void addJudge(App& app) {
  World& world = app.world();
  app.addSystem({.name = "match.judge",
                 .phase = Phase::Simulate,
                 .needs = [q = world.query<const Scale>()] { return !q.empty(); },
                 .run = judge});
  app.addSystem({.name = "scale.turn_needle",
                 .phase = Phase::Simulate,
                 .needs = [q = world.query<const Needle>()] { return !q.empty(); },
                 .run = turnNeedle});
  addHud(app);
}

}  // namespace scree::hourglass
