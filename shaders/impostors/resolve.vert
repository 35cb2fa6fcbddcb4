// The marked tiles of the picture, and constants: fragment programs of llvmpipe read these faster than uniforms.
#include "lib/swarm.glsl"
#include "lib/tiles.glsl"
#include "impostors/atlas.glsl"

flat out vec4 swarm_origin;
flat out uvec4 swarm_numbers;  // first, count, first id, what the next grain's id is more
flat out vec3 proxy_center, proxy_diagonal, proxy_upper;
flat out ivec2 edge_texels;
flat out vec3 half_pixels_near;  // half_over_extent, pixels_at_1m, near_m
flat out vec3 forward;           // along this distances are measured

void main() {
  placeTile();
  swarm_origin = swarm.origin;
  swarm_numbers = uvec4(swarm.first, swarm.count, swarm.first_id, swarm.same_id == 0u ? 1u : 0u);
  proxy_center = atlas.proxy.center.xyz;
  proxy_diagonal = atlas.proxy.diagonal.xyz;
  proxy_upper = atlas.proxy.upper.xyz;
  edge_texels = ivec2(atlas.edge, atlas.texels);
  half_pixels_near = vec3(atlas.half_over_extent, view.pixels_at_1m, view.near_m);
  mat4 clip = view.clip_from_relative;
  forward = vec3(clip[0].w, clip[1].w, clip[2].w);
}
