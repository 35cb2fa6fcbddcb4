// Colours of the debug views of swarms: which representation a pixel shows, when it was drawn, how often.
#pragma once
#include "shared/swarm.h"
RULES_BEGIN

// In views that tell grains apart, ids are the numbers of grains over all that is drawn, + 1, with this bit.
const uint kGrainIdBit = 1u << 31u;

// Display colours. No two of them are shades of one another.
const vec3 kPointColor = vec3(0.8f, 0.25f, 0.9f);
RULE vec3 representationColor(uint representation) {
  uint r = representation & (kFirst - 1u);
  if (r == kPoint) return kPointColor;
  if (r == kSmallImpostor) return vec3(0.1f, 0.85f, 0.8f);
  if (r == kImpostor) return vec3(0.2f, 0.45f, 1.0f);
  if (r == kMesh) return vec3(1.0f, 0.15f, 0.15f);
  if (r == kMesh + 1u) return vec3(1.0f, 0.55f, 0.1f);
  if (r == kMesh + 2u) return vec3(1.0f, 0.95f, 0.2f);
  return vec3(0.3f, 0.8f, 0.15f);
}

// Of what is drawn first, after the depth pyramid, and as points, which are neither.
RULE vec3 turnColor(uint representation) {
  if ((representation & (kFirst - 1u)) == kPoint) return kPointColor;
  return representation >= kFirst ? vec3(1.0f, 0.6f, 0.1f) : vec3(0.2f, 0.45f, 1.0f);
}

// So that shapes stay visible: lit from the eye. `cosine`: between the normal and the way to the eye.
RULE float viewShade(float cosine) { return 0.35f + 0.65f * clamp(cosine, 0.0f, 1.0f); }

// Of pixels that were written this often: black 0, blue 1, cyan 2, green 4, yellow 8, red 16, white 32 and more;
// between them by the logarithm.
RULE vec3 overdrawColor(float times) {
  if (!(times >= 1.0f)) return vec3(0.0f, 0.0f, 0.0f);
  float at = min(log2(times), 5.0f);
  if (at < 1.0f) return mix(vec3(0.0f, 0.0f, 0.7f), vec3(0.0f, 0.7f, 0.9f), at);
  if (at < 2.0f) return mix(vec3(0.0f, 0.7f, 0.9f), vec3(0.1f, 0.75f, 0.1f), at - 1.0f);
  if (at < 3.0f) return mix(vec3(0.1f, 0.75f, 0.1f), vec3(1.0f, 0.95f, 0.1f), at - 2.0f);
  if (at < 4.0f) return mix(vec3(1.0f, 0.95f, 0.1f), vec3(0.9f, 0.1f, 0.05f), at - 3.0f);
  return mix(vec3(0.9f, 0.1f, 0.05f), vec3(1.0f, 1.0f, 1.0f), at - 4.0f);
}

RULES_END
