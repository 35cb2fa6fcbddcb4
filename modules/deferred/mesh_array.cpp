// Attributes of vertices and instances.
#include "modules/deferred/mesh_array.h"

#include <utility>

#include "engine/gpu/gl.h"
#include "shaders/shared/bindings.h"

namespace scree {
namespace {

constexpr unsigned kInstanceSlot = 1;

}  // namespace

MeshArray::MeshArray(std::string label, int rows, bool with_ids, size_t stride)
    : label_(std::move(label)), rows_(rows), with_ids_(with_ids), stride_(static_cast<unsigned>(stride)) {}

void MeshArray::bind(MeshStore& meshes, const gpu::StreamSlice& records) {
  meshes.vertexArray();  // uploads what is new, which may replace the pool's buffers
  if (!array_) {
    array_ = gpu::VertexArray(label_);
    auto location = static_cast<unsigned>(rules::kFirstFreeAttribute);
    unsigned offset = 0;
    for (int row = 0; row < rows_; ++row, offset += sizeof(vec4))
      array_.attribute(location++, 4, GL_FLOAT, offset, kInstanceSlot);
    if (with_ids_) array_.attributeInteger(location, 2, GL_UNSIGNED_INT, offset, kInstanceSlot);
  }
  if (pool_version_ != meshes.poolVersion()) {
    meshes.attach(array_);
    pool_version_ = meshes.poolVersion();
  }
  array_.vertexBuffer(kInstanceSlot, records.buffer, stride_, records.offset, 1);
  array_.bind();
}

}  // namespace scree
