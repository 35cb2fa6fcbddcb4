// What an image of a material holds at a point, read on the CPU as a texture unit reads it.
#pragma once

#include "engine/assets/gltf.h"
#include "engine/assets/image.h"
#include "engine/core/math.h"

namespace scree {

// Linear color and alpha of a texel, row 0 on top. One channel, or two, is grey: all three colors; the second of two and
// the fourth of four are alpha, 1 where there is none. Decoding sRGB takes exact operations only: the same bits
// everywhere. Floats that are not finite count as 0.
vec4 texelAt(const ImageData& image, int x, int y);

// At texture coordinates, wrapped as `use` says: of the texel that they lie in, and between the four around them.
// Nothing is read beyond coordinates of +-1e5. The image must not be empty.
vec4 nearestTexel(const ImageData& image, const TextureUse& use, vec2 uv);
vec4 bilinearTexel(const ImageData& image, const TextureUse& use, vec2 uv);

}  // namespace scree
