// Textures and samplers.
#include <algorithm>
#include <array>
#include <bit>

#include "engine/core/log.h"
#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/objects.h"

namespace scree::gpu {
namespace {

GLenum target(TextureKind kind) {
  switch (kind) {
    case TextureKind::Flat:
      return GL_TEXTURE_2D;
    case TextureKind::Array:
      return GL_TEXTURE_2D_ARRAY;
    case TextureKind::Cube:
      return GL_TEXTURE_CUBE_MAP;
    case TextureKind::Volume:
      return GL_TEXTURE_3D;
  }
  return GL_TEXTURE_2D;
}

GLint minFilter(Filter filter) {
  switch (filter) {
    case Filter::Nearest:
      return GL_NEAREST;
    case Filter::Linear:
      return GL_LINEAR;
    case Filter::NearestMip:
      return GL_LINEAR_MIPMAP_NEAREST;
    case Filter::Mipmap:
      return GL_LINEAR_MIPMAP_LINEAR;
  }
  return GL_NEAREST;
}

GLint wrapMode(Wrap wrap) {
  switch (wrap) {
    case Wrap::Clamp:
      return GL_CLAMP_TO_EDGE;
    case Wrap::Repeat:
      return GL_REPEAT;
    case Wrap::Mirror:
      return GL_MIRRORED_REPEAT;
    case Wrap::Border:
      return GL_CLAMP_TO_BORDER;
  }
  return GL_CLAMP_TO_EDGE;
}

// Core only from 4.6 on, but every driver of 4.5 has the extension.
constexpr GLenum kMaxAnisotropy = 0x84FE;

template <class SetInt, class SetFloat>
void setParameters(const Sampling& sampling, SetInt set_int, SetFloat set_float) {
  set_int(GL_TEXTURE_MIN_FILTER, minFilter(sampling.filter));
  set_int(GL_TEXTURE_MAG_FILTER, sampling.filter == Filter::Nearest ? GL_NEAREST : GL_LINEAR);
  set_int(GL_TEXTURE_WRAP_S, wrapMode(sampling.wrap));
  set_int(GL_TEXTURE_WRAP_T, wrapMode(sampling.wrap));
  set_int(GL_TEXTURE_WRAP_R, wrapMode(sampling.wrap));
  set_int(GL_TEXTURE_COMPARE_MODE, sampling.shadow ? GL_COMPARE_REF_TO_TEXTURE : GL_NONE);
  set_int(GL_TEXTURE_COMPARE_FUNC, GL_GEQUAL);
  if (sampling.anisotropy > 1 && limits().anisotropy) set_float(kMaxAnisotropy, sampling.anisotropy);
}

GLenum pixelFormat(const FormatInfo& info, int channels) {
  constexpr GLenum kFloat[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA};
  constexpr GLenum kInteger[] = {GL_RED_INTEGER, GL_RG_INTEGER, GL_RGB_INTEGER, GL_RGBA_INTEGER};
  if (info.component == Component::Depth) return GL_DEPTH_COMPONENT;
  return (info.component == Component::Float ? kFloat : kInteger)[channels - 1];
}

void checkDesc(std::string_view label, const TextureDesc& desc) {
  const int side = limits().texture_size;
  if (desc.size.x < 1 || desc.size.y < 1 || desc.size.x > side || desc.size.y > side)
    fail(fmt::format("texture '{}': size {}x{}; each side must be 1 to {}", label, desc.size.x,
                     desc.size.y, side));
  if (desc.layers < 1 || (desc.kind == TextureKind::Array && desc.layers > limits().array_layers))
    fail(fmt::format("texture '{}': {} layers; allowed are 1 to {}", label, desc.layers,
                     limits().array_layers));
  if (desc.layers > 1 && (desc.kind == TextureKind::Flat || desc.kind == TextureKind::Cube))
    fail(fmt::format("texture '{}': {} layers, but it is neither an Array nor a Volume", label,
                     desc.layers));
  if (desc.kind == TextureKind::Cube && desc.size.x != desc.size.y)
    fail(fmt::format("texture '{}': a cube of {}x{} texels; sides must be equal", label,
                     desc.size.x, desc.size.y));
}

}  // namespace

Texture::Texture(std::string_view label, const TextureDesc& desc) : desc_(desc) {
  checkDesc(label, desc);
  const FormatInfo& info = formatInfo(desc.format);
  int longest = std::max(desc.size.x, desc.size.y);
  if (desc.kind == TextureKind::Volume) longest = std::max(longest, desc.layers);
  const int chain = std::bit_width(static_cast<unsigned>(longest));
  desc_.levels = desc.levels == 0 ? chain : std::clamp(desc.levels, 1, chain);

  glCreateTextures(target(desc.kind), 1, &id_);
  const bool deep = desc.kind == TextureKind::Array || desc.kind == TextureKind::Volume;
  if (deep)
    glTextureStorage3D(id_, desc_.levels, desc.format, desc.size.x, desc.size.y, desc.layers);
  else
    glTextureStorage2D(id_, desc_.levels, desc.format, desc.size.x, desc.size.y);
  labelObject(GL_TEXTURE, id_, label);
  setSampling(desc.sampling);

  for (int level = 0; level < desc_.levels; ++level) {
    const ivec2 s = size(level);
    size_t layers = static_cast<size_t>(desc.layers);
    if (desc.kind == TextureKind::Cube) layers = 6;
    if (desc.kind == TextureKind::Volume) layers = std::max<size_t>(1, layers >> level);
    bytes_ += static_cast<size_t>(s.x) * static_cast<size_t>(s.y) * layers *
              static_cast<size_t>(info.bytes);
  }
  Counters& c = counters();
  ++c.textures;
  c.texture_bytes += bytes_;
  c.live_texture_bytes += bytes_;
}

Texture::~Texture() {
  if (id_ == 0) return;
  for (BoundTexture& slot : bound().textures)
    if (slot.id == id_) {
      slot = BoundTexture();
      bound().samplers_checked = false;
    }
  counters().live_texture_bytes -= bytes_;
  glDeleteTextures(1, &id_);
}

ivec2 Texture::size(int level) const {
  return {std::max(1, desc_.size.x >> level), std::max(1, desc_.size.y >> level)};
}

void Texture::uploadRaw(const void* pixels, size_t count, int channels, unsigned type,
                        size_t type_bytes, int level, int layer) {
  if (id_ == 0 || level < 0 || level >= desc_.levels || channels < 1 || channels > 4)
    fail(fmt::format("texture upload: level {}, {} channels; the texture has {} levels", level,
                     channels, desc_.levels));
  const ivec2 s = size(level);
  const size_t needed =
      static_cast<size_t>(s.x) * static_cast<size_t>(s.y) * static_cast<size_t>(channels);
  if (count != needed)
    fail(fmt::format("texture upload: {} values for {}x{} texels of {} channels", count, s.x, s.y,
                     channels));
  const GLenum format = pixelFormat(formatInfo(desc_.format), channels);
  if (desc_.kind == TextureKind::Flat)
    glTextureSubImage2D(id_, level, 0, 0, s.x, s.y, format, type, pixels);
  else
    glTextureSubImage3D(id_, level, 0, 0, layer, s.x, s.y, 1, format, type, pixels);
  counters().bytes_uploaded += needed * type_bytes;
}

void Texture::upload(std::span<const uint8_t> pixels, int channels, int level, int layer) {
  uploadRaw(pixels.data(), pixels.size(), channels, GL_UNSIGNED_BYTE, 1, level, layer);
}
void Texture::upload(std::span<const float> pixels, int channels, int level, int layer) {
  uploadRaw(pixels.data(), pixels.size(), channels, GL_FLOAT, 4, level, layer);
}
void Texture::upload(std::span<const uint32_t> pixels, int channels, int level, int layer) {
  uploadRaw(pixels.data(), pixels.size(), channels, GL_UNSIGNED_INT, 4, level, layer);
}

void Texture::generateMips() {
  if (desc_.levels > 1) glGenerateTextureMipmap(id_);
}

void Texture::clear(vec4 value, int level) {
  const Component component = formatInfo(desc_.format).component;
  if (component == Component::Int) {
    const GLint values[] = {static_cast<GLint>(value.x), static_cast<GLint>(value.y),
                            static_cast<GLint>(value.z), static_cast<GLint>(value.w)};
    glClearTexImage(id_, level, GL_RGBA_INTEGER, GL_INT, values);
  } else if (component == Component::Uint) {
    const GLuint values[] = {static_cast<GLuint>(value.x), static_cast<GLuint>(value.y),
                             static_cast<GLuint>(value.z), static_cast<GLuint>(value.w)};
    glClearTexImage(id_, level, GL_RGBA_INTEGER, GL_UNSIGNED_INT, values);
  } else if (component == Component::Depth) {
    glClearTexImage(id_, level, GL_DEPTH_COMPONENT, GL_FLOAT, &value.x);
  } else {
    glClearTexImage(id_, level, GL_RGBA, GL_FLOAT, &value.x);
  }
}

void Texture::setSampling(const Sampling& sampling) {
  desc_.sampling = sampling;
  setParameters(
      sampling, [&](GLenum name, GLint value) { glTextureParameteri(id_, name, value); },
      [&](GLenum name, float value) { glTextureParameterf(id_, name, value); });
}

void Texture::bind(unsigned unit) const {
  bindTexture(unit, *this);
}

void Texture::bindImage(unsigned unit, unsigned access, int level, unsigned format) const {
  if (id_ == 0) fail(fmt::format("image unit {}: the texture bound there is empty", unit));
  ++counters().binds;
  glBindImageTexture(unit, id_, level, desc_.kind != TextureKind::Flat, 0, access,
                     format ? format : desc_.format);
}

namespace {

// One texel of every kind and component; index kind * 4 + component. Never destroyed: the context
// may be gone before static objects are.
std::array<Texture, 17>& defaultTextures() {
  static auto* instance = new std::array<Texture, 17>;
  return *instance;
}

}  // namespace

const Texture& zeroTexture(unsigned like_format, TextureKind kind) {
  const Component component = formatInfo(like_format).component;
  Texture& texture =
      defaultTextures()[static_cast<size_t>(kind) * 4 + static_cast<size_t>(component)];
  if (!texture) {
    constexpr unsigned kFormat[] = {GL_RGBA8, GL_R32I, GL_R32UI, GL_DEPTH_COMPONENT32F};
    // Depth volumes do not exist in GL.
    const bool depth_volume = component == Component::Depth && kind == TextureKind::Volume;
    TextureDesc desc{.format = depth_volume ? GL_R32F : kFormat[static_cast<size_t>(component)],
                     .size = {1, 1},
                     .kind = kind};
    texture = Texture("gpu.zero", desc);
    texture.clear(vec4(0));
  }
  return texture;
}

const Texture& whiteTexture() {
  Texture& texture = defaultTextures()[16];
  if (!texture) {
    texture = Texture("gpu.white", {.format = GL_RGBA8, .size = {1, 1}});
    texture.clear(vec4(1));
  }
  return texture;
}

void forgetDefaultTextures() {
  // Their names belong to a context that is gone; deleting them would hit the new one's.
  for (Texture& texture : defaultTextures()) {
    counters().live_texture_bytes -= texture.bytes();
    new (&texture) Texture();
  }
}

Sampler::Sampler(std::string_view label, const Sampling& sampling) {
  glCreateSamplers(1, &id_);
  labelObject(GL_SAMPLER, id_, label);
  setParameters(
      sampling, [&](GLenum name, GLint value) { glSamplerParameteri(id_, name, value); },
      [&](GLenum name, float value) { glSamplerParameterf(id_, name, value); });
}

Sampler::~Sampler() {
  if (id_ != 0) glDeleteSamplers(1, &id_);
}

void Sampler::bind(unsigned unit) const {
  if (unit >= kTextureUnits)
    fail(fmt::format("texture unit {}: at most {} are used", unit, kTextureUnits));
  ++counters().binds;
  bound().sampler_units |= uint64_t{1} << unit;
  glBindSampler(unit, id_);
}

void unbindSampler(unsigned unit) {
  ++counters().binds;
  glBindSampler(unit, 0);
}

void unbindSamplers() {
  if (bound().sampler_units == 0) return;
  bound().sampler_units = 0;
  ++counters().binds;
  glBindSamplers(0, kTextureUnits, nullptr);
}

}  // namespace scree::gpu
