// Draw state as one small struct; only what differs from the current state reaches GL.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/core/math.h"

namespace scree::gpu {

enum class Compare : uint8_t {
  Never,
  Less,
  Equal,
  LessEqual,
  Greater,
  NotEqual,
  GreaterEqual,
  Always
};
enum class Cull : uint8_t { None, Back, Front };  // counter-clockwise is the front
enum class Blend : uint8_t {
  None,
  Alpha,          // straight alpha over; alpha accumulates as coverage
  Premultiplied,  // premultiplied alpha over
  Add,
  Min,
  Max,
};

struct DrawState {
  bool depth_test = true;
  Compare depth_func = Compare::Greater;  // reversed-Z: nearer is greater
  bool depth_write = true;                // without the test: always written
  bool depth_clamp = false;               // shadow casters behind the near plane keep their shadow
  float bias_slope = 0;  // glPolygonOffset factor; negative pushes away in reversed-Z
  float bias_units = 0;  // glPolygonOffset units
  Cull cull = Cull::Back;
  Blend blend = Blend::None;
  int blend_attachment = -1;  // the color attachment that is blended; negative: all
  bool color_write = true;
  bool wireframe = false;
  bool program_point_size = false;

  bool operator==(const DrawState&) const = default;
};

void apply(const DrawState& state);
// The state of the last apply().
const DrawState& currentState();

struct Rect {
  ivec2 origin{0, 0};  // lower left corner, pixels
  ivec2 size{0, 0};
  bool operator==(const Rect&) const = default;
};
void setViewport(const Rect& rect);
void setViewport(ivec2 size);
Rect viewport();
// Until the next setViewport(): twice as wide and high, around the same middle, if GL can. Returns by how much to scale x
// and y of positions for that, a power of two. What then lies beyond the picture need not be clipped, if not far.
float widenViewport();
void setScissor(const std::optional<Rect>& rect);  // nullopt: off

// To be called after foreign code (an UI library's renderer) changed GL state behind our back: the
// next calls set everything anew. Programs and textures must be bound again before drawing.
void forgetState();

}  // namespace scree::gpu
