// What the GPU knows of the grains of a swarm, and the rules that choose how each is drawn.
//
// A grain is a shape, turned, and scaled so that its outer radius (of the sphere around the whole shape)
// is the grain's own. Sizes on the screen are outer radii in pixels.
#pragma once
#include "shared/bindings.h"
#include "shared/ellipsoid.h"
#include "shared/prelude.h"
#include "shared/rotation.h"
RULES_BEGIN

// std430, 24 bytes: 20 million grains are 480 MB.
struct SwarmRecord {
  float x;  // centre, relative to the swarm's origin, m
  float y;
  float z;
  uint rotation;  // packRotation()
  uint look;      // packGrainLook()
  uint size;      // packGrainSize()
};

// How a grain is drawn. What may well hide others is drawn first; the rest if the depth pyramid does not hide it.
const uint kNotDrawn = 0u;
const uint kPoint = 1u;
const uint kSmallImpostor = 2u;  // of one view
const uint kImpostor = 3u;
const uint kMesh = 4u;  // level 0; the coarser ones follow
const uint kMeshLevels = 4u;
const uint kFirst = 8u;  // added to these: drawn first
const uint kHidden = 8u;  // in the view, but the depth pyramid hides it
const uint kRepresentations = 16u;
const uint kCountWords = 4u;  // of a run's counts, a byte a representation
// Impostors above this size show three views, however good the nearest alone may be.
const float kSmallPx = 9.0f;
const uint kMeshParts = 4u;  // of a shape, each of another material

// A dispatch has no more along one axis: GL's least limit.
const uint kMostWorkGroups = 65535u;

// Grains that one invocation of the routing programs walks through, in order: what makes a list the
// same in every run. Their representations are 4 bits each, eight a word.
const uint kRunGrains = 64u;
const uint kRunWords = 8u;  // of a run's representations
// Words of bits, one a grain, that say which a pixel showed in the last frame.
const uint kRunSeenWords = 2u;
// Runs that share a prefix of their counts.
const uint kBlockRuns = 64u;

// std140: of the grains of one buffer, in one frame.
struct SwarmBlock {
  vec4 origin;           // xyz: swarm's origin - camera, m; w: its largest grain's outer radius, m
  vec4 previous_origin;  // xyz: the same one frame ago; w: inner radius / outer radius
  vec4 center_scale;     // xyz: centre of the shape's spheres, in its mesh; w: 1 / its outer radius
  vec4 albedo;           // rgb: mean over the shape; a: radius of a ball with its mean shadow / outer radius
  vec4 mesh_px;          // level k >= 1 of the mesh is drawn below mesh_px[k]; [0] unused
  float point_px;        // below this, and at most kPointSpread less, a grain is a point
  float impostor_px;     // below this, and from impostor_from_px on, an impostor
  float impostor_from_px;
  float band;            // share by which a threshold must be passed before a grain changes
  uint count;            // grains in this buffer
  uint first;            // number of the first of them, over all that is drawn
  uint first_id;         // id of grain k: first_id + k, or first_id alone if same_id is 1
  uint same_id;
  uint run_count;
  uint listed;           // a bit for each representation that is listed now
  float roughness;       // mean over the shape
  float metallic;
  float candidate_cell;  // cells of the candidate map, in sizes of a grain
  uint cull;             // 1: what the depth pyramid hides is not drawn
  float small_px;        // below this an impostor shows one view
  uint rank_seed;        // which points stand for others: shared/points.h
  Ellipsoid bound;       // the shape lies in it
};

// std430: where the lists of the representations are, and what draws them.
struct DrawArraysCommand {
  uint vertices;
  uint instances;
  uint first;
  uint base_instance;
};
struct DrawElementsCommand {
  uint indices;
  uint instances;
  uint first_index;
  int base_vertex;
  uint base_instance;
};
struct SwarmCommands {
  uint begin[16];  // by representation, in the list
  uint count[16];
  DrawArraysCommand impostors[16];  // by representation; gl_VertexID / verticesOf() is a grain's place in the list
  DrawElementsCommand meshes[32];   // meshCommand(); the base instance is the first one's place in the list
  uint listed;                    // entries in the list so far
  // Work groups of programs that have nothing to do in many a frame: then none.
  uint point_groups[3];           // of 64 runs: those that visit all points
  uint first_groups[3];           // those that list what is drawn first
  uint late_groups[3];            // those that choose and list the rest
  uint walked_groups[3];          // of 8 runs: those that look at each grain of them
  uint walked;                    // runs of which each grain is looked at
  uint see_groups[3];             // of 8 x 8 pixels: those that note what is seen
  uint seen_groups[3];            // of 64 points that are seen: those that visit these
  uint seen_points;               // at the end of the list, the last one first
};

// Small impostors are drawn as points, others as triangles.
RULE uint verticesOf(uint representation) { return (representation & (kFirst - 1u)) == kSmallImpostor ? 1u : 3u; }

// Place in SwarmCommands::meshes of a level, kMesh and so on, drawn first or not, and a part of it.
RULE uint meshCommand(uint representation, uint part) {
  uint level = (representation & (kMeshLevels - 1u)) + (representation >= kFirst ? kMeshLevels : 0u);
  return level * kMeshParts + part;
}

// Quaternion x, y, z, w -> the three smaller components in 10 bits each, and which one is left out. A
// point of the shape is off by less than 4.1e-3 outer radii.
const float kRotationSteps = 1023.0f;
const float kRotationMost = 0.70710678f;
RULE uint packRotation(vec4 q) {
  vec4 a = abs(q);
  uint most = 0u;
  if (a.y > a.x) most = 1u;
  if (a.z > a[int(most)]) most = 2u;
  if (a.w > a[int(most)]) most = 3u;
  float length2 = dot(q, q);
  if (!(length2 > 1e-30f && length2 < 1e30f)) return 3u << 30u | 512u << 20u | 512u << 10u | 512u;
  float scale = (q[int(most)] < 0.0f ? -1.0f : 1.0f) / sqrt(length2);
  uint code = most << 30u;
  uint shift = 0u;
  for (uint k = 0u; k < 4u; ++k) {
    if (k == most) continue;
    float v = clamp(q[int(k)] * scale / kRotationMost, -1.0f, 1.0f);
    code |= uint((v * 0.5f + 0.5f) * kRotationSteps + 0.5f) << shift;
    shift += 10u;
  }
  return code;
}
RULE vec4 unpackRotation(uint code) {
  float a = (float(code & 1023u) * (2.0f / kRotationSteps) - 1.0f) * kRotationMost;
  float b = (float(code >> 10u & 1023u) * (2.0f / kRotationSteps) - 1.0f) * kRotationMost;
  float c = (float(code >> 20u & 1023u) * (2.0f / kRotationSteps) - 1.0f) * kRotationMost;
  float d = sqrt(max(1.0f - a * a - b * b - c * c, 0.0f));
  uint most = code >> 30u;
  vec4 q = most == 0u ? vec4(d, a, b, c) : most == 1u ? vec4(a, d, b, c) : most == 2u ? vec4(a, b, d, c) : vec4(a, b, c, d);
  return q * (1.0f / sqrt(dot(q, q)));
}

// Tint by which the shape's own colour is multiplied, and a factor of its roughness; [0, 1] each. Square
// roots of the tint, so that dark colours keep their steps.
RULE uint packGrainLook(vec3 tint, float roughness) {
  vec3 c = sqrt(clamp(tint, 0.0f, 1.0f)) * 255.0f;
  return uint(c.x + 0.5f) | uint(c.y + 0.5f) << 8u | uint(c.z + 0.5f) << 16u |
         uint(clamp(roughness, 0.0f, 1.0f) * 255.0f + 0.5f) << 24u;
}
RULE vec3 tintOf(uint look) {
  vec3 c = vec3(float(look & 255u), float(look >> 8u & 255u), float(look >> 16u & 255u)) * (1.0f / 255.0f);
  return c * c;
}
RULE float roughnessOf(uint look) { return float(look >> 24u) * (1.0f / 255.0f); }

// Outer radius as a share of the swarm's largest, and a number of the grain's own for patterns.
const uint kRadiusSteps = 65535u;
RULE uint packGrainSize(float share, uint seed) {
  return uint(clamp(share, 0.0f, 1.0f) * 65535.0f + 0.5f) | seed << 16u;
}
RULE float radiusOf(uint size, float largest) { return float(size & kRadiusSteps) * (largest / 65535.0f); }

// A size in pixels grows without bound towards the eye; in the sphere it is this.
const float kLargestPx = 1e9f;
// Outer radius in pixels of a sphere at `distance` from the eye: turning the camera changes nothing.
RULE float sizePx(float radius, float distance, float pixels_at_1m) {
  return distance > radius ? radius * pixels_at_1m / distance : kLargestPx;
}

// Whether a threshold counts as passed from below: a grain that was `above` it stays so a little longer.
RULE bool isBelow(float size_px, float threshold, float band, bool was_above) {
  return size_px < threshold * (was_above ? 1.0f - band : 1.0f + band);
}

// Points are of another kind than what they follow: were all grains of a distant heap to become points at one distance,
// it would show. Each becomes one at a size of its own, by what stays the same as it moves: its look and seed.
const float kPointSpread = 0.16f;  // share of point_px: 11 steps of a camera that goes away by 1.5 % each
// [0, 1).
RULE float ownShare(uint look, uint size) {
  uint h = (look ^ (size >> 16u) * 0x9e3779b1u) * 0x85ebca6bu;
  return float((h ^ h >> 15u) * 0xc2b2ae35u >> 8u) * (1.0f / 16777216.0f);
}

// How a grain of this size is drawn that was drawn as `drawn_as`; not yet whether first. `own`: its ownShare.
RULE uint representationOf(float size_px, float own, uint drawn_as, SwarmBlock swarm) {
  uint before = drawn_as & (kFirst - 1u);
  bool known = before != kNotDrawn;
  float band = known ? swarm.band : 0.0f;
  bool was_mesh = before >= kMesh;
  if (isBelow(size_px, swarm.point_px * (1.0f - kPointSpread * own), band, before > kPoint)) return kPoint;
  if (isBelow(size_px, swarm.impostor_px, band, was_mesh) &&
      !isBelow(size_px, swarm.impostor_from_px, band, before == kImpostor || before == kSmallImpostor))
    return isBelow(size_px, swarm.small_px, band, before >= kImpostor) ? kSmallImpostor : kImpostor;
  uint level = kMeshLevels - 1u;
  while (level > 0u && !isBelow(size_px, swarm.mesh_px[int(level)], band, was_mesh && before - kMesh < level)) --level;
  return kMesh + level;
}

RULES_END
