// Blocking reads through glGetTextureImage and glGetNamedBufferSubData.
#include "engine/gpu/readback.h"

#include <algorithm>

#include "engine/core/log.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/format.h"
#include "engine/gpu/gl.h"

namespace scree::gpu {
namespace {

template <class T>
std::vector<T> readTexels(const Texture& texture, int channels, int level, int layer, GLenum type) {
  const TextureDesc& desc = texture.desc();
  if (!texture) fail("readback: the texture is empty");
  const FormatInfo& info = formatInfo(desc.format);
  const int layers = desc.kind == TextureKind::Flat     ? 1
                     : desc.kind == TextureKind::Cube   ? 6
                     : desc.kind == TextureKind::Volume ? std::max(1, desc.layers >> level)
                                                        : desc.layers;
  if (channels < 1 || channels > 4 || level < 0 || level >= desc.levels || layer < 0 ||
      layer >= layers)
    fail(fmt::format(
        "readback: {} channels of level {}, layer {} of a {} texture with {} levels and "
        "{} layers",
        channels, level, layer, info.name, desc.levels, layers));
  const bool integer = info.component == Component::Int || info.component == Component::Uint;
  if (integer != (type == GL_UNSIGNED_INT) || (info.component == Component::Depth && channels != 1))
    fail(fmt::format("readback: {} texels cannot be read as {} channels of this type", info.name,
                     channels));
  constexpr GLenum kFloat[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA};
  constexpr GLenum kInteger[] = {GL_RED_INTEGER, GL_RG_INTEGER, GL_RGB_INTEGER, GL_RGBA_INTEGER};
  GLenum format = (integer ? kInteger : kFloat)[channels - 1];
  if (info.component == Component::Int) type = GL_INT;
  if (info.component == Component::Depth) format = GL_DEPTH_COMPONENT;

  const ivec2 size = texture.size(level);
  std::vector<T> texels(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) *
                        static_cast<size_t>(channels));
  ++counters().readbacks;
  glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
  glGetTextureSubImage(texture.id(), level, 0, 0, layer, size.x, size.y, 1, format, type,
                       static_cast<GLsizei>(texels.size() * sizeof(T)), texels.data());
  return texels;
}

}  // namespace

std::vector<float> readFloats(const Texture& texture, int channels, int level, int layer) {
  return readTexels<float>(texture, channels, level, layer, GL_FLOAT);
}

std::vector<uint8_t> readBytes(const Texture& texture, int channels, int level, int layer) {
  return readTexels<uint8_t>(texture, channels, level, layer, GL_UNSIGNED_BYTE);
}

std::vector<uint32_t> readUints(const Texture& texture, int channels, int level, int layer) {
  return readTexels<uint32_t>(texture, channels, level, layer, GL_UNSIGNED_INT);
}

void readBuffer(const Buffer& buffer, void* data, size_t bytes, size_t offset) {
  if (bytes == 0) return;
  if (offset > buffer.bytes() || bytes > buffer.bytes() - offset)
    fail(fmt::format("readback: {} bytes at {} of a buffer of {} bytes", bytes, offset,
                     buffer.bytes()));
  ++counters().readbacks;
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(buffer.id(), static_cast<GLintptr>(offset),
                          static_cast<GLsizeiptr>(bytes), data);
}

}  // namespace scree::gpu
