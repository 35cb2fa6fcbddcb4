// When grains fall asleep, and what wakes them.
//
// A grain is still while it stays within a hundredth of its radius of where its rest began and its
// spin is slow. It falls asleep when it and all that it leans on have been still for kFallAsleep and
// the impulses on it cancel its weight. Asleep it is an unmoving neighbour to those awake, and the
// impulses between sleepers change only with what those awake press on them: see balance.cpp. It wakes
// when its contacts cannot bear that within friction, when it is about to be struck, when a collider that
// moves or goes away touches it, when a grain that pressed on it is removed, when gravity or the tick
// changes, and when its row is written to. All of this is decided grain by grain: a heap sleeps and wakes in parts.
#pragma once

#include <cstddef>

#include "modules/grains/grains.h"

namespace scree::grains {

inline constexpr float kFallAsleep = 0.5f;  // s
// Grains fall asleep when they are at least one in so many of those awake: each time costs a search.
inline constexpr size_t kTogether = 64;
// Ticks from one change of who sleeps to the next, unless a search is due anyhow: what a heap does as it comes to
// rest would else cost a search in every tick. Who is struck or left in the air wakes at once, unless they
// are fewer than one in kFew of those awake.
inline constexpr int kCalm = 4;
inline constexpr size_t kFew = 1024;
inline constexpr float kStillWay = 0.01f;      // radii
inline constexpr float kStillSpeed = 0.05f;    // m/s, of the grain and of its surface
// A faster approach wakes a sleeper before it is struck.
inline constexpr float kStrike = 0.1f;  // m/s
// Impulse left over on a grain, as a share of its weight's, and in addition as a share of the sum of the
// impulses that it passes on: at most to fall asleep, and before the contacts of a sleeper are changed.
inline constexpr float kBalanced = 0.1f, kUneasy = 0.1f;
inline constexpr float kBalancedShare = 0.02f, kUneasyShare = 0.05f;
// More than this share of its weight and of what it passes on is a blow: that wakes it.
inline constexpr float kBlow = 0.5f;
// So much of its weight left over, and more than a blow of all that presses on it: it is as good as in the air.
inline constexpr float kFalls = 0.9f;
// How far, in grains, a change of load spreads among sleepers within a tick.
inline constexpr int kSpread = 2;

}  // namespace scree::grains
