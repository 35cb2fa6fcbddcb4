// What the GPU was asked to do since the start: tests prove by these that an empty scene is free.
#pragma once

#include <cstdint>

namespace scree::gpu {

// Every field only grows, except the two `live_` ones.
struct Counters {
  uint64_t draws = 0;       // draw calls; one multi-draw counts once
  uint64_t dispatches = 0;  // compute dispatches
  uint64_t barriers = 0;    // memory barriers

  uint64_t programs = 0;      // programs compiled and linked, reloads included
  uint64_t reloads = 0;       // programs that took the place of older ones, or of none that compiled
  uint64_t buffers = 0;       // buffers created
  uint64_t buffer_bytes = 0;  // bytes of storage of these
  uint64_t textures = 0;      // textures created
  uint64_t texture_bytes = 0;
  uint64_t framebuffers = 0;
  uint64_t queries = 0;

  uint64_t bytes_uploaded = 0;  // CPU to GPU: uploads, initial data and stream writes
  uint64_t readbacks = 0;       // blocking reads, GPU to CPU
  uint64_t stream_waits = 0;    // times that a StreamBuffer had to wait for the GPU

  uint64_t state_changes = 0;  // GL calls that changed draw state, viewport or scissor
  uint64_t binds = 0;          // programs, vertex arrays, framebuffers, textures, buffers bound

  uint64_t live_buffer_bytes = 0;  // storage that exists now
  uint64_t live_texture_bytes = 0;
};

// Field by field; the live_ fields are those of `after`.
Counters operator-(const Counters& after, const Counters& before);

// The process's counters. Only the thread with the GL context may touch them.
Counters& counters();

}  // namespace scree::gpu
