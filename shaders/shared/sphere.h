// A ray from the camera against a sphere, and the flat shape that covers a sphere exactly.
//
// Space: the eye at the origin ("relative", see view.h). A sphere is seen from outside only: with
// the eye in it there is no hit, as with a closed mesh whose back faces are culled.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

struct SphereHit {
  float t;      // the hit is t * ray; 0: none. The distance along the view axis if ray is 1 m along it
  vec3 normal;  // unit, outwards
};

// First intersection of the ray from the origin along `ray` (any length) with the sphere around
// `center`. The distance of the centre to the ray is taken before it is squared against the radius,
// so that small, far spheres keep their silhouette (Haines et al., "Precision Improvements for
// Ray/Sphere Intersection", Ray Tracing Gems 2019); the root is the one that does not cancel.
// `forgive`: a ray that misses hits the nearest point of the silhouette instead.
RULE SphereHit hitSphere(vec3 ray, vec3 center, float radius, bool forgive) {
  SphereHit hit;
  hit.t = 0.0f;
  hit.normal = vec3(0.0f, 0.0f, 0.0f);
  float inverse = 1.0f / dot(ray, ray);
  float along = dot(center, ray);
  vec3 off = center - ray * (along * inverse);  // from the ray's nearest point to the centre
  float chord2 = radius * radius - dot(off, off);
  float distance = sqrt(dot(center, center));
  float outside = (distance - radius) * (distance + radius);
  if (!(outside > 0.0f) || !(along > 0.0f)) return hit;
  if (!(chord2 >= 0.0f)) {
    if (!forgive) return hit;
    chord2 = 0.0f;
  }
  float half_chord = sqrt(chord2 * inverse);  // in units of the ray
  hit.t = outside * inverse / (along * inverse + half_chord);
  vec3 n = off * -1.0f - ray * half_chord;
  hit.normal = n * (1.0f / sqrt(dot(n, n)));
  return hit;
}

// The sphere's silhouette is a circle; this is its disc. Every ray that hits the sphere passes
// through the disc, inside the sphere, and no other ray does.
struct SphereDisc {
  vec3 center;
  float radius;  // 0: the eye is in the sphere
  vec3 axis_u;   // unit, in the disc's plane
  vec3 axis_v;
};
RULE SphereDisc sphereDisc(vec3 center, float radius) {
  SphereDisc disc;
  disc.center = vec3(0.0f, 0.0f, 0.0f);
  disc.radius = 0.0f;
  disc.axis_u = vec3(0.0f, 0.0f, 0.0f);
  disc.axis_v = vec3(0.0f, 0.0f, 0.0f);
  float distance = sqrt(dot(center, center));
  float outside = (distance - radius) * (distance + radius);
  if (!(outside > 0.0f)) return disc;
  float share = outside / (distance * distance);
  disc.center = center * share;
  disc.radius = radius * sqrt(share);
  // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
  vec3 n = center * (1.0f / distance);
  float s = n.z < 0.0f ? -1.0f : 1.0f;
  float a = -1.0f / (s + n.z);
  float b = n.x * n.y * a;
  disc.axis_u = vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
  disc.axis_v = vec3(b, s + n.y * n.y * a, -n.y);
  return disc;
}

// Corner 0, 1 or 2 of the triangle around the unit disc.
RULE vec2 discCorner(uint k) {
  return k == 0u ? vec2(-1.7320508f, -1.0f) : k == 1u ? vec2(1.7320508f, -1.0f) : vec2(0.0f, 2.0f);
}

RULES_END
