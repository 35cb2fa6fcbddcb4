// The map of occluder candidates: which grains are drawn first, as they may well hide others.
//
// It has several resolutions; a grain is entered in that whose cells are about so many of its sizes as wanted.
// The nearest in a cell is a candidate (Michel and Boubekeur 2020, section 8: points of 0.15 to 0.2 inner radii).
// What was seen in the last frame is a better guess, where there was one. Then candidates are those that it neither
// showed nor hid: right behind what it showed, they close the holes that open as the camera moves. Through a hole of
// one pixel a whole column of grains is drawn, so these are worth more than they cost.
#pragma once
#include "shared/prelude.h"
#include "shared/view.h"
RULES_BEGIN

// In sizes of a grain; chosen by the shares that scree_bench occlusion finds culled.
const float kCandidateCell = 1.0f;       // if nothing is known
const float kCandidateCellMoving = 2.2f;  // after a frame from nearby
const float kCandidateCellStill = 4.0f;   // after one from the same place
const uint kCandidateLevels = 7u;  // cells of 1 to 64 px
RULE uint candidateLevel(float size_px, float cell_sizes) {
  uint level = 0u;
  float cell = size_px * cell_sizes;
  while (level + 1u < kCandidateLevels && cell >= 2.0f) {
    cell *= 0.5f;
    ++level;
  }
  return level;
}
RULE ivec2 candidateSize(ivec2 size_px, uint level) {
  int round_up = (1 << int(level)) - 1;
  return ivec2((size_px.x + round_up) >> int(level), (size_px.y + round_up) >> int(level));
}
// Where a level's cells begin.
RULE uint candidateBegin(ivec2 size_px, uint level) {
  uint begin = 0u;
  for (uint k = 0u; k < level; ++k) {
    ivec2 s = candidateSize(size_px, k);
    begin += uint(s.x) * uint(s.y);
  }
  return begin;
}
// The cell of a point in pixels; beyond the picture's edge that at the edge.
RULE uint candidateCell(vec2 pixel_px, float size_px, float cell_sizes, ivec2 picture_px) {
  uint level = candidateLevel(size_px, cell_sizes);
  ivec2 cells = candidateSize(picture_px, level);
  vec2 p = clamp(pixel_px, vec2(0.0f, 0.0f), vec2(picture_px) - 0.5f);
  ivec2 cell = ivec2(int(p.x) >> int(level), int(p.y) >> int(level));
  return candidateBegin(picture_px, level) + uint(cell.y) * uint(cells.x) + uint(cell.x);
}

// Nearer is greater.
RULE uint candidateKey(float distance) { return floatBitsToUint(1.0f / max(distance, 1e-30f)); }

// Where a point is seen, pixels; of what is not before the eye, the picture's corner.
RULE vec2 pixelOf(ViewBlock view, vec3 relative) {
  vec4 clip = view.clip_from_relative * vec4(relative, 1.0f);
  if (!(clip.w > 0.0f)) return vec2(0.0f, 0.0f);
  return (vec2(clip.x, clip.y) / clip.w * 0.5f + 0.5f) * view.size_px;
}

RULES_END
