// Instances of opaque meshes. Defines as in opaque.frag.
#include "shared/mesh_instance.h"
#include "shared/view.h"

layout(location = kPositionAttribute) in vec3 position;
layout(location = kNormalAttribute) in vec3 normal;
#ifdef NORMAL_MAP
layout(location = kTangentAttribute) in vec4 tangent;
#endif
#ifdef TEXTURED
layout(location = kUvAttribute) in vec2 uv;
#endif
// MeshInstanceRecord.
layout(location = kFirstFreeAttribute) in vec4 relative_from_local[3];
#ifdef MOTION
layout(location = kFirstFreeAttribute + 3) in vec4 previous_relative_from_local[3];
#endif
layout(location = kFirstFreeAttribute + 6) in uvec2 id_mirrored;

out vec3 normal_ws;
#ifdef MOTION
out vec3 previous_clip;  // x, y, w
#endif
#ifdef NORMAL_MAP
out vec4 tangent_ws;
#endif
#ifdef TEXTURED
out vec2 uv_out;
#endif
flat out uint id;
flat out uint mirrored;

vec3 place(vec4 rows[3], vec4 p) { return vec3(dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)); }

void main() {
  vec4 rows[3] = relative_from_local;
  vec4 local = vec4(position, 1.0);
  gl_Position = view.clip_from_relative * vec4(place(rows, local), 1.0);
#ifdef MOTION
  previous_clip = (view.previous_clip_from_relative *
                   vec4(place(previous_relative_from_local, local), 1.0)).xyw;
#endif
  id = id_mirrored.x;
  mirrored = id_mirrored.y;

  // The inverse transpose up to a positive factor: cofactors, with the determinant's sign.
  vec3 x = rows[0].xyz, y = rows[1].xyz, z = rows[2].xyz;
  vec3 n = vec3(dot(cross(y, z), normal), dot(cross(z, x), normal), dot(cross(x, y), normal));
  normal_ws = normalize(mirrored != 0u ? -n : n);
#ifdef NORMAL_MAP
  tangent_ws = vec4(normalize(place(rows, vec4(tangent.xyz, 0.0))),
                    mirrored != 0u ? -tangent.w : tangent.w);
#endif
#ifdef TEXTURED
  uv_out = uv;
#endif
}
