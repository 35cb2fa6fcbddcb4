// The table of texture formats.
#include "engine/gpu/format.h"

#include "engine/core/log.h"
#include "engine/gpu/gl.h"

namespace scree::gpu {
namespace {

constexpr FormatInfo kFormats[] = {
#define FORMAT(NAME, CHANNELS, BYTES, COMPONENT) \
  { GL_##NAME, #NAME, CHANNELS, BYTES, Component::COMPONENT, false }
    FORMAT(R8, 1, 1, Float),
    FORMAT(RG8, 2, 2, Float),
    FORMAT(RGB8, 3, 3, Float),
    FORMAT(RGBA8, 4, 4, Float),
    FORMAT(R8_SNORM, 1, 1, Float),
    FORMAT(RG8_SNORM, 2, 2, Float),
    FORMAT(RGBA8_SNORM, 4, 4, Float),
    FORMAT(R16, 1, 2, Float),
    FORMAT(RG16, 2, 4, Float),
    FORMAT(RGBA16, 4, 8, Float),
    FORMAT(RG16_SNORM, 2, 4, Float),
    FORMAT(RGBA16_SNORM, 4, 8, Float),
    FORMAT(R16F, 1, 2, Float),
    FORMAT(RG16F, 2, 4, Float),
    FORMAT(RGBA16F, 4, 8, Float),
    FORMAT(R32F, 1, 4, Float),
    FORMAT(RG32F, 2, 8, Float),
    FORMAT(RGB32F, 3, 12, Float),
    FORMAT(RGBA32F, 4, 16, Float),
    FORMAT(R11F_G11F_B10F, 3, 4, Float),
    FORMAT(RGB10_A2, 4, 4, Float),
    FORMAT(R8I, 1, 1, Int),
    FORMAT(R16I, 1, 2, Int),
    FORMAT(R32I, 1, 4, Int),
    FORMAT(RG32I, 2, 8, Int),
    FORMAT(RGBA32I, 4, 16, Int),
    FORMAT(R8UI, 1, 1, Uint),
    FORMAT(RG8UI, 2, 2, Uint),
    FORMAT(RGBA8UI, 4, 4, Uint),
    FORMAT(R16UI, 1, 2, Uint),
    FORMAT(RG16UI, 2, 4, Uint),
    FORMAT(RGBA16UI, 4, 8, Uint),
    FORMAT(R32UI, 1, 4, Uint),
    FORMAT(RG32UI, 2, 8, Uint),
    FORMAT(RGBA32UI, 4, 16, Uint),
    FORMAT(DEPTH_COMPONENT16, 1, 2, Depth),
    FORMAT(DEPTH_COMPONENT24, 1, 4, Depth),
    FORMAT(DEPTH_COMPONENT32F, 1, 4, Depth),
#undef FORMAT
    {GL_SRGB8, "SRGB8", 3, 3, Component::Float, true},
    {GL_SRGB8_ALPHA8, "SRGB8_ALPHA8", 4, 4, Component::Float, true},
};

}  // namespace

const FormatInfo& formatInfo(unsigned format) {
  for (const FormatInfo& info : kFormats)
    if (info.format == format) return info;
  fail(fmt::format("texture format 0x{:04x} is not in the table of engine/gpu/format.cpp", format));
}

bool isDepth(unsigned format) {
  return formatInfo(format).component == Component::Depth;
}

}  // namespace scree::gpu
