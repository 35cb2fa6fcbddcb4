// GL objects as movable values that own what they name: buffers, textures, samplers, framebuffers,
// vertex arrays. All calls are direct-state-access. An object made without arguments is empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "engine/core/math.h"
#include "engine/core/result.h"

namespace scree::gpu {

// Immutable storage of fixed size; uploads are allowed at any time.
class Buffer {
 public:
  Buffer() = default;
  // `bytes` > 0. Contents are undefined if `data` is null.
  Buffer(std::string_view label, size_t bytes, const void* data = nullptr);
  template <class T>
  Buffer(std::string_view label, std::span<const T> data)
      : Buffer(label, data.size_bytes(), data.data()) {}
  ~Buffer();
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }

  explicit operator bool() const { return id_ != 0; }
  unsigned id() const { return id_; }
  size_t bytes() const { return bytes_; }

  // Ends the program if the range does not fit.
  void upload(const void* data, size_t bytes, size_t offset = 0);
  template <class T>
  void upload(std::span<const T> data, size_t offset = 0) {
    upload(data.data(), data.size_bytes(), offset);
  }
  // Fills the whole buffer with copies of one 32-bit word.
  void fill(uint32_t word);

  // `bytes` 0: to the end. Offsets must be multiples of limits().uniform_alignment or
  // storage_alignment.
  void bindUniform(unsigned binding, size_t offset = 0, size_t bytes = 0) const;
  void bindStorage(unsigned binding, size_t offset = 0, size_t bytes = 0) const;

 private:
  void swap(Buffer& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(bytes_, other.bytes_);
  }
  unsigned id_ = 0;
  size_t bytes_ = 0;
};

// Makes `buffer` hold at least `bytes`: if it is too small, it is replaced by one of twice the size
// or more; then true is returned and the contents are undefined.
bool reserve(Buffer& buffer, std::string_view label, size_t bytes);

enum class Filter : uint8_t {
  Nearest,
  Linear,
  NearestMip,  // linear within the nearest mip level
  Mipmap,      // trilinear
};
enum class Wrap : uint8_t { Clamp, Repeat, Mirror, Border };  // Border: zeros

struct Sampling {
  Filter filter = Filter::Nearest;
  Wrap wrap = Wrap::Clamp;
  // Depth comparison for shadow samplers, reversed-Z: 1 where the reference >= the stored depth.
  bool shadow = false;
  float anisotropy = 1;  // used with Filter::Mipmap where the driver can
};

enum class TextureKind : uint8_t { Flat, Array, Cube, Volume };

struct TextureDesc {
  unsigned format = 0;  // sized internal format, e.g. GL_RGBA8; see format.h
  ivec2 size{0, 0};     // texels
  int levels = 1;       // mip levels; 0: the full chain
  int layers = 1;       // of an Array; depth of a Volume
  TextureKind kind = TextureKind::Flat;
  Sampling sampling;  // used where no Sampler is bound to the unit
};

class Texture {
 public:
  Texture() = default;
  Texture(std::string_view label, const TextureDesc& desc);
  ~Texture();
  Texture(Texture&& other) noexcept { swap(other); }
  Texture& operator=(Texture&& other) noexcept {
    swap(other);
    return *this;
  }

  explicit operator bool() const { return id_ != 0; }
  unsigned id() const { return id_; }
  const TextureDesc& desc() const { return desc_; }  // `levels` resolved
  ivec2 size(int level = 0) const;
  size_t bytes() const { return bytes_; }

  // One whole level of one layer (face of a Cube, slice of a Volume). `channels` and the type of
  // the pixels are given by the overload; rows are bottom-up and tightly packed. Ends the program
  // if `bytes` is not what the level needs.
  void upload(std::span<const uint8_t> pixels, int channels, int level = 0, int layer = 0);
  void upload(std::span<const float> pixels, int channels, int level = 0, int layer = 0);
  void upload(std::span<const uint32_t> pixels, int channels, int level = 0, int layer = 0);
  void generateMips();
  // Sets every texel of a level; converted to the format's component type.
  void clear(vec4 value, int level = 0);
  void setSampling(const Sampling& sampling);

  void bind(unsigned unit) const;
  // All layers of one level; `access` is GL_READ_ONLY, GL_WRITE_ONLY or GL_READ_WRITE. `format` 0:
  // the texture's own.
  void bindImage(unsigned unit, unsigned access, int level = 0, unsigned format = 0) const;

 private:
  void swap(Texture& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(desc_, other.desc_);
    std::swap(bytes_, other.bytes_);
  }
  void uploadRaw(const void* pixels, size_t count, int channels, unsigned type, size_t type_bytes,
                 int level, int layer);
  unsigned id_ = 0;
  TextureDesc desc_;
  size_t bytes_ = 0;
};

// A texture of one texel, made on first use, to bind where a shader declares a sampler that the
// scene has nothing for: an unbound sampler is an error, and a crash in llvmpipe.
// Values: zeros in all channels, or `white`: ones (only for Component::Float formats).
const Texture& zeroTexture(unsigned like_format, TextureKind kind = TextureKind::Flat);
const Texture& whiteTexture();
void bindTexture(unsigned unit, const Texture& texture);

class Sampler {
 public:
  Sampler() = default;
  Sampler(std::string_view label, const Sampling& sampling);
  ~Sampler();
  Sampler(Sampler&& other) noexcept { swap(other); }
  Sampler& operator=(Sampler&& other) noexcept {
    swap(other);
    return *this;
  }
  unsigned id() const { return id_; }
  // Overrides the sampling of the texture in that unit until unbindSampler().
  void bind(unsigned unit) const;

 private:
  void swap(Sampler& other) noexcept { std::swap(id_, other.id_); }
  unsigned id_ = 0;
};
void unbindSampler(unsigned unit);
// Of every unit; Frame calls it before each pass, so that none leaks into the next.
void unbindSamplers();

class Framebuffer {
 public:
  Framebuffer() = default;
  explicit Framebuffer(std::string_view label);
  ~Framebuffer();
  Framebuffer(Framebuffer&& other) noexcept { swap(other); }
  Framebuffer& operator=(Framebuffer&& other) noexcept {
    swap(other);
    return *this;
  }

  explicit operator bool() const { return id_ != 0; }
  unsigned id() const { return id_; }

  // The next color attachment: 0, 1, ... `layer` < 0: all layers (layered rendering).
  void attachColor(const Texture& texture, int level = 0, int layer = -1);
  // Leaves the next color attachment out: what is drawn to it goes nowhere.
  void skipColor();
  void attachDepth(const Texture& texture, int level = 0, int layer = -1);
  // To be called after the last attachment: sets the draw buffers; an error names what is wrong.
  Status finish();
  int colorCount() const { return color_count_; }

  // Binds it for drawing; the viewport is not touched.
  void bind() const;
  // Whatever write masks and scissor are set, they are put back afterwards.
  void clearColor(int index, vec4 value) const;
  void clearColor(int index, uvec4 value) const;
  void clearDepth(float value = 0.0f) const;

 private:
  int nextColor();  // ends the program if there are too many
  void swap(Framebuffer& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(color_count_, other.color_count_);
    std::swap(skipped_, other.skipped_);
  }
  unsigned id_ = 0;
  int color_count_ = 0;      // skipped ones included
  unsigned skipped_ = 0;     // one bit a color attachment
};
// The window's framebuffer.
void bindWindow();
// Copies level 0 of `texture` to the window's framebuffer, scaled with linear filtering if the
// sizes differ.
void copyToWindow(const Texture& texture, ivec2 window_size);

class VertexArray {
 public:
  VertexArray() = default;
  explicit VertexArray(std::string_view label);
  ~VertexArray();
  VertexArray(VertexArray&& other) noexcept { swap(other); }
  VertexArray& operator=(VertexArray&& other) noexcept {
    swap(other);
    return *this;
  }

  explicit operator bool() const { return id_ != 0; }
  unsigned id() const { return id_; }

  // Attribute `location` = `components` values of `type` (GL_FLOAT, GL_UNSIGNED_BYTE, ...) at
  // `offset` bytes in an element of vertex buffer `slot`.
  void attribute(unsigned location, int components, unsigned type, unsigned offset,
                 unsigned slot = 0, bool normalized = false);
  void attributeInteger(unsigned location, int components, unsigned type, unsigned offset,
                        unsigned slot = 0);
  // `divisor` 0: an element a vertex; n: an element every n instances.
  void vertexBuffer(unsigned slot, const Buffer& buffer, unsigned stride, size_t offset = 0,
                    unsigned divisor = 0);
  void vertexBuffer(unsigned slot, unsigned buffer_id, unsigned stride, size_t offset = 0,
                    unsigned divisor = 0);
  void indexBuffer(const Buffer& buffer);
  void indexBuffer(unsigned buffer_id);
  void bind() const;

 private:
  void swap(VertexArray& other) noexcept { std::swap(id_, other.id_); }
  unsigned id_ = 0;
};

}  // namespace scree::gpu
