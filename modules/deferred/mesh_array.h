// The vertex array that draws batches of mesh instances: vertices of the pool, and one record an
// instance as attributes from kFirstFreeAttribute up. (A shader that indexes a storage block by the
// instance reads it once a vertex, which a CPU does one lane at a time.)
#pragma once

#include "engine/gpu/objects.h"
#include "engine/gpu/stream.h"
#include "modules/scene/scene.h"

namespace scree {

class MeshArray {
 public:
  // A record of `stride` bytes begins with `rows` vec4; after them, if `with_ids`, a uvec2.
  MeshArray(std::string label, int rows, bool with_ids, size_t stride);

  // Binds it with the records in `records`; a draw's base instance counts from the first.
  void bind(MeshStore& meshes, const gpu::StreamSlice& records);

 private:
  std::string label_;
  int rows_;
  bool with_ids_;
  unsigned stride_;
  gpu::VertexArray array_;
  uint64_t pool_version_ = 0;
};

}  // namespace scree
