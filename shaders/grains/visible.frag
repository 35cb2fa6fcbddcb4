// Which grain a pixel shows. Depth is the silhouette disc's: it lies inside the sphere along every
// ray, so that bodies that do not overlap hide each other as they should, and hidden fragments are
// rejected before this runs. grains.draw then writes the exact depth.
//
// The near plane cuts away what lies before it, though the disc lies behind it: NEAR_PLANE tests
// the sphere itself.
#include "shared/sphere.h"
#include "shared/view.h"

in vec2 on_disc;
flat in uint index;
#ifdef NEAR_PLANE
in vec3 relative;
flat in vec4 sphere;
#endif

layout(location = 0) out uint visible_grain;  // index + 1

void main() {
  if (dot(on_disc, on_disc) > 1.0) discard;
#ifdef NEAR_PLANE
  // gl_FragCoord.w is 1 / the disc's distance along the view axis.
  SphereHit hit = hitSphere(relative * gl_FragCoord.w, sphere.xyz, sphere.w, true);
  if (!(hit.t >= view.near_m)) discard;
#endif
  visible_grain = index + 1u;
}
