// The triangle around each grain's disc across the light. For parallel light the disc through the
// centre casts the sphere's shadow exactly on everything that does not overlap the grain, and never
// on the grain's own lit side.
#include "shared/grain.h"
#include "shared/shadow.h"
#include "shared/sphere.h"

out vec2 on_disc;

void main() {
  on_disc = discCorner(uint(gl_VertexID % 3));
  GrainRecord grain = grains[gl_VertexID / 3];
  vec3 relative = grainCenter(grain, frame.origin.xyz, frame.alpha) +
                  grain.radius * (shadow_view.axis_x.xyz * on_disc.x + shadow_view.axis_y.xyz * on_disc.y);
  gl_Position = shadow_view.clip_from_relative * vec4(relative, 1.0);
}
