// Every binding number of the project in one place, for C++ and GLSL: uniform blocks, storage
// blocks, texture units and vertex attributes. A new user takes the next free number and adds a line.
#pragma once
#include "shaders/shared/prelude.h"

RULES_BEGIN

// Uniform blocks.
const int kViewBinding = 0;        // shared/view.h
const int kLightingBinding = 1;    // sun and sky of the frame
const int kDrawBinding = 2;        // constants of one draw
const int kPassBinding = 3;        // constants of one pass, rebound by each
const int kShadowViewBinding = 4;  // shared/shadow.h

// Storage blocks (16 a stage at most).
const int kInstancesBinding = 0;   // mesh instances
const int kGrainsBinding = 1;      // grains
const int kVisibleBinding = 2;     // indices of what is drawn
const int kSwarmRecordsBinding = 3;          // shared/swarm.h: grains of a swarm
const int kSwarmRepresentationsBinding = 4;  // how each is drawn, 4 bits
const int kSwarmCountsBinding = 5;           // of each run, by representation
const int kSwarmPrefixBinding = 6;           // walked runs; then counts before a run, in its block, before a block
const int kSwarmListBinding = 7;             // grains by representation
const int kSwarmCommandsBinding = 8;
const int kCandidateMapBinding = 9;          // nearest grain by cell: shared/candidate.h
const int kPointKeysBinding = 10;            // shared/points.h, by pixel
const int kPointSumsBinding = 11;
const int kPointIdsBinding = 12;
const int kPointSurfacesBinding = 13;
const int kTilesBinding = 14;                // shared/tiles.h
const int kSwarmSeenBinding = 15;            // a bit a grain: shared/swarm.h
const int kSwarmRunsBinding = kGrainsBinding;  // in programs of swarms: shared/swarm_run.h
const int kSwarmOrderBinding = kVisibleBinding;  // of runs, the nearest to the eye first
const int kSunCellsBinding = 10;             // in programs that draw no points: grains by cell of the
const int kSunDepthBinding = 11;             // sun's map, and its depth

// Texture units. One kind of sampler a unit, never mixed within a program.
const int kBaseColorUnit = 0;
const int kMetallicRoughnessUnit = 1;
const int kNormalMapUnit = 2;
const int kEmissiveMapUnit = 3;
const int kGbufferAlbedoUnit = 4;
const int kGbufferNormalUnit = 5;
const int kGbufferEmissiveUnit = 6;
const int kGbufferMotionUnit = 7;
const int kGbufferIdUnit = 8;
const int kGbufferDepthUnit = 9;
const int kShadowMapUnit = 10;
const int kRadianceUnit = 11;
const int kPassTextureUnit = 12;   // whatever else one pass reads, from here up
const int kLobeTableUnit = 12;     // shared/brdf.h, in deferred.light
const int kImpostorShapeUnit = 13;   // shared/impostor.h: an atlas
const int kImpostorColorUnit = 14;
const int kImpostorNormalUnit = 15;
const int kPyramidUnit = 15;       // lib/occlusion.glsl; the last that every stage has

// Image units.
const int kPyramidImage = 0;       // and the two above: three levels of the depth pyramid
const int kImpostorCoverageImage = 3;  // shared/coverage.h: a packed atlas
const int kImpostorHeightImage = 4;
const int kImpostorSurfaceImage = 5;   // of two words: color, normal
const int kOverdrawImage = 0;      // in points.count: shared/swarm_view.h

// Vertex attributes of meshes (engine/assets/mesh_data.h); from kFirstFreeAttribute up: a module's own.
const int kPositionAttribute = 0;
const int kNormalAttribute = 1;
const int kTangentAttribute = 2;
const int kUvAttribute = 3;
const int kFirstFreeAttribute = 4;

RULES_END
