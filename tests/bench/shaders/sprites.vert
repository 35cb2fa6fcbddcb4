// A square sprite around each grain's outer sphere, and the views that it shows.
#include "lib/swarm.glsl"
#include "impostors/atlas.glsl"

flat out vec3 center;
flat out vec4 rotation;
flat out vec3 weight;
flat out uvec3 layer;
flat out vec3 axis[3];
flat out vec2 levels;  // of shape, of color
flat out float radius;
flat out uint look;

void main() {
  SwarmRecord record = records[gl_VertexID];
  center = centerOf(record);
  radius = radiusOf(record);
  rotation = unpackRotation(record.rotation);
  look = record.look;
  gl_Position = view.clip_from_relative * vec4(center, 1.0);
  // The sphere's outline is largest along the picture's radius: at most by this much.
  float distance = length(center), slant = distance / max(gl_Position.w, view.near_m);
  float diameter_px = 2.0 * sizePx(radius, distance, view.pixels_at_1m);
  gl_PointSize = diameter_px * slant * slant + 1.0;
  if (distance <= radius) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);

  ImpostorViews views = impostorViews(toGrain(rotation, -center), atlas.edge);
  weight = views.weight;
  layer = uvec3(views.layer0, views.layer1, views.layer2);
  axis = vec3[3](views.axis0, views.axis1, views.axis2);
  levels = vec2(impostorLevel(atlas.texels, diameter_px, kImpostorShapeBias),
                impostorLevel(atlas.texels, diameter_px, kImpostorColorBias));
}
