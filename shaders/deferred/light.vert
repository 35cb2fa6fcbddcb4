// The full-screen triangle, and what light.frag needs of the frame's blocks. As flat varyings, because
// a CPU reads what a fragment shader takes from a block once a lane: 51 components of the 60 that GL
// guarantees.
#include "lib/full_screen.glsl"
#include "shared/lighting.h"
#include "shared/shadow.h"

flat out LightingBlock lit;
flat out float near_m;
#ifdef SHADOWS
flat out vec4 shadow_rows[3];  // of shadow_from_relative
flat out vec4 shadow_axes[3];  // axis_x, axis_y, to_sun
flat out vec3 shadow_size;     // size_px, texel_m
#endif

void main() {
  coverScreen();
  lit = lighting;
  near_m = view.near_m;
#ifdef SHADOWS
  mat4 columns = transpose(shadow_view.shadow_from_relative);
  shadow_rows = vec4[3](columns[0], columns[1], columns[2]);
  shadow_axes = vec4[3](shadow_view.axis_x, shadow_view.axis_y, shadow_view.to_sun);
  shadow_size = vec3(shadow_view.size_px, shadow_view.texel_m);
#endif
}
