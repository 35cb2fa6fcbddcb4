// The table behind the sky's reflection: directional albedo and mean direction of the GGX lobe.
#pragma once

#include <span>
#include <vector>

#include "engine/core/math.h"
#include "shaders/shared/brdf.h"

namespace scree {

// Importance-sampled integrals of the single-scattering lobe (visible normals: Heitz 2018, JCGT
// 7(4)) for one view direction. n_v in (0, 1], alpha in (0, 1], samples even. With the 512 samples of the table
// the terms are within 0.002 of the integral.
rules::LobeTerms integrateLobe(double n_v, double alpha, int samples);

// kLobeTableSize^2 texels (a, b, tangent, normal), rows by roughness from 0 to 1. Takes 25 to 40 ms
// of one core, shared out among threads. Read with bilinear filtering, for n.v from 0.003 and roughness from 0.045 up, a is
// within 0.011 of the integral (0.0007 rms), b within 0.023, the mean direction within 0.006: the worst is at grazing angles
// on surfaces that are nearly mirrors.
std::vector<vec4> makeLobeTable();

// What a bilinear fetch of a table gives; `texels`: kLobeTableSize^2 of them.
rules::LobeTerms sampleLobeTable(std::span<const vec4> texels, float n_v, float roughness);

// The same of surfaces whose normals are spread about the one that n_v is of (shared/spread.h): means of a and b over
// them, of which n.v is taken to have a beta distribution; the mean direction of the lobe that they make together.
// One table after another, of all steps of spread from 0 on. Takes 15 to 25 ms of one core, shared out among threads.
std::vector<vec4> makeSpreadLobeTables(std::span<const vec4> table);

}  // namespace scree
