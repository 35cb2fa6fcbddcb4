// Running the passes that are on: targets, barriers, framebuffers, timing.
#include <algorithm>
#include <chrono>

#include "engine/core/log.h"
#include "engine/frame/frame_state.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/format.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"

namespace scree {
namespace {

int64_t nowNs() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

// Everything that a storage write may have to be made visible to.
constexpr uint32_t kAllBits = GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                              GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                              GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT |
                              GL_UNIFORM_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT |
                              GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT;

uint32_t storageBits(const FrameResource& resource) {
  // An external resource may be a buffer or an image.
  return resource.target ? GL_SHADER_IMAGE_ACCESS_BARRIER_BIT
                         : GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT;
}

uint32_t barrierBits(const FrameResource& resource, Access access) {
  switch (access) {
    case Access::Clear:
      return GL_TEXTURE_UPDATE_BARRIER_BIT |
             (resource.target ? GL_FRAMEBUFFER_BARRIER_BIT : GL_BUFFER_UPDATE_BARRIER_BIT);
    case Access::Color:
    case Access::Depth:
    case Access::DepthTest:
      return GL_FRAMEBUFFER_BARRIER_BIT;
    case Access::Sampled:
      return GL_TEXTURE_FETCH_BARRIER_BIT;
    case Access::StorageRead:
    case Access::StorageWrite:
      return storageBits(resource);
    case Access::Indirect:
      return GL_COMMAND_BARRIER_BIT;
    case Access::Vertex:
      return GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_ELEMENT_ARRAY_BARRIER_BIT;
    case Access::Uniform:
      return GL_UNIFORM_BARRIER_BIT;
  }
  return 0;
}

}  // namespace

void Frame::State::create(FrameResource& resource) {
  const TargetDesc& desc = resource.desc;
  resource.texture = gpu::Texture();  // first, so that old and new never need memory at once
  resource.texture = gpu::Texture(
      resource.name, {.format = desc.format,
                      .size = desc.fixed_size.x > 0 ? desc.fixed_size : size,
                      .levels = desc.levels,
                      .layers = desc.layers,
                      .kind = desc.layers > 1 ? gpu::TextureKind::Array : gpu::TextureKind::Flat,
                      .sampling = desc.sampling});
  // Fresh storage is undefined in GL; zeros make every run begin alike.
  for (int level = 0; level < resource.texture.desc().levels; ++level)
    resource.texture.clear(vec4(0), level);
  ++resource.created;
}

void Frame::State::resize(ivec2 output) {
  if (output == size) return;
  size = output;
  // Before what they hold: a texture lives as long as it is attached, and the framebuffer that is bound would lose it.
  for (const auto& pass : passes)
    if (pass->attached && pass->fixed_size.x == 0) pass->framebuffer = gpu::Framebuffer();
  for (FrameResource& resource : resources)
    if (resource.target && resource.desc.fixed_size.x == 0) resource.texture = gpu::Texture();
}

// Creates what the pass attaches or writes, and its framebuffer if its attachments are new ones.
void Frame::State::prepareTargets(FramePass& pass) {
  const auto drawn = [&](const FrameUse& use) {
    const FrameResource& resource = resources[use.resource];
    return isAttachment(use.access) && resource.target && (resource.depth || activity.isRead(use.resource));
  };
  // What nobody reads is not attached, unless nothing else is: a framebuffer needs something.
  const bool all = std::none_of(pass.uses.begin(), pass.uses.end(), drawn);
  uint64_t created = 0;
  bool same = static_cast<bool>(pass.framebuffer);
  for (FrameUse& use : pass.uses) {
    FrameResource& resource = resources[use.resource];
    if (!resource.target) continue;
    const bool attached = isAttachment(use.access) && (all || drawn(use));
    same &= attached == use.attached;
    use.attached = attached;
    const bool written = isWrite(use.access) && !isAttachment(use.access);
    if (!resource.texture && (attached || written)) create(resource);
    if (attached) created += resource.created;
  }
  if (!pass.attached || (same && pass.targets_created == created)) return;
  pass.framebuffer = gpu::Framebuffer(pass.desc.name);
  pass.targets_created = created;
  for (const FrameUse& use : pass.uses) {
    const FrameResource& resource = resources[use.resource];
    if (!resource.target || !isAttachment(use.access)) continue;
    if (resource.depth)
      pass.framebuffer.attachDepth(resource.texture);
    else if (use.attached)
      pass.framebuffer.attachColor(resource.texture);
    else
      pass.framebuffer.skipColor();
  }
  if (Status done = pass.framebuffer.finish(); !done.ok())
    fail(fmt::format("frame: pass '{}': {}", pass.desc.name, done.error()));
}

// One barrier for all that the pass is about to touch; none if nothing is pending.
void Frame::State::issueBarriers(const FramePass& pass) {
  uint32_t needed = 0;
  for (const FrameUse& use : pass.uses) {
    const FrameResource& resource = resources[use.resource];
    needed |= barrierBits(resource, use.access) & resource.unread_writes;
    if (use.access == Access::StorageWrite) needed |= resource.unfinished_reads;
  }
  if (needed == 0) return;
  gpu::barrier(needed);
  for (FrameResource& resource : resources) {
    resource.unread_writes &= ~needed;
    resource.unfinished_reads &= ~needed;
  }
}

void Frame::State::noteAccesses(const FramePass& pass) {
  for (const FrameUse& use : pass.uses) {
    FrameResource& resource = resources[use.resource];
    if (use.access == Access::StorageWrite)
      resource.unread_writes = kAllBits;
    else
      resource.unfinished_reads = storageBits(resource);
  }
}

void Frame::State::clearTargets(const FramePass& pass) {
  int index = 0;
  for (const FrameUse& use : pass.uses) {
    FrameResource& resource = resources[use.resource];
    const vec4 value = resource.desc.clear_value;
    switch (gpu::formatInfo(resource.desc.format).component) {
      case gpu::Component::Depth:
        pass.framebuffer.clearDepth(value.x);
        continue;
      case gpu::Component::Float:
        if (use.attached) pass.framebuffer.clearColor(index, value);
        break;
      case gpu::Component::Uint:
        if (use.attached) pass.framebuffer.clearColor(index, uvec4(value));
        break;
      case gpu::Component::Int:
        if (use.attached) resource.texture.clear(value);
        break;
    }
    ++index;
  }
}

void Frame::State::runPass(size_t index, Frame& frame, const FrameInput& input) {
  FramePass& pass = *passes[index];
  PassReport& report = reports[index];
  const gpu::DebugGroup group(pass.desc.name);
  const gpu::Counters before = gpu::counters();
  report.start_ns = nowNs();
  prepareTargets(pass);
  issueBarriers(pass);
  timers.begin(pass.timer);

  uint64_t written_created = 0;
  for (const FrameUse& use : pass.uses)
    if (isWrite(use.access)) written_created += resources[use.resource].created;
  PassContext context{frame, input};
  context.first_run_after_off =
      pass.last_run == 0 || pass.last_run + 1 != runs || pass.written_created != written_created;
  pass.written_created = written_created;
  pass.last_run = runs;

  gpu::unbindSamplers();
  if (pass.attached) {
    context.framebuffer = &pass.framebuffer;
    pass.framebuffer.bind();
    gpu::setViewport(pass.fixed_size.x > 0 ? pass.fixed_size : size);
    gpu::setScissor(std::nullopt);
    gpu::DrawState draw_state;
    draw_state.depth_test = pass.depth_tested;
    draw_state.depth_write = pass.depth_written;
    gpu::apply(draw_state);
  }
  if (pass.desc.run)
    pass.desc.run(context);
  else
    clearTargets(pass);

  timers.end(pass.timer);
  noteAccesses(pass);
  if (separate) glFlush();
  ++report.runs;
  report.cpu_ms = static_cast<double>(nowNs() - report.start_ns) * 1e-6;
  report.counters = gpu::counters() - before;
}

void Frame::State::takeTimes() {
  for (size_t i = 0; i < passes.size(); ++i) {
    reports[i].gpu_ms = timers.lastMs(passes[i]->timer);
    reports[i].gpu_start_ns = timers.lastStartNs(passes[i]->timer);
  }
}

void Frame::run(const FrameInput& input, const std::function<void()>& decided) {
  State& s = *state_;
  if (input.size.x < 1 || input.size.y < 1) {
    if (decided) decided();
    return;
  }
  ++s.runs;
  s.resize(input.size);
  s.timers.poll();
  s.takeTimes();
  decide();
  if (decided) decided();
  s.running = true;
  for (size_t i = 0; i < s.passes.size(); ++i)
    if (s.reports[i].on) s.runPass(i, *this, input);
  s.running = false;
}

void Frame::finishTimers() {
  state_->timers.finish();
  state_->takeTimes();
}

const gpu::Texture& Frame::texture(std::string_view name) const {
  State& s = *state_;
  FrameResource& resource = s.resources[s.number(name)];
  if (resource.texture) return resource.texture;
  const auto number = s.number(name);
  for (size_t i = 0; i < s.passes.size() && resource.target && s.size.x > 0; ++i) {
    const auto& uses = s.passes[i]->uses;
    const bool declares = std::any_of(uses.begin(), uses.end(),
                                      [&](const FrameUse& use) { return use.resource == number; });
    if (!declares || !s.reports[i].on) continue;
    s.create(resource);
    return resource.texture;
  }
  fail(fmt::format("frame: target '{}' does not exist: no pass that uses it has run", name));
}

void Frame::bindSampled(std::string_view name, unsigned unit) const {
  const FrameResource& resource = state_->resources[state_->number(name)];
  if (resource.texture)
    resource.texture.bind(unit);
  else
    gpu::zeroTexture(resource.desc.format,
                     resource.desc.layers > 1 ? gpu::TextureKind::Array : gpu::TextureKind::Flat)
        .bind(unit);
}

}  // namespace scree
