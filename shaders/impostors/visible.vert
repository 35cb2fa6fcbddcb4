// The triangle around the silhouette of each listed grain's ellipsoid, and which views it shows.
#define SWARM_LISTED
#include "lib/mark_tiles.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"
#include "impostors/guard.glsl"
#include "shared/coverage.h"

out vec3 on_disc;
out vec3 point;        // grain's space
flat out vec3 eye;     // grain's space
flat out vec4 weight_steps;  // of the views; w: coverageSteps()
// A point's place in the views' images, from their middle, in these steps; w: coverageFrom().
flat out vec4 right0, up0, right1, up1, right2, up2;
// Fragment programs of llvmpipe read these faster than uniforms.
flat out vec3 proxy_center, proxy_diagonal, proxy_upper;
flat out uint number;  // over all that is drawn, + 1

// Pixels around which the box around the sphere may show.
void markSphere(vec3 center, float radius) {
  vec3 clip = (view.clip_from_relative * vec4(center, 1.0)).xyw;
  vec2 half_size = view.size_px * 0.5, reach = radius * vec2(1.0 / view.tan_half_fov_x, 1.0 / view.tan_half_fov_y);
  vec2 low = clip.xy - reach, high = clip.xy + reach;
  float nearest = clip.z - radius, farthest = clip.z + radius;
  if (nearest < view.near_m) {
    markTiles(ivec2(0), ivec2(view.size_px));
    return;
  }
  low /= mix(vec2(nearest), vec2(farthest), greaterThan(low, vec2(0.0)));
  high /= mix(vec2(farthest), vec2(nearest), greaterThan(high, vec2(0.0)));
  markTiles(ivec2((max(low, -1.0) + 1.0) * half_size) - 1, ivec2((min(high, 1.0) + 1.0) * half_size) + 1);
}

void setView(vec3 axis, uint layer, int level, float steps, out vec4 right, out vec4 up) {
  ImpostorBasis basis = impostorBasis(axis);
  vec2 from = coverageFrom(atlas.texels, int(layer), level);
  right = vec4(basis.right * atlas.half_over_extent * steps, from.x);
  up = vec4(basis.up * atlas.half_over_extent * steps, from.y);
}

void main() {
  uint grain = list[gl_VertexID / 3];
  SwarmRecord record = records[grain];
  vec3 center = centerOf(record);
  float radius = radiusOf(record);
  vec4 rotation = unpackRotation(record.rotation);
  vec3 to_eye = toGrain(rotation, -center) * (1.0 / radius);
  EllipsoidCorner corner = ellipsoidCorner(ellipsoidSeenFrom(swarm.bound, to_eye), to_eye, discCorner(uint(gl_VertexID % 3)));
  on_disc = corner.on_disc;
  gl_Position = guarded(view.clip_from_relative * vec4(center + rotateBy(rotation, corner.point) * radius, 1.0));
  if (gl_VertexID % 3 == 0) markSphere(center, radius * max(swarm.bound.center.w, 1.0));
  // The eye is in the grain, or there is none.
  if (!(dot(to_eye, to_eye) > 1.0 && radius > 0.0)) gl_Position = nowhere();

  ImpostorViews views = impostorViews(to_eye, atlas.edge);
  float diameter_px = 2.0 * sizePx(radius, length(center), view.pixels_at_1m);
  point = corner.point;
  eye = to_eye;
  int level = impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias);
  float steps = coverageSteps(atlas.texels, level);
  weight_steps = vec4(views.weight, steps);
  setView(views.axis0, views.layer0, level, steps, right0, up0);
  setView(views.axis1, views.layer1, level, steps, right1, up1);
  setView(views.axis2, views.layer2, level, steps, right2, up2);
  proxy_center = atlas.proxy.center.xyz;
  proxy_diagonal = atlas.proxy.diagonal.xyz;
  proxy_upper = atlas.proxy.upper.xyz;
  number = swarm.first + grain + 1u;
}
