// The ring of persistently mapped regions.
#include "engine/gpu/stream.h"

#include <algorithm>
#include <utility>

#include "engine/core/log.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"

namespace scree::gpu {
namespace {

constexpr size_t alignUp(size_t value, size_t alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

// Uniform and storage ranges may begin at such offsets.
size_t bindAlignment() {
  return std::max({limits().uniform_alignment, limits().storage_alignment, size_t{16}});
}

void bindRange(GLenum target, unsigned binding, const StreamSlice& slice) {
  if (slice.bytes == 0) fail("a stream slice of 0 bytes cannot be bound");
  ++counters().binds;
  glBindBufferRange(target, binding, slice.buffer, static_cast<GLintptr>(slice.offset),
                    static_cast<GLsizeiptr>(slice.bytes));
}

}  // namespace

void StreamSlice::bindUniform(unsigned binding) const {
  bindRange(GL_UNIFORM_BUFFER, binding, *this);
}
void StreamSlice::bindStorage(unsigned binding) const {
  bindRange(GL_SHADER_STORAGE_BUFFER, binding, *this);
}

StreamBuffer::StreamBuffer(std::string label, size_t bytes)
    : label_(std::move(label)), region_bytes_(std::max<size_t>(bytes, 256)) {}

StreamBuffer::~StreamBuffer() {
  release();
}

StreamBuffer::StreamBuffer(StreamBuffer&& other) noexcept {
  *this = std::move(other);
}

StreamBuffer& StreamBuffer::operator=(StreamBuffer&& other) noexcept {
  std::swap(label_, other.label_);
  std::swap(ring_, other.ring_);
  std::swap(region_bytes_, other.region_bytes_);
  std::swap(used_, other.used_);
  std::swap(region_, other.region_);
  std::swap(fences_, other.fences_);
  std::swap(retired_, other.retired_);
  return *this;
}

void StreamBuffer::create(size_t region_bytes) {
  region_bytes_ = alignUp(region_bytes, bindAlignment());
  ring_.bytes = region_bytes_ * kRegions;
  constexpr GLbitfield kFlags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  glCreateBuffers(1, &ring_.id);
  glNamedBufferStorage(ring_.id, static_cast<GLsizeiptr>(ring_.bytes), nullptr, kFlags);
  labelObject(GL_BUFFER, ring_.id, label_);
  ring_.mapped = static_cast<std::byte*>(
      glMapNamedBufferRange(ring_.id, 0, static_cast<GLsizeiptr>(ring_.bytes), kFlags));
  if (!ring_.mapped)
    fail(fmt::format("stream buffer '{}': {} bytes cannot be mapped", label_, ring_.bytes));
  Counters& c = counters();
  ++c.buffers;
  c.buffer_bytes += ring_.bytes;
  c.live_buffer_bytes += ring_.bytes;
}

void StreamBuffer::destroy(Ring& ring) {
  if (ring.id == 0) return;
  glUnmapNamedBuffer(ring.id);
  glDeleteBuffers(1, &ring.id);
  counters().live_buffer_bytes -= ring.bytes;
  ring = Ring();
}

void StreamBuffer::release() {
  for (void*& fence : fences_) {
    if (fence) glDeleteSync(static_cast<GLsync>(fence));
    fence = nullptr;
  }
  for (Retired& old : retired_) destroy(old.ring);
  retired_.clear();
  destroy(ring_);
}

void StreamBuffer::beginFrame() {
  if (ring_.id == 0) {
    create(region_bytes_);
    used_ = 0;
    return;
  }
  void*& current = fences_[static_cast<size_t>(region_)];
  if (current) glDeleteSync(static_cast<GLsync>(current));
  current = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);

  region_ = (region_ + 1) % kRegions;
  used_ = 0;
  void*& next = fences_[static_cast<size_t>(region_)];
  if (next) {
    const GLsync fence = static_cast<GLsync>(next);
    if (glClientWaitSync(fence, 0, 0) == GL_TIMEOUT_EXPIRED) {
      ++counters().stream_waits;
      constexpr GLuint64 kSecond = 1'000'000'000;
      // A lost GPU never signals; after ten seconds torn data is the lesser evil.
      if (glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 10 * kSecond) == GL_TIMEOUT_EXPIRED)
        logError("stream buffer '{}': the GPU did not finish a frame within 10 s", label_);
    }
    glDeleteSync(fence);
    next = nullptr;
  }
  for (Retired& old : retired_)
    if (--old.frames_left == 0) destroy(old.ring);
  std::erase_if(retired_, [](const Retired& old) { return old.ring.id == 0; });
}

StreamSlice StreamBuffer::allocate(size_t bytes, size_t alignment) {
  if (ring_.id == 0) beginFrame();
  if (alignment == 0) alignment = bindAlignment();
  size_t offset = alignUp(static_cast<size_t>(region_) * region_bytes_ + used_, alignment);
  if (offset + bytes > (static_cast<size_t>(region_) + 1) * region_bytes_) {
    // Slices of this frame may be written and bound until its end, so the old ring stays for as
    // long as a region does.
    retired_.push_back({std::exchange(ring_, Ring()), kRegions});
    for (void*& fence : fences_) {
      if (fence) glDeleteSync(static_cast<GLsync>(fence));
      fence = nullptr;
    }
    region_ = 0;
    create(std::max(2 * region_bytes_, alignUp(bytes, alignment)));
    offset = 0;
  }
  used_ = offset + bytes - static_cast<size_t>(region_) * region_bytes_;
  counters().bytes_uploaded += bytes;
  return {ring_.mapped + offset, ring_.id, offset, bytes};
}

}  // namespace scree::gpu
