// Elements of glTF accessors. Ranges were checked by checkDocument; what the bytes say (sparse
// indices) is checked here.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "engine/assets/gltf_convert.h"

namespace scree::gltf {
namespace {

template <class T>
T load(const uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return value;
}

// glTF 2.0, 3.6.2.2: signed c / 127 and c / 32767, not below -1.
float componentFloat(const uint8_t* at, int type, bool normalized) {
  switch (type) {
    case 5120: {
      const float value = load<int8_t>(at);
      return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case 5121:
      return static_cast<float>(*at) / (normalized ? 255.0f : 1.0f);
    case 5122: {
      const float value = load<int16_t>(at);
      return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case 5123:
      return static_cast<float>(load<uint16_t>(at)) / (normalized ? 65535.0f : 1.0f);
    case 5125:
      return static_cast<float>(load<uint32_t>(at));
    default:
      return load<float>(at);
  }
}

uint32_t componentIndex(const uint8_t* at, int type) {
  switch (type) {
    case 5121:
      return *at;
    case 5123:
      return load<uint16_t>(at);
    default:
      return load<uint32_t>(at);
  }
}

const uint8_t* viewBytes(const tinygltf::Model& model, int view, size_t offset) {
  const tinygltf::BufferView& v = model.bufferViews[static_cast<size_t>(view)];
  return model.buffers[static_cast<size_t>(v.buffer)].data.data() + v.byteOffset + offset;
}

// Calls put(element, bytes) for every element, then for those that the sparse part replaces.
template <class Put>
Status visit(const tinygltf::Model& model, const tinygltf::Accessor& accessor,
             const std::string& where, Put&& put) {
  const size_t bytes =
      static_cast<size_t>(
          tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType))) *
      static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)));
  if (accessor.bufferView >= 0) {
    const size_t set = model.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
    const size_t stride = set != 0 ? set : bytes;
    const uint8_t* begin = viewBytes(model, accessor.bufferView, accessor.byteOffset);
    for (size_t i = 0; i < accessor.count; ++i) put(i, begin + i * stride);
  }
  if (!accessor.sparse.isSparse) return Done{};
  const auto& indices = accessor.sparse.indices;
  const auto& values = accessor.sparse.values;
  const uint8_t* index_at =
      viewBytes(model, indices.bufferView, static_cast<size_t>(indices.byteOffset));
  const uint8_t* value_at =
      viewBytes(model, values.bufferView, static_cast<size_t>(values.byteOffset));
  const auto step = static_cast<size_t>(componentBytes(indices.componentType));
  for (size_t i = 0; i < static_cast<size_t>(accessor.sparse.count); ++i) {
    const uint32_t element = componentIndex(index_at + i * step, indices.componentType);
    if (element >= accessor.count)
      return Error{fmt::format("{}: sparse index {} = {}; the accessor has {} elements", where, i,
                               element, accessor.count)};
    put(element, value_at + i * bytes);
  }
  return Done{};
}

}  // namespace

Result<std::vector<float>> readFloats(const tinygltf::Model& model, int index,
                                      const std::string& where) {
  const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(index)];
  const auto components =
      static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)));
  const auto size = static_cast<size_t>(componentBytes(accessor.componentType));
  std::vector<float> values(accessor.count * components, 0.0f);
  const Status visited = visit(model, accessor, where, [&](size_t element, const uint8_t* bytes) {
    for (size_t c = 0; c < components; ++c)
      values[element * components + c] =
          componentFloat(bytes + c * size, accessor.componentType, accessor.normalized);
  });
  if (!visited.ok()) return Error{visited.error()};
  return values;
}

Result<std::vector<uint32_t>> readIndices(const tinygltf::Model& model, int index,
                                          const std::string& where) {
  const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(index)];
  std::vector<uint32_t> values(accessor.count, 0);
  const Status visited = visit(model, accessor, where, [&](size_t element, const uint8_t* bytes) {
    values[element] = componentIndex(bytes, accessor.componentType);
  });
  if (!visited.ok()) return Error{visited.error()};
  return values;
}

}  // namespace scree::gltf
