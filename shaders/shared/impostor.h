// Which views of a grain's atlas a direction takes, and where in their images a ray looks.
//
// Space: the grain's own axes, its centre at the origin, its outer radius 1. Directions to views and
// to the eye lead away from the centre.
//
// Views stand at the points of a lattice on the octahedron |x| + |y| + |z| = 1 with n vertices along
// each edge: integers (i, j, k), |i| + |j| + |k| = m = n - 1, over m. That is the subdivided
// octahedron of Michel and Boubekeur 2020, section 4.2, with triangles, not squares, as cells: a
// direction has three views, none is stored twice, and for every n there are views on the three
// axes, so that equator and poles are lattice points like any other. 4 m^2 + 2 views.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// n. A texture array has 2,048 layers at least, enough for n = 23; more is for other stores.
const int kImpostorMinEdge = 2;
const int kImpostorMaxEdge = 33;

// Outlines were measured for eyes at outer radius / distance up to this; nearer ones see no impostor.
const float kImpostorMostNear = 0.3f;

// Added to the mip level of shape, and of color and normal: measured, see modules/impostors/README.md.
const float kImpostorShapeBias = -1.0f;
const float kImpostorColorBias = -0.5f;

RULE int impostorViewCount(int n) { return 4 * (n - 1) * (n - 1) + 2; }

// Number of the point (i, j) among those of the diamond |i| + |j| <= m, row by row.
RULE int impostorDiamondIndex(int i, int j, int m) {
  int height = j < 0 ? -j : j;
  int before = j <= 0 ? (m - height) * (m - height)
                      : 2 * m * m + 2 * m + 1 - (m + 1 - height) * (m + 1 - height);
  return before + i + m - height;
}

// Layer of a lattice point: the half z >= 0 first, then the half z < 0, which is one smaller.
RULE uint impostorLayer(ivec3 lattice, int m) {
  if (lattice.z >= 0) return uint(impostorDiamondIndex(lattice.x, lattice.y, m));
  return uint(2 * m * m + 2 * m + 1 + impostorDiamondIndex(lattice.x, lattice.y, m - 1));
}

// The inverse of impostorLayer.
RULE ivec3 impostorLattice(uint layer, int n) {
  int m = n - 1;
  int upper = 2 * m * m + 2 * m + 1;
  int index = int(layer);
  int radius = m;
  bool below = false;
  if (index >= upper) {
    index -= upper;
    radius = m - 1;
    below = true;
  }
  // Rows grow by two up to the middle one: row t begins at t^2. The rest is the mirror image.
  bool mirrored = index >= (radius + 1) * (radius + 1);
  if (mirrored) index = 2 * radius * radius + 2 * radius - index;
  int t = int(sqrt(float(index) + 0.5f));
  int i = index - t * t - t;
  int j = t - radius;
  int k = radius - (i < 0 ? -i : i) + j;  // radius - |i| - |j|, j <= 0
  if (below) k = -(k + 1);
  return mirrored ? ivec3(-i, -j, k) : ivec3(i, j, k);
}

// Unit vector from the centre to where a view was taken.
RULE vec3 impostorAxis(ivec3 lattice) {
  vec3 p = vec3(float(lattice.x), float(lattice.y), float(lattice.z));
  return p * (1.0f / sqrt(dot(p, p)));
}
RULE vec3 impostorViewDirection(uint layer, int n) { return impostorAxis(impostorLattice(layer, n)); }

// The three views around a direction. Weights sum to 1, and change continuously over the whole
// sphere: they are the barycentric coordinates in the lattice's triangles.
struct ImpostorViews {
  uint layer0, layer1, layer2;
  vec3 axis0, axis1, axis2;  // unit
  vec3 weight;
};

// `to_eye`: any length. What has no direction (zero, not finite) takes +Z.
RULE ImpostorViews impostorViews(vec3 to_eye, int n) {
  int m = n - 1;
  vec3 a = abs(to_eye);
  float sum = a.x + a.y + a.z;
  bool fine = sum > 1e-30f && sum < 1e30f;
  if (!fine) a = vec3(0.0f, 0.0f, 1.0f);
  if (!fine) sum = 1.0f;
  float scale = float(m) / sum;
  float x = min(a.x * scale, float(m));
  float y = min(a.y * scale, float(m));
  // The cell's corner nearest to the pole; on the equator, and past it by rounding, the cell inside.
  int i = min(int(x), m - 1);
  int j = min(int(y), m - 1 - i);
  float fx = clamp(x - float(i), 0.0f, 1.0f);
  float fy = clamp(y - float(j), 0.0f, 1.0f);
  float rest = 1.0f - fx - fy;
  int k = m - i - j;
  bool lower = rest >= 0.0f || k < 2;  // else the cell's other triangle, which needs k >= 2
  ivec3 p0 = lower ? ivec3(i, j, k) : ivec3(i + 1, j + 1, k - 2);
  ivec3 p1 = ivec3(i + 1, j, k - 1);
  ivec3 p2 = ivec3(i, j + 1, k - 1);
  vec3 w = lower ? vec3(max(rest, 0.0f), fx, fy) : vec3(-rest, 1.0f - fy, 1.0f - fx);
  ivec3 s = ivec3(to_eye.x < 0.0f ? -1 : 1, to_eye.y < 0.0f ? -1 : 1, to_eye.z < 0.0f ? -1 : 1);
  p0 = p0 * s;
  p1 = p1 * s;
  p2 = p2 * s;
  ImpostorViews views;
  views.layer0 = impostorLayer(p0, m);
  views.layer1 = impostorLayer(p1, m);
  views.layer2 = impostorLayer(p2, m);
  views.axis0 = impostorAxis(p0);
  views.axis1 = impostorAxis(p1);
  views.axis2 = impostorAxis(p2);
  views.weight = w * (1.0f / (w.x + w.y + w.z));
  return views;
}

// Axes of a view's image: right x up = axis. Finite and orthonormal for every unit axis
// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
struct ImpostorBasis {
  vec3 right;
  vec3 up;
};
RULE ImpostorBasis impostorBasis(vec3 axis) {
  float s = axis.z < 0.0f ? -1.0f : 1.0f;
  float a = -1.0f / (s + axis.z);
  float b = axis.x * axis.y * a;
  ImpostorBasis basis;
  basis.right = vec3(1.0f + s * axis.x * axis.x * a, s * b, -s * axis.x);
  basis.up = vec3(b, s + axis.y * axis.y * a, -axis.y);
  return basis;
}

// A view of p x p texels shows the square of this half side: one texel around the outer sphere stays
// empty, so that clamped reading never smears the silhouette.
RULE float impostorExtent(int p) { return float(p) / float(p - 2); }

// Texture coordinates of a point in a view's image; (0, 0) is the lower left of the first row.
RULE vec2 impostorUv(vec3 point, vec3 axis, float extent) {
  ImpostorBasis basis = impostorBasis(axis);
  return vec2(dot(point, basis.right), dot(point, basis.up)) * (0.5f / extent) + vec2(0.5f, 0.5f);
}

// Mip level for a grain drawn with a diameter of so many pixels: the nearest one, after the bias.
RULE int impostorLevel(int p, float diameter_px, float bias) {
  return int(max(log2(float(p - 2) / max(diameter_px, 1.0f)) + bias, 0.0f) + 0.5f);
}

// A ray in the grain's space. `foot` is its point nearest to the centre, `direction` unit, into the
// scene; where |foot| > 1 there is no grain.
struct ImpostorRay {
  vec3 foot;
  vec3 direction;
};
RULE ImpostorRay impostorRay(vec3 origin, vec3 direction) {
  ImpostorRay ray;
  ray.direction = direction * (1.0f / sqrt(dot(direction, direction)));
  ray.foot = origin - ray.direction * dot(origin, ray.direction);
  return ray;
}

// The four schemes: the point of the ray that is looked up. The first three are those of section 5
// of the paper; its mixed sampling takes the plane's point near the silhouette and the sphere's
// near the middle. A ray past the sphere takes its foot.

// Where the ray meets the plane through the centre that faces the view. Rays along the plane are
// held back: their view's weight is near zero.
RULE vec3 impostorOnPlane(ImpostorRay ray, vec3 axis) {
  return ray.foot - ray.direction * (dot(ray.foot, axis) / min(dot(ray.direction, axis), -0.1f));
}
RULE vec3 impostorOnSphere(ImpostorRay ray, float radius) {
  return ray.foot - ray.direction * sqrt(max(radius * radius - dot(ray.foot, ray.foot), 0.0f));
}
RULE vec3 impostorMixed(ImpostorRay ray, vec3 axis, float radius) {
  float share = min(sqrt(dot(ray.foot, ray.foot)), 1.0f);
  vec3 sphere = impostorOnSphere(ray, radius);
  return sphere + (impostorOnPlane(ray, axis) - sphere) * share;
}

// An ellipsoid that stands for the grain's surface: |T (x - center)| = 1, T upper triangular with
// the diagonal (xx, yy, zz) and the rest (xy, xz, yz). One point serves all three views.
struct ImpostorProxy {
  vec4 center;
  vec4 diagonal;
  vec4 upper;
};
RULE vec3 impostorToProxy(ImpostorProxy proxy, vec3 v) {
  return vec3(proxy.diagonal.x * v.x + proxy.upper.x * v.y + proxy.upper.y * v.z,
              proxy.diagonal.y * v.y + proxy.upper.z * v.z, proxy.diagonal.z * v.z);
}
// std140: what programs know of an atlas.
struct ImpostorBlock {
  ImpostorProxy proxy;
  int edge;                // n
  int texels;              // p
  float extent;            // impostorExtent(p)
  float half_over_extent;  // 0.5 / extent
};
// Past the ellipsoid: the ray's point nearest to it in its own metric, so that nothing jumps.
RULE vec3 impostorOnProxy(ImpostorRay ray, ImpostorProxy proxy) {
  vec3 center = vec3(proxy.center.x, proxy.center.y, proxy.center.z);
  vec3 o = impostorToProxy(proxy, ray.foot - center);
  vec3 d = impostorToProxy(proxy, ray.direction);
  float inverse = 1.0f / dot(d, d);
  float along = -dot(o, d) * inverse;
  vec3 off = o + d * along;
  float chord2 = max(1.0f - dot(off, off), 0.0f);
  return ray.foot + ray.direction * (along - sqrt(chord2 * inverse));
}

// One step of parallax: from a point of the ray, the point where the ray is as high above the
// centre, along the view's axis, as the view's surface is (`height`, read where `point` projects).
RULE vec3 impostorStep(ImpostorRay ray, vec3 point, vec3 axis, float height) {
  float slope = min(dot(ray.direction, axis), -0.25f);
  return point + ray.direction * ((height - dot(point, axis)) / slope);
}

// Stored numbers. Heights and normals are in [-1, 1]; 0 is a code, so that it survives.
RULE float impostorHeightFromCode(float code) { return (code * 255.0f - 128.0f) * (1.0f / 127.0f); }
RULE vec3 impostorNormalFromCode(vec3 code) {
  return (code * 255.0f - vec3(128.0f, 128.0f, 128.0f)) * (1.0f / 127.0f);
}

RULES_END
