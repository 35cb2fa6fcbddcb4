// Loads the GL functions of the current context and sets the engine's conventions.
#pragma once

#include <cstddef>
#include <string>

#include "engine/core/result.h"

namespace scree::gpu {

// Sizes that the driver sets; valid after loadFunctions().
struct Limits {
  std::string renderer;   // "llvmpipe (LLVM 15.0.6, 256 bits)"
  bool software = false;  // a CPU draws: texture filtering is dear there
  bool anisotropy = false;  // texture filtering can be anisotropic
  int texture_size = 0;   // texels along a side of a 2D texture
  int viewport_size[2] = {0, 0};  // pixels
  int array_layers = 0;
  int texture_units = 0;  // of all stages together
  int color_attachments = 0;
  size_t storage_block_bytes = 0;  // largest range of a storage block
  size_t uniform_block_bytes = 0;
  size_t storage_alignment = 0;  // of an offset at which a range is bound
  size_t uniform_alignment = 0;
  int work_groups[3] = {0, 0, 0};  // largest dispatch
  int work_group_invocations = 0;
};
const Limits& limits();

// To be called once after a context was made current, and again after a switch to another one;
// objects of an earlier context must be gone. `get` is Context::getProcAddress().Fails if
// the context is not OpenGL 4.5 core or better.
// Sets reversed-Z (clip control zero-to-one, clear depth 0), seamless cube maps, sRGB encoding on
// writes to sRGB targets, byte-aligned pixel rows; forgets all cached state. Turns debug output on
// if the context was made with the debug flag.
Status loadFunctions(void (*(*get)(const char*))());

}  // namespace scree::gpu
