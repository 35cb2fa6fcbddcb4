// Framebuffers, and the copy to the window.
#include "engine/core/log.h"
#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/state.h"

namespace scree::gpu {
namespace {

constexpr int kMaxColors = 8;  // GL guarantees 8 attachments

const char* statusName(GLenum status) {
  switch (status) {
    case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
      return "an attachment cannot be drawn to";
    case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
      return "it has no attachment";
    case GL_FRAMEBUFFER_INCOMPLETE_LAYER_TARGETS:
      return "layered and single attachments are mixed";
    case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE:
      return "sample counts differ";
    case GL_FRAMEBUFFER_UNSUPPORTED:
      return "the driver does not support this set of formats";
    default:
      return "incomplete";
  }
}

void attach(unsigned id, GLenum point, const Texture& texture, int level, int layer) {
  if (layer < 0)
    glNamedFramebufferTexture(id, point, texture.id(), level);
  else
    glNamedFramebufferTextureLayer(id, point, texture.id(), level, layer);
}

// Clears obey write masks and scissor: opens them, and puts them back.
class OpenMasks {
 public:
  OpenMasks() {
    DrawState open = saved_;
    open.color_write = true;
    open.depth_write = true;
    apply(open);
    glDisable(GL_SCISSOR_TEST);
  }
  ~OpenMasks() {
    apply(saved_);
    if (scissor_) glEnable(GL_SCISSOR_TEST);
  }
  OpenMasks(const OpenMasks&) = delete;
  OpenMasks& operator=(const OpenMasks&) = delete;

 private:
  DrawState saved_ = currentState();
  bool scissor_ = glIsEnabled(GL_SCISSOR_TEST);
};

}  // namespace

Framebuffer::Framebuffer(std::string_view label) {
  glCreateFramebuffers(1, &id_);
  labelObject(GL_FRAMEBUFFER, id_, label);
  ++counters().framebuffers;
}

Framebuffer::~Framebuffer() {
  if (id_ == 0) return;
  if (bound().framebuffer == id_) bound().framebuffer = 0;
  glDeleteFramebuffers(1, &id_);
}

int Framebuffer::nextColor() {
  if (color_count_ >= kMaxColors)
    fail(fmt::format("framebuffer: more than {} color attachments", kMaxColors));
  return color_count_++;
}

void Framebuffer::attachColor(const Texture& texture, int level, int layer) {
  attach(id_, GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(nextColor()), texture, level, layer);
}

void Framebuffer::skipColor() {
  skipped_ |= 1u << nextColor();
}

void Framebuffer::attachDepth(const Texture& texture, int level, int layer) {
  attach(id_, GL_DEPTH_ATTACHMENT, texture, level, layer);
}

Status Framebuffer::finish() {
  GLenum buffers[kMaxColors] = {};
  for (int i = 0; i < color_count_; ++i)
    buffers[i] = skipped_ >> i & 1 ? GL_NONE : GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i);
  if (color_count_ > 0)
    glNamedFramebufferDrawBuffers(id_, color_count_, buffers);
  else
    glNamedFramebufferDrawBuffer(id_, GL_NONE);
  glNamedFramebufferReadBuffer(id_, color_count_ > 0 ? buffers[0] : GL_NONE);
  const GLenum status = glCheckNamedFramebufferStatus(id_, GL_DRAW_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return Done{};
  return Error{fmt::format("framebuffer: {} (0x{:04x})", statusName(status), status)};
}

void Framebuffer::bind() const {
  if (bound().framebuffer == id_) return;
  bound().framebuffer = id_;
  ++counters().binds;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, id_);
}

void Framebuffer::clearColor(int index, vec4 value) const {
  const OpenMasks open;
  glClearNamedFramebufferfv(id_, GL_COLOR, index, &value.x);
}

void Framebuffer::clearColor(int index, uvec4 value) const {
  const OpenMasks open;
  glClearNamedFramebufferuiv(id_, GL_COLOR, index, &value.x);
}

void Framebuffer::clearDepth(float value) const {
  const OpenMasks open;
  glClearNamedFramebufferfv(id_, GL_DEPTH, 0, &value);
}

void bindWindow() {
  if (bound().framebuffer == 0) return;
  bound().framebuffer = 0;
  ++counters().binds;
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
}

namespace {
Framebuffer& windowSource() {
  static auto* instance = new Framebuffer;  // never destroyed: the context may be gone before
  return *instance;
}
}  // namespace

void forgetWindowSource() {
  new (&windowSource()) Framebuffer();
}

void copyToWindow(const Texture& texture, ivec2 window_size) {
  if (!windowSource()) windowSource() = Framebuffer("gpu.window_source");
  const unsigned source = windowSource().id();
  glNamedFramebufferTexture(source, GL_COLOR_ATTACHMENT0, texture.id(), 0);
  const ivec2 size = texture.size();
  setScissor(std::nullopt);
  // The texture is encoded already; the window must take its values as they are.
  glDisable(GL_FRAMEBUFFER_SRGB);
  glBlitNamedFramebuffer(source, 0, 0, 0, size.x, size.y, 0, 0, window_size.x, window_size.y,
                         GL_COLOR_BUFFER_BIT, size == window_size ? GL_NEAREST : GL_LINEAR);
  glEnable(GL_FRAMEBUFFER_SRGB);
}

}  // namespace scree::gpu
