// Cached binding points.
#include "engine/gpu/bound.h"

#include "engine/core/log.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/gl.h"

namespace scree::gpu {

Bound& bound() {
  static Bound instance;
  return instance;
}

void Bound::forget() {
  *this = Bound();
  for (BoundTexture& texture : textures) texture.id = kUnknown;
  sampler_units = ~uint64_t{0};
}

void useProgram(unsigned id, const std::string* name, const std::vector<SamplerSlot>* samplers) {
  Bound& b = bound();
  b.program_name = name;
  b.program_samplers = samplers;
  if (b.program == id) return;
  b.program = id;
  b.samplers_checked = false;
  ++counters().binds;
  glUseProgram(id);
}

void bindVertexArray(unsigned id) {
  if (bound().vertex_array == id) return;
  bound().vertex_array = id;
  ++counters().binds;
  glBindVertexArray(id);
}

void bindIndirect(unsigned id) {
  if (bound().indirect == id) return;
  bound().indirect = id;
  ++counters().binds;
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, id);
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, id);
}

void bindTexture(unsigned unit, const Texture& texture) {
  if (unit >= kTextureUnits)
    fail(fmt::format("texture unit {}: at most {} are used", unit, kTextureUnits));
  if (!texture) fail(fmt::format("texture unit {}: the texture bound there is empty", unit));
  BoundTexture& slot = bound().textures[unit];
  if (slot.id == texture.id()) return;
  slot.id = texture.id();
  slot.kind = texture.desc().kind;
  slot.component = formatInfo(texture.desc().format).component;
  bound().samplers_checked = false;
  ++counters().binds;
  glBindTextureUnit(unit, texture.id());
}

}  // namespace scree::gpu
