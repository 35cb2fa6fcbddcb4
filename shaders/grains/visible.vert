// The triangle around each grain's silhouette disc; see shared/sphere.h. With NEAR_PLANE: grains
// that may cross the near plane.
#include "shared/grain.h"
#include "shared/sphere.h"
#include "shared/view.h"

layout(std430, binding = kVisibleBinding) readonly buffer Visible { uint visible[]; };

layout(location = 0) uniform uint first;

out vec2 on_disc;
flat out uint index;
#ifdef NEAR_PLANE
out vec3 relative;
flat out vec4 sphere;
#endif

void main() {
  index = visible[first + uint(gl_VertexID / 3)];
  on_disc = discCorner(uint(gl_VertexID % 3));
  GrainRecord grain = grains[index];
  vec3 center = grainCenter(grain, frame.origin.xyz, frame.alpha);
  SphereDisc disc = sphereDisc(center, grain.radius);
#ifdef NEAR_PLANE
  sphere = vec4(center, grain.radius);
#else
  vec3 relative;
#endif
  relative = disc.center + disc.radius * (disc.axis_u * on_disc.x + disc.axis_v * on_disc.y);
  gl_Position = view.clip_from_relative * vec4(relative, 1.0);
  // The eye is in the grain: nothing to see, beyond the near plane.
  if (disc.radius == 0.0) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
