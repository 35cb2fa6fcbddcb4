// A ring of three persistently mapped regions, for data that the CPU writes anew every frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "engine/gpu/objects.h"

namespace scree::gpu {

// Part of a StreamBuffer, valid until the frame's end.
struct StreamSlice {
  void* data = nullptr;  // write-only memory: reading it is slow
  unsigned buffer = 0;
  size_t offset = 0;
  size_t bytes = 0;

  void bindUniform(unsigned binding) const;
  void bindStorage(unsigned binding) const;
};

class StreamBuffer {
 public:
  static constexpr int kRegions = 3;

  StreamBuffer() = default;
  // `bytes`: of one region; what a frame is expected to write. Nothing is created before the first
  // beginFrame().
  explicit StreamBuffer(std::string label, size_t bytes = 64 * 1024);
  ~StreamBuffer();
  StreamBuffer(StreamBuffer&& other) noexcept;
  StreamBuffer& operator=(StreamBuffer&& other) noexcept;

  // Fences what was issued since the last call and moves to the next region, waiting for the GPU
  // only if it still reads that one. Slices of the last frame are not to be written any more.
  void beginFrame();

  // Room for `bytes` at a multiple of `alignment` (0: good for uniform and storage binding). If the
  // region is full, the buffer is replaced by one of twice the size; slices given out in this frame
  // stay valid.
  StreamSlice allocate(size_t bytes, size_t alignment = 0);
  template <class T>
  StreamSlice write(std::span<const T> data, size_t alignment = 0) {
    const StreamSlice slice = allocate(data.size_bytes(), alignment);
    if (!data.empty()) std::memcpy(slice.data, data.data(), data.size_bytes());
    return slice;
  }
  template <class T>
  StreamSlice write(const T& value, size_t alignment = 0) {
    return write(std::span<const T>(&value, 1), alignment);
  }

  size_t regionBytes() const { return region_bytes_; }
  unsigned bufferId() const { return ring_.id; }

 private:
  struct Ring {
    unsigned id = 0;
    std::byte* mapped = nullptr;
    size_t bytes = 0;
  };
  struct Retired {
    Ring ring;
    int frames_left = 0;
  };
  void create(size_t region_bytes);
  static void destroy(Ring& ring);
  void release();

  std::string label_;
  Ring ring_;
  size_t region_bytes_ = 0;
  size_t used_ = 0;  // bytes of the current region
  int region_ = 0;
  std::array<void*, kRegions> fences_{};  // GLsync
  std::vector<Retired> retired_;
};

}  // namespace scree::gpu
