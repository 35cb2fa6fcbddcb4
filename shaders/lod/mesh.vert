// Grains that are drawn as meshes: the instance is the grain's number.
#define SWARM_LISTED
#include "lib/swarm.glsl"

layout(location = kPositionAttribute) in vec3 position;
layout(location = kNormalAttribute) in vec3 normal;
layout(location = kUvAttribute) in vec2 uv;
layout(location = kFirstFreeAttribute) in uint grain;

out vec3 normal_ws;
out vec2 uv_out;
flat out uint look;
flat out uint id;
flat out uint number;  // over all that is drawn, + 1
#ifdef MOTION
out vec3 previous_clip;  // x, y, w
#endif

void main() {
  SwarmRecord record = records[grain];
  vec4 rotation = unpackRotation(record.rotation);
  vec3 local = (position - swarm.center_scale.xyz) * (swarm.center_scale.w * radiusOf(record));
  vec3 turned = rotateBy(rotation, local);
  gl_Position = view.clip_from_relative * vec4(centerOf(record) + turned, 1.0);
#ifdef MOTION
  vec3 previous = swarm.previous_origin.xyz + vec3(record.x, record.y, record.z) + turned;
  previous_clip = (view.previous_clip_from_relative * vec4(previous, 1.0)).xyw;
#endif
  normal_ws = rotateBy(rotation, normal);
  uv_out = uv;
  look = record.look;
  id = idOf(grain);
  number = swarm.first + grain + 1u;
}
