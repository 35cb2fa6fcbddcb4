// Draw state, viewport and scissor, cached.
#include "engine/gpu/state.h"

#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"

namespace scree::gpu {
namespace {

struct State {
  DrawState draw;
  Rect viewport;
  std::optional<Rect> scissor;
  bool draw_known = false;
  bool viewport_known = false;
  bool scissor_known = false;
};

State& state() {
  static State instance;
  return instance;
}

void enable(GLenum what, bool on) {
  on ? glEnable(what) : glDisable(what);
}

GLenum toGl(Compare compare) {
  return GL_NEVER + static_cast<GLenum>(compare);
}

void setBlend(Blend blend, int attachment) {
  enable(GL_BLEND, blend != Blend::None && attachment < 0);
  if (blend != Blend::None && attachment >= 0) glEnablei(GL_BLEND, static_cast<GLuint>(attachment));
  switch (blend) {
    case Blend::None:
      return;
    case Blend::Alpha:
      glBlendEquation(GL_FUNC_ADD);
      glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
      return;
    case Blend::Premultiplied:
      glBlendEquation(GL_FUNC_ADD);
      glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
      return;
    case Blend::Add:
      glBlendEquation(GL_FUNC_ADD);
      glBlendFunc(GL_ONE, GL_ONE);
      return;
    case Blend::Min:
      glBlendEquation(GL_MIN);
      return;
    case Blend::Max:
      glBlendEquation(GL_MAX);
      return;
  }
}

}  // namespace

void apply(const DrawState& next) {
  State& s = state();
  if (s.draw_known && s.draw == next) return;
  const DrawState& now = s.draw;
  const bool all = !s.draw_known;
  uint64_t& changes = counters().state_changes;
  auto differs = [&](bool different) { return (all || different) && ++changes; };

  if (differs(now.depth_test != next.depth_test || now.depth_write != next.depth_write)) {
    // Without the test, GL writes no depth either.
    enable(GL_DEPTH_TEST, next.depth_test || next.depth_write);
    glDepthMask(next.depth_write);
  }
  if (differs(now.depth_func != next.depth_func || now.depth_test != next.depth_test))
    glDepthFunc(next.depth_test ? toGl(next.depth_func) : static_cast<GLenum>(GL_ALWAYS));
  if (differs(now.depth_clamp != next.depth_clamp)) enable(GL_DEPTH_CLAMP, next.depth_clamp);
  if (differs(now.bias_slope != next.bias_slope || now.bias_units != next.bias_units)) {
    enable(GL_POLYGON_OFFSET_FILL, next.bias_slope != 0 || next.bias_units != 0);
    glPolygonOffset(next.bias_slope, next.bias_units);
  }
  if (differs(now.cull != next.cull)) {
    enable(GL_CULL_FACE, next.cull != Cull::None);
    if (next.cull != Cull::None) glCullFace(next.cull == Cull::Back ? GL_BACK : GL_FRONT);
  }
  if (differs(now.blend != next.blend || now.blend_attachment != next.blend_attachment))
    setBlend(next.blend, next.blend_attachment);
  if (differs(now.color_write != next.color_write)) {
    const GLboolean on = next.color_write;
    glColorMask(on, on, on, on);
  }
  if (differs(now.wireframe != next.wireframe))
    glPolygonMode(GL_FRONT_AND_BACK, next.wireframe ? GL_LINE : GL_FILL);
  if (differs(now.program_point_size != next.program_point_size))
    enable(GL_PROGRAM_POINT_SIZE, next.program_point_size);
  s.draw = next;
  s.draw_known = true;
}

const DrawState& currentState() {
  return state().draw;
}

void setViewport(const Rect& rect) {
  State& s = state();
  if (s.viewport_known && s.viewport == rect) return;
  s.viewport = rect;
  s.viewport_known = true;
  ++counters().state_changes;
  glViewport(rect.origin.x, rect.origin.y, rect.size.x, rect.size.y);
}

void setViewport(ivec2 size) {
  setViewport(Rect{ivec2(0, 0), size});
}
Rect viewport() {
  return state().viewport;
}

float widenViewport() {
  State& s = state();
  const Rect& r = s.viewport;
  if (2 * r.size.x > limits().viewport_size[0] || 2 * r.size.y > limits().viewport_size[1]) return 1;
  s.viewport_known = false;
  ++counters().state_changes;
  // Its origin may lie between pixels.
  const vec2 size(r.size), origin = vec2(r.origin) - size * 0.5f;
  glViewportIndexedf(0, origin.x, origin.y, 2 * size.x, 2 * size.y);
  return 0.5f;
}

void setScissor(const std::optional<Rect>& rect) {
  State& s = state();
  if (s.scissor_known && s.scissor == rect) return;
  if (!s.scissor_known || s.scissor.has_value() != rect.has_value())
    enable(GL_SCISSOR_TEST, rect.has_value());
  if (rect) glScissor(rect->origin.x, rect->origin.y, rect->size.x, rect->size.y);
  s.scissor = rect;
  s.scissor_known = true;
  ++counters().state_changes;
}

void forgetState() {
  State& s = state();
  s.draw_known = s.viewport_known = s.scissor_known = false;
  bound().forget();
}

}  // namespace scree::gpu
