// A square around each listed grain that is small on the screen: its nearest view alone, as if all rays through it
// were parallel.
#define SWARM_LISTED
#include "lib/mark_tiles.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"
#include "impostors/guard.glsl"
#include "shared/coverage.h"

flat out vec4 middle_px;  // of the grain; of its ellipsoid
flat out vec3 inside;     // of offsets from the latter, pixels: x^2, x y, y^2, summed up to 1
flat out vec4 at_of_px;   // what a pixel along x, along y adds to the place in the view's image, coverageSteps()
flat out vec3 from_steps;  // coverageFrom(); coverageSteps()
flat out uint number;     // over all that is drawn, + 1

// Pixels to a side of the square that rounding may cost.
const float kMargin = 0.0625;

void main() {
  uint grain = list[gl_VertexID];
  SwarmRecord record = records[grain];
  vec3 center = centerOf(record);
  float radius = radiusOf(record);
  vec4 rotation = unpackRotation(record.rotation);
  float along = (view.clip_from_relative * vec4(center, 1.0)).w;
  ParallelImage image = parallelImage(view.clip_from_relative, view.size_px, center, radius, rotation, swarm.bound);
  middle_px = vec4(image.middle_px, image.ellipse_px);
  inside = image.inside;
  vec2 reach = image.reach_px;
  markTiles(ivec2(clamp(middle_px.zw - reach, vec2(0.0), view.size_px)) - 1, ivec2(clamp(middle_px.zw + reach, vec2(0.0), view.size_px)) + 1);

  ImpostorViews views = impostorViews(toGrain(rotation, -center), atlas.edge);
  bool first = views.weight.x >= max(views.weight.y, views.weight.z), second = views.weight.y >= views.weight.z;
  ImpostorBasis basis = impostorBasis(first ? views.axis0 : second ? views.axis1 : views.axis2);
  float diameter_px = 2.0 * sizePx(radius, length(center), view.pixels_at_1m);
  int level = impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias);
  uint layer = first ? views.layer0 : second ? views.layer1 : views.layer2;
  from_steps = vec3(coverageFrom(atlas.texels, int(layer), level), coverageSteps(atlas.texels, level));
  at_of_px = vec4(dot(basis.right, image.along_x), dot(basis.up, image.along_x), dot(basis.right, image.along_y),
                  dot(basis.up, image.along_y)) * atlas.half_over_extent * from_steps.z;
  number = swarm.first + grain + 1u;

  // A point whose middle is not in the picture would not be drawn: one at its border, as large, is.
  vec2 at = clamp(middle_px.zw, vec2(0.0), view.size_px);
  gl_PointSize = 2.0 * (max(reach.x, reach.y) + kMargin);
  gl_Position = guarded(vec4((2.0 * at / view.size_px - 1.0) * along, view.near_m, along));
  bool shows = along > view.near_m && all(lessThan(abs(middle_px.zw - at), reach + kMargin)) && radius > 0.0;
  if (!shows) gl_Position = nowhere();
}
