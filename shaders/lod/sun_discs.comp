// The large discs into the map of the sun's depth: a work group each.
#include "lib/swarm.glsl"
#include "lod/sun.glsl"
#include "lod/sun_disc.glsl"

layout(local_size_x = 128) in;

void main() { drawDisc(listed(gl_WorkGroupID.x), int(gl_LocalInvocationID.x), 128); }
