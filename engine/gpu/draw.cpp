// Counting draw calls, and the check of a program's samplers before each.
#include "engine/gpu/draw.h"

#include "engine/core/log.h"
#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"

namespace scree::gpu {
namespace {

const char* kindName(TextureKind kind) {
  constexpr const char* kNames[] = {"2D", "2D array", "cube", "3D"};
  return kNames[static_cast<size_t>(kind)];
}

Component asRead(Component component) {
  return component == Component::Depth ? Component::Float : component;
}

// An unbound sampler, or one that reads a texture of another type, is undefined behaviour (and a
// crash in llvmpipe's generated code): reported, and one texel of zeros is read instead.
void checkSamplers() {
  Bound& b = bound();
  b.samplers_checked = true;
  if (!b.program_samplers) return;
  for (const SamplerSlot& slot : *b.program_samplers) {
    const BoundTexture& texture = b.textures[slot.unit];
    const bool empty = texture.id == 0 || texture.id == Bound::kUnknown;
    if (!empty && texture.kind == slot.kind && asRead(texture.component) == slot.component)
      continue;
    constexpr const char* kComponents[] = {"float", "int", "uint", "float"};
    std::string found = "nothing is bound";
    if (!empty)
      found = fmt::format("a {} texture of {} is bound", kindName(texture.kind),
                          kComponents[static_cast<size_t>(texture.component)]);
    reportFault(
        fmt::format("program '{}': sampler '{}' of unit {} reads a {} texture of {}, but {}",
                    *b.program_name, slot.name, slot.unit, kindName(slot.kind),
                    kComponents[static_cast<size_t>(slot.component)], found));
    constexpr unsigned kLike[] = {GL_RGBA8, GL_R32I, GL_R32UI};
    bindTexture(slot.unit, zeroTexture(kLike[static_cast<size_t>(slot.component)], slot.kind));
  }
  b.samplers_checked = true;
}

// False if no program is in use, after one that did not compile.
bool ready() {
  const Bound& b = bound();
  if (b.program == 0 || b.program == Bound::kUnknown) return false;
  if (!b.samplers_checked) checkSamplers();
  return true;
}

const void* pointer(size_t offset) {
  return reinterpret_cast<const void*>(offset);
}

VertexArray& emptyVertexArray() {
  static auto* instance = new VertexArray;  // never destroyed: the context may be gone before
  return *instance;
}
void bindEmptyVertexArray() {
  if (!emptyVertexArray()) emptyVertexArray() = VertexArray("gpu.empty");
  emptyVertexArray().bind();
}

}  // namespace

void forgetEmptyVertexArray() {
  new (&emptyVertexArray()) VertexArray();
}

void drawArrays(unsigned mode, int first, int count) {
  if (count <= 0 || !ready()) return;
  ++counters().draws;
  glDrawArrays(mode, first, count);
}

void drawArraysInstanced(unsigned mode, int first, int count, int instances,
                         unsigned base_instance) {
  if (count <= 0 || instances <= 0 || !ready()) return;
  ++counters().draws;
  glDrawArraysInstancedBaseInstance(mode, first, count, instances, base_instance);
}

void drawElements(unsigned mode, int count, unsigned type, size_t offset, int base_vertex) {
  if (count <= 0 || !ready()) return;
  ++counters().draws;
  glDrawElementsBaseVertex(mode, count, type, pointer(offset), base_vertex);
}

void drawElementsInstanced(unsigned mode, int count, unsigned type, size_t offset, int instances,
                           int base_vertex, unsigned base_instance) {
  if (count <= 0 || instances <= 0 || !ready()) return;
  ++counters().draws;
  glDrawElementsInstancedBaseVertexBaseInstance(mode, count, type, pointer(offset), instances,
                                                base_vertex, base_instance);
}

void drawArraysIndirect(unsigned mode, const Buffer& buffer, size_t offset, int commands,
                        int stride) {
  if (commands <= 0 || !ready()) return;
  ++counters().draws;
  bindIndirect(buffer.id());
  glMultiDrawArraysIndirect(mode, pointer(offset), commands, stride);
}

void drawElementsIndirect(unsigned mode, unsigned type, const Buffer& buffer, size_t offset,
                          int commands, int stride) {
  if (commands <= 0 || !ready()) return;
  ++counters().draws;
  bindIndirect(buffer.id());
  glMultiDrawElementsIndirect(mode, type, pointer(offset), commands, stride);
}

void drawVertexless(unsigned mode, int count, int instances, unsigned base_instance) {
  bindEmptyVertexArray();
  if (instances == 1 && base_instance == 0)
    drawArrays(mode, 0, count);
  else
    drawArraysInstanced(mode, 0, count, instances, base_instance);
}

void drawVertexlessIndirect(unsigned mode, const Buffer& buffer, size_t offset, int commands, int stride) {
  bindEmptyVertexArray();
  drawArraysIndirect(mode, buffer, offset, commands, stride);
}

void drawFullScreen() {
  drawVertexless(GL_TRIANGLES, 3);
}

void dispatch(uint32_t x, uint32_t y, uint32_t z) {
  if (x == 0 || y == 0 || z == 0 || !ready()) return;
  const int* most = limits().work_groups;
  if (x > static_cast<uint32_t>(most[0]) || y > static_cast<uint32_t>(most[1]) ||
      z > static_cast<uint32_t>(most[2]))
    fail(fmt::format("dispatch of {}x{}x{} work groups; at most {}x{}x{} are allowed", x, y, z,
                     most[0], most[1], most[2]));
  ++counters().dispatches;
  glDispatchCompute(x, y, z);
}

void dispatchItems(uint64_t items, uint32_t group_size) {
  const uint64_t groups = items / group_size + (items % group_size != 0);
  if (groups > UINT32_MAX) fail(fmt::format("dispatch of {} work groups along x", groups));
  dispatch(static_cast<uint32_t>(groups));
}

void dispatchIndirect(const Buffer& buffer, size_t offset) {
  if (!ready()) return;
  ++counters().dispatches;
  bindIndirect(buffer.id());
  glDispatchComputeIndirect(static_cast<GLintptr>(offset));
}

void barrier(unsigned bits) {
  if (bits == 0) return;
  ++counters().barriers;
  glMemoryBarrier(bits);
}

}  // namespace scree::gpu
