// What is bound in the current context, so that nothing is bound twice. Private to engine/gpu.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/gpu/format.h"
#include "engine/gpu/objects.h"

namespace scree::gpu {

// Texture units that the engine uses, at most; a larger unit number ends the program.
inline constexpr unsigned kTextureUnits = 64;

// One sampler of a program, as its source declares it.
struct SamplerSlot {
  std::string name;
  unsigned unit = 0;
  TextureKind kind = TextureKind::Flat;
  Component component = Component::Float;  // Depth counts as Float
  bool operator==(const SamplerSlot&) const = default;
};

struct BoundTexture {
  unsigned id = 0;
  TextureKind kind = TextureKind::Flat;
  Component component = Component::Float;
};

struct Bound {
  // No id of a GL object: the next bind reaches GL.
  static constexpr unsigned kUnknown = ~0u;

  unsigned program = kUnknown;
  const std::string* program_name = nullptr;
  const std::vector<SamplerSlot>* program_samplers = nullptr;
  unsigned vertex_array = kUnknown;
  unsigned framebuffer = kUnknown;
  unsigned indirect = kUnknown;
  std::array<BoundTexture, kTextureUnits> textures;
  uint64_t sampler_units = 0;     // units that may have a sampler object
  bool samplers_checked = false;  // since the last change of program or textures

  void forget();
};
Bound& bound();

void useProgram(unsigned id, const std::string* name, const std::vector<SamplerSlot>* samplers);
void bindVertexArray(unsigned id);
void bindIndirect(unsigned id);

// Objects that the library itself keeps belong to one context; these forget them.
void forgetDefaultTextures();
void forgetEmptyVertexArray();
void forgetWindowSource();

}  // namespace scree::gpu
