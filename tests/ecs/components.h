// Component types that the ECS tests share: plain, padded, tagged, over-aligned, transient.
#pragma once

#include "engine/ecs/world.h"

namespace scree {

struct Position {
  vec3 position{0};
  float radius_m = 1;
  friend bool operator==(const Position&, const Position&) = default;
};
SCREE_COMPONENT(Position, (position, "m"), (radius_m, "m"));

struct Velocity {
  vec3 velocity{0};
  float drag = 0.5f;
  friend bool operator==(const Velocity&, const Velocity&) = default;
};
SCREE_COMPONENT(Velocity, (velocity, "m/s"), (drag, "1/s"));

enum class Mood : uint32_t { Calm, Cross };

// One field of every type, with padding between and behind them.
struct Everything {
  bool flag = false;
  int32_t i32 = 1;
  bool flags_behind = true;
  int64_t i64 = 2;
  uint32_t u32 = 3;
  uint64_t u64 = 4;
  float f32 = 5;
  double f64 = 6;
  vec2 v2{7};
  vec3 v3{8};
  vec4 v4{9};
  dvec3 d3{10};
  quat rotation{1, 0, 0, 0};
  Entity other;
  Mood mood = Mood::Cross;
  char text[13] = "twelve chars";
  std::array<float, 3> floats{1, 2, 3};
  std::array<Entity, 2> pair{};
  bool last = false;
};
SCREE_COMPONENT(Everything, (flag, ""), (i32, ""), (flags_behind, ""), (i64, ""), (u32, ""),
                (u64, ""), (f32, "kg"), (f64, "s"), (v2, ""), (v3, "m"), (v4, ""), (d3, "m"),
                (rotation, ""), (other, ""), (mood, ""), (text, ""), (floats, "N"), (pair, ""),
                (last, ""));

struct Asleep {};
SCREE_COMPONENT(Asleep);

struct Marked {};
SCREE_COMPONENT(Marked);

struct alignas(128) Wide {
  double value = 0.25;
};
SCREE_COMPONENT(Wide, (value, ""));

struct Link {
  Entity to;
  uint32_t weight = 0;
};
SCREE_COMPONENT(Link, (to, ""), (weight, "kg"));

struct Cached {
  uint32_t slot = 7;
};
SCREE_COMPONENT_TRANSIENT(Cached, (slot, ""));

struct Score {
  int64_t points = 0;
};
SCREE_COMPONENT(Score, (points, ""));

}  // namespace scree
