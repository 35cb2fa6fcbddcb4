// Blocking reads of textures and buffers, for capture and tests. Never for rendering: they stall.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/gpu/objects.h"

namespace scree::gpu {

// All texels of one level of one layer (face, slice): `channels` values each, rows bottom-up (row 0
// is y = 0 of GL), without padding. channels: 1 to 4; 1 for depth. Issues the memory barriers
// itself. The program ends if the format does not fit the type.
std::vector<float> readFloats(const Texture& texture, int channels, int level = 0, int layer = 0);
// Values as stored: for an sRGB format the encoded ones.
std::vector<uint8_t> readBytes(const Texture& texture, int channels, int level = 0, int layer = 0);
// For unsigned and signed integer formats; the latter as two's complement.
std::vector<uint32_t> readUints(const Texture& texture, int channels, int level = 0, int layer = 0);

void readBuffer(const Buffer& buffer, void* data, size_t bytes, size_t offset = 0);
template <class T>
std::vector<T> readBuffer(const Buffer& buffer, size_t count, size_t offset = 0) {
  std::vector<T> values(count);
  readBuffer(buffer, values.data(), count * sizeof(T), offset);
  return values;
}

}  // namespace scree::gpu
