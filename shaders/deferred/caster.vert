// Instances of meshes as the sun sees them. Define ALPHA_MASK for materials with holes.
#include "shared/bindings.h"

layout(location = kPositionAttribute) in vec3 position;
layout(location = kFirstFreeAttribute) in vec4 clip_from_local[3];  // MeshCasterRecord
#ifdef ALPHA_MASK
layout(location = kUvAttribute) in vec2 uv;
out vec2 uv_out;
#endif

void main() {
  vec4 rows[3] = clip_from_local;
  vec4 local = vec4(position, 1.0);
  gl_Position = vec4(dot(rows[0], local), dot(rows[1], local), dot(rows[2], local), 1.0);
#ifdef ALPHA_MASK
  uv_out = uv;
#endif
}
