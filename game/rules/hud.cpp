// Mass and time above, state in the middle, keys below.
#include "game/rules/hud.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "game/rules/rules.h"
#include "modules/overlay/overlay.h"

namespace scree::hourglass {
namespace {

constexpr vec4 kPlain{0.96f, 0.93f, 0.86f, 1}, kGood{0.62f, 0.93f, 0.52f, 1}, kBad{1, 0.52f, 0.4f, 1};
// Below this many seconds the clock turns red.
constexpr float kHurry = 10;

// Formats into memory of its own, so that a frame allocates nothing.
template <class... T>
std::string_view line(fmt::format_string<T...> format, T&&... args) {
  static std::array<char, 128> text;
  const auto end = fmt::format_to_n(text.data(), text.size(), format, std::forward<T>(args)...);
  return {text.data(), std::min(end.size, text.size())};
}

void show(World& world) {
  OverlayText& text = world.singleton<OverlayText>();
  text.clear();
  const Match& match = world.singleton<const Match>();
  world.query<const Scale, const ScaleReading>().each(
      [&](const Scale& scale, const ScaleReading& reading) {
        // Rounded down: the target shows only when it is reached.
        text.add(line("{:.0f} / {:.0f} kg", std::floor(reading.mass_kg), scale.target_kg), Anchor::TopLeft, 1,
                 reading.mass_kg >= scale.target_kg ? kGood : kPlain);
      });
  world.query<const LevelRules>().each([&](const LevelRules& rules) {
    const float left = std::max(0.0f, rules.time_limit_s - match.elapsed_s);
    // Rounded up: it shows 0 only when the time is up.
    const int tenths = static_cast<int>(std::ceil(left * 10 - 1e-3f));
    text.add(line("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10), Anchor::TopRight, 1,
             left < kHurry ? kBad : kPlain);
  });
  if (match.state == MatchState::Won) text.add("WON", Anchor::TopCenter, 2, kGood);
  if (match.state == MatchState::Lost) text.add("TIME IS UP", Anchor::TopCenter, 2, kBad);
  if (world.singleton<const Simulation>().paused) text.add("PAUSED", Anchor::Center, 2, kPlain);
  if (match.state != MatchState::Playing)
    text.add("R plays again", Anchor::BottomCenter, 1, kPlain);
  else if (match.elapsed_s < 8)
    text.add("Push the grains onto the scale: W A S D, Q E turn the view", Anchor::BottomCenter, 1, kPlain);
}

}  // namespace

void addHud(App& app) {
  World& world = app.world();
  app.addSystem({.name = "hourglass.hud",
                 .phase = Phase::Animate,
                 .needs = [q = world.query<const Scale>()] { return !q.empty(); },
                 .run = show});
}

}  // namespace scree::hourglass
