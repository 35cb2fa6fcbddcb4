// An ellipsoid that a grain's mesh lies in: which rays miss it, the flat shape that covers it, and where it may show.
//
// Space: the grain's own axes, its centre at the origin, its outer radius 1.
#pragma once
#include "shared/occlusion.h"
#include "shared/prelude.h"
#include "shared/rotation.h"
#include "shared/sphere.h"
RULES_BEGIN

// std140. The image of the unit ball: center + axis_a x + axis_b y + axis_c z; the axes are perpendicular.
struct Ellipsoid {
  vec4 center;  // w: distance of its farthest point from the origin, or more
  vec4 axis_a;  // w: 1 / squared length
  vec4 axis_b;
  vec4 axis_c;
};
RULE Ellipsoid unitBall() {
  Ellipsoid e;
  e.center = vec4(0.0f, 0.0f, 0.0f, 1.0f);
  e.axis_a = vec4(1.0f, 0.0f, 0.0f, 1.0f);
  e.axis_b = vec4(0.0f, 1.0f, 0.0f, 1.0f);
  e.axis_c = vec4(0.0f, 0.0f, 1.0f, 1.0f);
  return e;
}

// Vectors, not places, to where the ellipsoid is the unit ball, and back.
RULE vec3 toBall(Ellipsoid e, vec3 v) {
  return vec3(dot(vec3(e.axis_a), v) * e.axis_a.w, dot(vec3(e.axis_b), v) * e.axis_b.w, dot(vec3(e.axis_c), v) * e.axis_c.w);
}
RULE vec3 fromBall(Ellipsoid e, vec3 v) { return vec3(e.axis_a) * v.x + vec3(e.axis_b) * v.y + vec3(e.axis_c) * v.z; }

// Nearer than this to a grain's centre, outer radii, the eye sees it in its outer sphere, from elsewhere in its ellipsoid.
const float kLeastEllipsoidEye = 8.0f;
// `eye`: in the grain's space.
RULE Ellipsoid ellipsoidSeenFrom(Ellipsoid e, vec3 eye) {
  if (dot(eye, eye) < kLeastEllipsoidEye * kLeastEllipsoidEye) return unitBall();
  return e;
}

// Whether a ray, or its continuation, misses the ellipsoid. `foot`: a point of it not far from the grain.
RULE bool missesEllipsoid(Ellipsoid e, vec3 foot, vec3 direction) {
  vec3 o = toBall(e, foot - vec3(e.center)), d = toBall(e, direction);
  vec3 off = o - d * (dot(o, d) / dot(d, d));
  return dot(off, off) > 1.0f;
}

// A corner of the triangle around the ellipsoid's silhouette, as seen from an eye beyond kLeastEllipsoidEye, or outside
// of the unit ball. It lies in the plane of the outer sphere's silhouette disc (sphere.h): how far away a grain is
// does not depend on how it is turned.
struct EllipsoidCorner {
  vec3 point;
  // x, y: z times the place on the ellipsoid's own disc; each changes evenly over the triangle. Rays to points with
  // x^2 + y^2 > z^2 miss the ellipsoid.
  vec3 on_disc;
};
RULE EllipsoidCorner ellipsoidCorner(Ellipsoid e, vec3 eye, vec2 on_disc) {
  vec3 o = toBall(e, eye - vec3(e.center));
  SphereDisc disc = sphereDisc(o * -1.0f, 1.0f);
  vec3 polar = o * (1.0f / dot(o, o)) + (disc.axis_u * on_disc.x + disc.axis_v * on_disc.y) * disc.radius;
  vec3 p = vec3(e.center) + fromBall(e, polar);
  // From the polar plane of the ellipsoid along the ray to that of the unit ball.
  float above = dot(p, eye), distance2 = dot(eye, eye), share = 1.0f / (distance2 - above);
  EllipsoidCorner corner;
  corner.point = p + (p - eye) * ((above - 1.0f) * share);
  float weight = (distance2 - 1.0f) * share;
  corner.on_disc = vec3(on_disc * weight, weight);
  return corner;
}

// A grain that is small on the screen, as if all rays through it were parallel: pixels are then linear in places of its
// space.
struct ParallelImage {
  vec2 middle_px;    // of the grain
  vec2 ellipse_px;   // of its ellipsoid, which shows as an ellipse
  vec2 reach_px;     // of that, along x and y
  vec3 inside;       // of offsets from it, pixels: x^2, x y, y^2, summed up to 1
  vec3 along_x;      // what a pixel along x, along y changes in the grain's space, in the plane that faces the eye
  vec3 along_y;
};
RULE ParallelImage parallelImage(mat4 clip_from_relative, vec2 size_px, vec3 center, float radius, vec4 rotation, Ellipsoid e) {
  mat4 m = clip_from_relative;
  vec3 row_x = vec3(m[0][0], m[1][0], m[2][0]), row_y = vec3(m[0][1], m[1][1], m[2][1]), row_w = vec3(m[0][3], m[1][3], m[2][3]);
  vec4 clip = m * vec4(center, 1.0f);
  vec2 ndc = vec2(clip.x, clip.y) / clip.w, half_size = size_px * 0.5f, scale = half_size * (radius / clip.w);
  ParallelImage image;
  image.middle_px = (ndc + vec2(1.0f, 1.0f)) * half_size;
  // How pixels change with a place in the grain's space: both are perpendicular to the ray through its centre.
  vec4 back = vec4(vec3(rotation) * -1.0f, rotation.w);
  vec3 gx = rotateBy(back, row_x - row_w * ndc.x) * scale.x, gy = rotateBy(back, row_y - row_w * ndc.y) * scale.y;
  float xx = dot(gx, gx), xy = dot(gx, gy), yy = dot(gy, gy), share = 1.0f / (xx * yy - xy * xy);
  image.along_x = (gx * yy - gy * xy) * share;
  image.along_y = (gy * xx - gx * xy) * share;
  image.ellipse_px = image.middle_px + vec2(dot(gx, vec3(e.center)), dot(gy, vec3(e.center)));
  vec3 x = vec3(dot(gx, vec3(e.axis_a)), dot(gx, vec3(e.axis_b)), dot(gx, vec3(e.axis_c)));
  vec3 y = vec3(dot(gy, vec3(e.axis_a)), dot(gy, vec3(e.axis_b)), dot(gy, vec3(e.axis_c)));
  vec3 area = cross(x, y);
  image.inside = vec3(dot(y, y), dot(x, y) * -2.0f, dot(x, x)) * (1.0f / dot(area, area));
  image.reach_px = sqrt(vec2(dot(x, x), dot(y, y)));
  return image;
}
// That is so as long as the outer radius is at most this share of the distance, where pixels are not stretched: at their
// widest by `stretch`, 1 + the squared tangents to the picture's corner.
const float kMostParallel = 0.0625f;
RULE float mostParallelPx(float pixels_at_1m, float stretch) { return kMostParallel * pixels_at_1m / stretch; }

// By how much its silhouette, as computed here and by a vertex program, may be off: 512u of its extent.
const float kEllipsoidError = 3.0517578125e-05f;

// How a grain is drawn, as far as its bounds are concerned.
const uint kAsSolid = 0u;     // whatever lies both in the ellipsoid and in the outer sphere
const uint kAsTriangle = 1u;  // by the corners above
const uint kAsImage = 2u;     // as parallelImage() has it

// Where it may show, and how near; see sphereBounds().
RULE SphereBounds ellipsoidBounds(OcclusionView v, vec3 center, float radius, vec4 rotation, Ellipsoid e, float reach_px,
                                  uint drawn) {
  bool disc = drawn != kAsSolid;
  float reach = radius * max(e.center.w, 1.0f), distance2 = dot(center, center);
  // Where the corners change their rule, and a little more to both sides.
  float near_eye = 0.99f * kLeastEllipsoidEye * radius, far_eye = 1.01f * kLeastEllipsoidEye * radius;
  SphereBounds b = sphereBounds(v, center, disc && distance2 > near_eye * near_eye ? reach : radius, reach_px, disc);
  // Rays that are drawn as parallel leave the sphere's bounds.
  SphereBounds else_b = b;
  if (drawn == kAsImage) else_b.known = false;
  if (!b.known || !(distance2 > far_eye * far_eye)) return else_b;

  vec4 back = vec4(vec3(rotation) * -1.0f, rotation.w);
  vec3 right = rotateBy(back, vec3(v.right)), up = rotateBy(back, vec3(v.up)), forward = rotateBy(back, vec3(v.forward));
  vec3 middle = vec3(e.center);
  float x = dot(vec3(v.right), center) + radius * dot(right, middle), y = dot(vec3(v.up), center) + radius * dot(up, middle);
  float w = dot(vec3(v.forward), center) + radius * dot(forward, middle);
  // Of the unit ball's points, by how much the axes bring them there.
  vec3 ax = vec3(dot(right, vec3(e.axis_a)), dot(right, vec3(e.axis_b)), dot(right, vec3(e.axis_c))) * radius;
  vec3 ay = vec3(dot(up, vec3(e.axis_a)), dot(up, vec3(e.axis_b)), dot(up, vec3(e.axis_c))) * radius;
  vec3 aw = vec3(dot(forward, vec3(e.axis_a)), dot(forward, vec3(e.axis_b)), dot(forward, vec3(e.axis_c))) * radius;
  float distance = sqrt(distance2), error = v.center_error * distance + kEllipsoidError * reach;
  float half_depth = sqrt(dot(aw, aw)), nearest = w - half_depth - error;
  if (!(nearest >= v.forward.w)) return else_b;

  if (disc) {
    vec2 across = vec2(dot(vec3(v.right), center), dot(vec3(v.up), center));
    float aside = sqrt(dot(across, across));
    // A place p of the ellipsoid is drawn as if it were at the centre's distance w: off by at most |p|^2 / (w - |p|).
    if (drawn == kAsImage) error += 1.25f * reach * reach / nearest;
    // In the plane of the sphere's disc, within the cone of rays to the ball around the ellipsoid.
    float share = (distance - radius) * (distance + radius) / distance2;
    float half_disc = share * reach / sqrt((distance - reach) * (distance + reach)) * aside;
    float disc_nearest = dot(vec3(v.forward), center) * share - half_disc - error;
    // The triangle reaches up to 2.2 times as far.
    if (!(disc_nearest >= 3.0f * half_disc)) return else_b;
    b.depth = v.forward.w / disc_nearest * v.depth_scale;
  } else {
    b.depth = min(b.depth, v.forward.w / max(nearest - kEdgeOnShare * radius, v.forward.w) * v.depth_scale);
  }

  // Slopes of the planes through the eye that touch it: (x, w) seen along n = (w, -x) / .., with the ball's image
  // in that direction: roots of (s w - x)^2 = |s aw - ax|^2.
  float inverse = 1.0f / (w * w - half_depth * half_depth);
  vec2 mid = vec2(x * w - dot(ax, aw), y * w - dot(ay, aw)) * inverse;
  vec3 turn_x = aw * x - ax * w, turn_y = aw * y - ay * w, cross_x = cross(ax, aw), cross_y = cross(ay, aw);
  vec2 half_slope = sqrt(max(vec2(dot(turn_x, turn_x) - dot(cross_x, cross_x), dot(turn_y, turn_y) - dot(cross_y, cross_y)),
                             vec2(0.0f, 0.0f))) *
                    inverse;
  vec2 grow = (vec2(1.0f, 1.0f) + abs(mid) + half_slope) * (error / nearest);
  return boundsBetween(v, mid - half_slope - grow, mid + half_slope + grow, b.depth, reach_px);
}

RULES_END
