// Coverage of the font times the corner's color; sRGB-encoded, as the output is.
#include "shared/bindings.h"

layout(binding = kPassTextureUnit) uniform sampler2D font;

in vec2 uv;
in vec4 color;
layout(location = 0) out vec4 result;

void main() {
  result = vec4(color.rgb, color.a * texture(font, uv).r);
}
