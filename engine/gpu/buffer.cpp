// Buffer: creation, uploads, binding, growth.
#include <algorithm>

#include "engine/core/log.h"
#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/objects.h"

namespace scree::gpu {
namespace {

// The range [offset, offset + bytes) of a buffer, with 0 meaning "to the end"; ends the program if
// it does not fit, or if a shader could not see all of it.
size_t checkedRange(const Buffer& buffer, size_t offset, size_t bytes, size_t alignment,
                    size_t limit, const char* kind) {
  if (!buffer) fail(fmt::format("{} binding: the buffer is empty", kind));
  if (offset > buffer.bytes() || bytes > buffer.bytes() - offset || offset == buffer.bytes())
    fail(fmt::format("{} binding: {} bytes at {} of a buffer of {} bytes", kind, bytes, offset,
                     buffer.bytes()));
  if (bytes == 0) bytes = buffer.bytes() - offset;
  if (alignment != 0 && offset % alignment != 0)
    fail(fmt::format("{} binding: offset {} is no multiple of {}", kind, offset, alignment));
  if (bytes > limit)
    fail(fmt::format("{} binding: {} bytes; at most {} are visible to a shader", kind, bytes,
                     limit));
  return bytes;
}

}  // namespace

Buffer::Buffer(std::string_view label, size_t bytes, const void* data) : bytes_(bytes) {
  if (bytes == 0) fail(fmt::format("buffer '{}': 0 bytes; at least 1 is needed", label));
  glCreateBuffers(1, &id_);
  glNamedBufferStorage(id_, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
  labelObject(GL_BUFFER, id_, label);
  Counters& c = counters();
  ++c.buffers;
  c.buffer_bytes += bytes;
  c.live_buffer_bytes += bytes;
  if (data) c.bytes_uploaded += bytes;
}

Buffer::~Buffer() {
  if (id_ == 0) return;
  if (bound().indirect == id_) bound().indirect = Bound::kUnknown;
  counters().live_buffer_bytes -= bytes_;
  glDeleteBuffers(1, &id_);
}

void Buffer::upload(const void* data, size_t bytes, size_t offset) {
  if (bytes == 0) return;
  if (offset > bytes_ || bytes > bytes_ - offset)
    fail(fmt::format("upload of {} bytes at {} to a buffer of {} bytes", bytes, offset, bytes_));
  counters().bytes_uploaded += bytes;
  glNamedBufferSubData(id_, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::fill(uint32_t word) {
  if (id_ == 0) return;
  glClearNamedBufferSubData(id_, GL_R32UI, 0, static_cast<GLsizeiptr>(bytes_ / 4 * 4),
                            GL_RED_INTEGER, GL_UNSIGNED_INT, &word);
}

void Buffer::bindUniform(unsigned binding, size_t offset, size_t bytes) const {
  bytes = checkedRange(*this, offset, bytes, limits().uniform_alignment,
                       limits().uniform_block_bytes, "uniform");
  ++counters().binds;
  glBindBufferRange(GL_UNIFORM_BUFFER, binding, id_, static_cast<GLintptr>(offset),
                    static_cast<GLsizeiptr>(bytes));
}

void Buffer::bindStorage(unsigned binding, size_t offset, size_t bytes) const {
  bytes = checkedRange(*this, offset, bytes, limits().storage_alignment,
                       limits().storage_block_bytes, "storage");
  ++counters().binds;
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, id_, static_cast<GLintptr>(offset),
                    static_cast<GLsizeiptr>(bytes));
}

bool reserve(Buffer& buffer, std::string_view label, size_t bytes) {
  if (buffer && buffer.bytes() >= bytes) return false;
  buffer = Buffer(label, std::max({bytes, 2 * buffer.bytes(), size_t{16}}));
  return true;
}

}  // namespace scree::gpu
