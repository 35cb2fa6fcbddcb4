// The pool of all static meshes, on the CPU and on the GPU.
#include <fmt/format.h>

#include <limits>

#include "engine/core/log.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"
#include "modules/scene/scene.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scree {
namespace {

// One side of the pool on the GPU.
template <class T>
struct Pool {
  gpu::Buffer buffer;
  size_t uploaded = 0;  // elements

  // True if the buffer was replaced.
  bool upload(std::string_view label, const std::vector<T>& elements) {
    const size_t bytes = elements.size() * sizeof(T);
    const bool replaced = gpu::reserve(buffer, label, bytes);
    if (replaced) uploaded = 0;
    if (uploaded < elements.size())
      buffer.upload(std::span<const T>(elements).subspan(uploaded), uploaded * sizeof(T));
    uploaded = elements.size();
    return replaced;
  }
};

// Around the box's centre: within 1.74 of the smallest sphere, and exact for what is symmetric.
LocalBounds boundsOf(std::span<const MeshData> parts) {
  LocalBounds bounds;
  bool first = true;
  for (const MeshData& part : parts)
    for (uint32_t index : part.indices) {
      const vec3& position = part.vertices[index].position;
      bounds.min = first ? position : glm::min(bounds.min, position);
      bounds.max = first ? position : glm::max(bounds.max, position);
      first = false;
    }
  bounds.center = bounds.min + (bounds.max - bounds.min) * 0.5f;
  for (const MeshData& part : parts)
    for (uint32_t index : part.indices)
      bounds.radius =
          glm::max(bounds.radius, glm::distance(part.vertices[index].position, bounds.center));
  bounds.radius *= 1.000001f;  // rounding of centre and distances
  return bounds;
}

}  // namespace

struct MeshStore::State {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<StoredMesh> meshes;
  Pool<Vertex> vertex_pool;
  Pool<uint32_t> index_pool;
  gpu::VertexArray vertex_array;
  uint64_t pool_version = 0;

  void upload() {
    if (indices.empty()) fail("MeshStore: the store is empty, there is nothing to draw");
    const bool vertices_replaced = vertex_pool.upload("scene.vertices", vertices);
    const bool indices_replaced = index_pool.upload("scene.indices", indices);
    if (!vertices_replaced && !indices_replaced) return;
    ++pool_version;
    if (!vertex_array) vertex_array = gpu::VertexArray("scene.meshes");
    attach(vertex_array);
  }

  void attach(gpu::VertexArray& array) const {
    const auto attribute = [&](int location, int components, size_t offset) {
      array.attribute(static_cast<unsigned>(location), components, GL_FLOAT,
                      static_cast<unsigned>(offset));
    };
    attribute(rules::kPositionAttribute, 3, offsetof(Vertex, position));
    attribute(rules::kNormalAttribute, 3, offsetof(Vertex, normal));
    attribute(rules::kTangentAttribute, 4, offsetof(Vertex, tangent));
    attribute(rules::kUvAttribute, 2, offsetof(Vertex, uv));
    array.vertexBuffer(0, vertex_pool.buffer, sizeof(Vertex));
    array.indexBuffer(index_pool.buffer);
  }
};

MeshStore::MeshStore() : state_(std::make_unique<State>()) {}
MeshStore::~MeshStore() = default;
MeshStore::MeshStore(MeshStore&&) noexcept = default;
MeshStore& MeshStore::operator=(MeshStore&&) noexcept = default;

uint32_t MeshStore::add(std::string name, std::span<const MeshData> parts) {
  State& state = *state_;
  for (const MeshData& part : parts)
    for (uint32_t index : part.indices)
      if (index >= part.vertices.size())
        fail(fmt::format("MeshStore::add: mesh \"{}\": index {} of {} vertices", name, index,
                         part.vertices.size()));
  StoredMesh mesh;
  mesh.name = std::move(name);
  mesh.bounds = boundsOf(parts);
  for (const MeshData& source : parts) {
    if (state.vertices.size() + source.vertices.size() > size_t{1} << 31 ||
        state.indices.size() + source.indices.size() > size_t{1} << 32)
      fail(fmt::format("MeshStore::add: mesh \"{}\": the pool is full", mesh.name));
    MeshPart part;
    part.first_index = static_cast<uint32_t>(state.indices.size());
    part.index_count = static_cast<uint32_t>(source.indices.size());
    part.base_vertex = static_cast<int32_t>(state.vertices.size());
    part.vertex_count = static_cast<uint32_t>(source.vertices.size());
    part.material = source.material < 0 ? 0u : static_cast<uint32_t>(source.material);
    state.vertices.insert(state.vertices.end(), source.vertices.begin(), source.vertices.end());
    state.indices.insert(state.indices.end(), source.indices.begin(), source.indices.end());
    mesh.parts.push_back(part);
  }
  state.meshes.push_back(std::move(mesh));
  return static_cast<uint32_t>(state.meshes.size() - 1);
}

uint32_t MeshStore::add(const MeshData& mesh) {
  return add(mesh.name, std::span(&mesh, 1));
}

size_t MeshStore::size() const {
  return state_->meshes.size();
}

const StoredMesh& MeshStore::mesh(uint32_t handle) const {
  if (handle >= state_->meshes.size())
    fail(fmt::format("MeshStore: mesh {}; there are {}", handle, state_->meshes.size()));
  return state_->meshes[handle];
}

std::span<const Vertex> MeshStore::vertices(const MeshPart& part) const {
  return std::span<const Vertex>(state_->vertices)
      .subspan(static_cast<size_t>(part.base_vertex), part.vertex_count);
}

std::span<const uint32_t> MeshStore::indices(const MeshPart& part) const {
  return std::span<const uint32_t>(state_->indices).subspan(part.first_index, part.index_count);
}

gpu::VertexArray& MeshStore::vertexArray() {
  state_->upload();
  return state_->vertex_array;
}
void MeshStore::attach(gpu::VertexArray& array) {
  state_->upload();
  state_->attach(array);
}
const gpu::Buffer& MeshStore::vertexBuffer() {
  state_->upload();
  return state_->vertex_pool.buffer;
}
const gpu::Buffer& MeshStore::indexBuffer() {
  state_->upload();
  return state_->index_pool.buffer;
}
uint64_t MeshStore::poolVersion() const {
  return state_->pool_version;
}
bool MeshStore::onGpu() const {
  return static_cast<bool>(state_->vertex_array);
}

}  // namespace scree
