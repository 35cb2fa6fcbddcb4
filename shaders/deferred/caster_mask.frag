// Holes of alpha-masked casters.
#include "shared/mesh_instance.h"

layout(std140, binding = kDrawBinding) uniform MaterialUniforms { MaterialConstants material; };
layout(binding = kBaseColorUnit) uniform sampler2D base_color_map;
in vec2 uv_out;

void main() {
  if (material.base_color.a * texture(base_color_map, uv_out).a < material.alpha_cutoff) discard;
}
