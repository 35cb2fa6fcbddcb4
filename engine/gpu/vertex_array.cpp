// VertexArray: attribute formats and the buffers they read.
#include "engine/gpu/bound.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"

namespace scree::gpu {

VertexArray::VertexArray(std::string_view label) {
  glCreateVertexArrays(1, &id_);
  labelObject(GL_VERTEX_ARRAY, id_, label);
}

VertexArray::~VertexArray() {
  if (id_ == 0) return;
  if (bound().vertex_array == id_) bound().vertex_array = 0;
  glDeleteVertexArrays(1, &id_);
}

void VertexArray::attribute(unsigned location, int components, unsigned type, unsigned offset,
                            unsigned slot, bool normalized) {
  glEnableVertexArrayAttrib(id_, location);
  glVertexArrayAttribFormat(id_, location, components, type, normalized, offset);
  glVertexArrayAttribBinding(id_, location, slot);
}

void VertexArray::attributeInteger(unsigned location, int components, unsigned type,
                                   unsigned offset, unsigned slot) {
  glEnableVertexArrayAttrib(id_, location);
  glVertexArrayAttribIFormat(id_, location, components, type, offset);
  glVertexArrayAttribBinding(id_, location, slot);
}

void VertexArray::vertexBuffer(unsigned slot, const Buffer& buffer, unsigned stride, size_t offset,
                               unsigned divisor) {
  vertexBuffer(slot, buffer.id(), stride, offset, divisor);
}

void VertexArray::vertexBuffer(unsigned slot, unsigned buffer_id, unsigned stride, size_t offset,
                               unsigned divisor) {
  glVertexArrayVertexBuffer(id_, slot, buffer_id, static_cast<GLintptr>(offset),
                            static_cast<GLsizei>(stride));
  glVertexArrayBindingDivisor(id_, slot, divisor);
}

void VertexArray::indexBuffer(const Buffer& buffer) {
  indexBuffer(buffer.id());
}
void VertexArray::indexBuffer(unsigned buffer_id) {
  glVertexArrayElementBuffer(id_, buffer_id);
}
void VertexArray::bind() const {
  bindVertexArray(id_);
}

}  // namespace scree::gpu
