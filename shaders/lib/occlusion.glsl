// Tests spheres, and bounds of ellipsoids (shared/ellipsoid.h) and boxes, against the depth pyramid of this frame, in any
// stage of any program. The pass that uses it reads occlusion.pyramid (Access::Sampled) and calls bindPyramid(); see modules/occlusion.
#include "shared/bindings.h"
#include "shared/occlusion.h"
#include "shared/view.h"

layout(binding = kPyramidUnit) uniform sampler2D occlusion_pyramid;

bool occluded(SphereBounds bounds) {
  if (!bounds.known) return false;
  if (any(lessThan(bounds.last_px, bounds.first_px))) return true;
  PyramidFootprint f = pyramidFootprint(bounds.first_px, bounds.last_px);
  float far_low = min(texelFetch(occlusion_pyramid, f.first, f.level).r,
                      texelFetch(occlusion_pyramid, ivec2(f.last.x, f.first.y), f.level).r);
  float far_high = min(texelFetch(occlusion_pyramid, ivec2(f.first.x, f.last.y), f.level).r,
                       texelFetch(occlusion_pyramid, f.last, f.level).r);
  return bounds.depth < min(far_low, far_high);
}

// The same by up to 4 x 4 texels: for what is worth them, as runs of grains are.
bool occludedFinely(SphereBounds bounds) {
  if (!bounds.known) return false;
  if (any(lessThan(bounds.last_px, bounds.first_px))) return true;
  int level = max(pyramidFootprint(bounds.first_px, bounds.last_px).level - 1, 0);
  ivec2 first = bounds.first_px >> (level + kPyramidShift), last = bounds.last_px >> (level + kPyramidShift);
  float farthest = 1.0;
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) farthest = min(farthest, texelFetch(occlusion_pyramid, ivec2(x, y), level).r);
  return bounds.depth < farthest;
}

OcclusionView occlusionView() {
  return occlusionView(view.clip_from_relative, view.size_px, view.near_m);
}

// True only if nothing in the sphere can pass the depth test, in any pixel that it touches: of a mesh,
// a point, or anything else. Also where it touches no pixel of the screen.
bool occludedByPyramid(vec3 center_relative, float radius) {
  return occluded(sphereBounds(occlusionView(), center_relative, radius, kReachTouched, false));
}

// The same of the sphere's silhouette disc (sphereDisc() in shared/sphere.h), drawn by triangles:
// grains. Hides more: the disc lies behind the sphere's front, and fills only pixels
// whose centres it meets.
bool discOccludedByPyramid(vec3 center_relative, float radius) {
  return occluded(sphereBounds(occlusionView(), center_relative, radius, kReachCenters, true));
}
