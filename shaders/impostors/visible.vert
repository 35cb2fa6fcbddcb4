// The triangle around the silhouette of each listed grain's ellipsoid, and which views it shows.
#define SWARM_LISTED
#include "lib/mark_tiles.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"
#include "impostors/guard.glsl"

out vec3 on_disc;
out vec3 point;        // grain's space
flat out vec3 eye;     // grain's space
flat out vec3 weight;
flat out uvec3 layer;
flat out vec3 right[3], up[3];  // a point's place in the views' images, from their middle
flat out float level;
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
  weight = views.weight;
  layer = uvec3(views.layer0, views.layer1, views.layer2);
  vec3 axis[3] = vec3[3](views.axis0, views.axis1, views.axis2);
  for (int k = 0; k < 3; ++k) {
    ImpostorBasis basis = impostorBasis(axis[k]);
    right[k] = basis.right * atlas.half_over_extent;
    up[k] = basis.up * atlas.half_over_extent;
  }
  level = float(impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias));
  number = swarm.first + grain + 1u;
}
