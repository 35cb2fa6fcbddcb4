// Cohesion of two bodies that touch: how hard they hold on to each other, and how far.
//
// They part at the force 2 pi cohesion R*, R* = r1 r2 / (r1 + r2) (Derjaguin, 1934; of a wall R* = r),
// which acts against their parting only, from touch to a gap of kReach R*. So to part them takes the
// work force x kReach R*, however long a substep is.
#pragma once

#include <algorithm>
#include <cmath>

namespace scree::grains {

// Share of R*. A bridge of water breaks at about five times that.
inline constexpr float kReach = 0.02f;

// N, of two bodies of cohesions a and b, N/m, and the reduced radius R*, m.
inline float pullOf(float a, float b, float reduced) { return 6.28318531f * std::sqrt(a * b) * reduced; }
inline float reducedRadius(float a, float b) { return a * b / (a + b); }

// What a contact holds in a substep.
struct Grip {
  float impulse = 0;  // against parting, N s
  float limit = 0;    // that it adds to what presses, in Coulomb's law, N s
};

// `speed`: of parting, m/s, `before` the substep and without the contact's own impulse in it; `left`: of
// the reach, m. Between the two speeds the acceleration is even, so it is known whether the bodies
// leave the reach within the substep: the pull then lasts until they do, and takes its work. Of those
// that stay, what it cannot stop goes on apart.
inline Grip gripOf(float before, float speed, float mass, float pull, float left, float h) {
  const float most = pull * h, stops = mass * speed;
  const float from = std::max(before, 0.0f), slowing = pull / mass - (speed - from) / h;
  const float square = from * from - 2 * slowing * left;
  const float sum = from + std::sqrt(std::max(square, 0.0f));
  if (square >= 0 && 2 * left < h * sum) {
    const float impulse = 2 * pull * left / sum;
    return {impulse, impulse};
  }
  return {std::clamp(stops, 0.0f, most), most};
}

// Speed of a rebound that goes on for `rest` seconds of the substep, once the pull has slowed it on that
// way, or over the reach if it is longer.
inline float heldRebound(float speed, float mass, float pull, float reach, float rest) {
  const float lost = pull / mass * rest;
  const float slowed = speed * speed / (lost + std::sqrt(lost * lost + speed * speed));
  if (slowed * rest <= reach) return slowed;
  return std::sqrt(std::max(0.0f, speed * speed - 2 * pull / mass * reach));
}

}  // namespace scree::grains
