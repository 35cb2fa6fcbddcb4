// A square around each listed grain that is small on the screen: its nearest view alone, as if all rays through it
// were parallel.
#define SWARM_LISTED
#include "lib/mark_tiles.glsl"
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"

flat out vec4 middle_px;  // of the grain; of its ellipsoid
flat out vec3 inside;     // of offsets from the latter, pixels: x^2, x y, y^2, summed up to 1
flat out vec4 uv_of_px;   // what a pixel along x, along y adds to texture coordinates
flat out vec2 layer_level;
flat out uint number;     // over all that is drawn, + 1

// Pixels to a side of the square that rounding may cost.
const float kMargin = 0.0625;

void main() {
  uint grain = list[gl_VertexID];
  SwarmRecord record = records[grain];
  vec3 center = centerOf(record);
  float radius = radiusOf(record);
  vec4 rotation = unpackRotation(record.rotation);
  vec4 clip = view.clip_from_relative * vec4(center, 1.0);
  vec2 ndc = clip.xy / clip.w, half_size = 0.5 * view.size_px;
  middle_px.xy = (ndc + 1.0) * half_size;

  // How pixels change with a place in the grain's space: both are perpendicular to the ray through its centre.
  mat4 m = view.clip_from_relative;
  vec3 row_w = vec3(m[0][3], m[1][3], m[2][3]);
  vec2 scale = half_size * (radius / clip.w);
  vec3 along_x = toGrain(rotation, vec3(m[0][0], m[1][0], m[2][0]) - row_w * ndc.x) * scale.x;
  vec3 along_y = toGrain(rotation, vec3(m[0][1], m[1][1], m[2][1]) - row_w * ndc.y) * scale.y;
  // And a place with pixels.
  float xx = dot(along_x, along_x), xy = dot(along_x, along_y), yy = dot(along_y, along_y);
  float share = 1.0 / (xx * yy - xy * xy);
  vec3 of_x = (along_x * yy - along_y * xy) * share, of_y = (along_y * xx - along_x * xy) * share;

  Ellipsoid e = swarm.bound;
  middle_px.zw = middle_px.xy + vec2(dot(along_x, e.center.xyz), dot(along_y, e.center.xyz));
  vec3 x = vec3(dot(along_x, e.axis_a.xyz), dot(along_x, e.axis_b.xyz), dot(along_x, e.axis_c.xyz));
  vec3 y = vec3(dot(along_y, e.axis_a.xyz), dot(along_y, e.axis_b.xyz), dot(along_y, e.axis_c.xyz));
  vec3 area = cross(x, y);
  inside = vec3(dot(y, y), -2.0 * dot(x, y), dot(x, x)) / dot(area, area);
  vec2 reach = sqrt(vec2(dot(x, x), dot(y, y)));
  markTiles(ivec2(clamp(middle_px.zw - reach, vec2(0.0), view.size_px)) - 1, ivec2(clamp(middle_px.zw + reach, vec2(0.0), view.size_px)) + 1);

  ImpostorViews views = impostorViews(toGrain(rotation, -center), atlas.edge);
  bool first = views.weight.x >= max(views.weight.y, views.weight.z), second = views.weight.y >= views.weight.z;
  ImpostorBasis basis = impostorBasis(first ? views.axis0 : second ? views.axis1 : views.axis2);
  uv_of_px = vec4(dot(basis.right, of_x), dot(basis.up, of_x), dot(basis.right, of_y), dot(basis.up, of_y)) * atlas.half_over_extent;
  float diameter_px = 2.0 * sizePx(radius, length(center), view.pixels_at_1m);
  layer_level = vec2(float(first ? views.layer0 : second ? views.layer1 : views.layer2),
                     float(impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias)));
  number = swarm.first + grain + 1u;

  // A point whose middle is not in the picture would not be drawn: one at its border, and larger, is.
  vec2 at = clamp(middle_px.zw, vec2(0.0), view.size_px);
  vec2 away = abs(middle_px.zw - at);
  gl_PointSize = 2.0 * (max(reach.x, reach.y) + max(away.x, away.y) + kMargin);
  gl_Position = vec4((at / half_size - 1.0) * clip.w, clip.zw);
  // Too near to have one size, out of the picture, or of no extent.
  bool shows = clip.w - radius * max(e.center.w, 1.0) > view.near_m && all(lessThan(away, reach + kMargin)) && radius > 0.0;
  if (!shows) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}
