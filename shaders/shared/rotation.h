// Vectors turned by quaternions.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// q: unit quaternion x, y, z, w.
RULE vec3 rotateBy(vec4 q, vec3 v) {
  vec3 u = vec3(q.x, q.y, q.z);
  vec3 t = cross(u, v) * 2.0f;
  return v + t * q.w + cross(u, t);
}

RULES_END
