// What the routing of grains keeps between frames, and the parts that lod.cpp registers.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "engine/ecs/query.h"
#include "engine/ecs/schedule.h"
#include "engine/frame/frame.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/stream.h"
#include "modules/lod/lod.h"
#include "shaders/shared/swarm_run.h"

namespace scree::lod {

struct SunMap;  // sun_map.h

// The grains of one buffer, on the GPU.
struct Chunk {
  gpu::Buffer records, runs;
  uint32_t count = 0;
  std::vector<vec3> middles;  // of the runs' boxes, relative to the swarm's origin, m
  float run_size = 1;         // median side of these, m
};

// How the grains of a chunk are drawn, where one entity has them.
struct Routes {
  gpu::Buffer representations, seen, counts, prefix, list, commands;
  gpu::Buffer order;  // the runs, the nearest first
  vec3 ordered_from{0};  // where the eye was then, relative to the swarm's origin, m
  float nearest = 0;     // and how far from the nearest run, m
  uint64_t ordered_version = 0;  // of the grains; 0: never
  uint32_t count = 0;  // grains
};

// A swarm on the GPU; what is not drawn in a frame is given back.
struct Resident {
  uint64_t version = 0;  // above 0
  bool drawn = false;
  std::vector<Chunk> chunks;
};

// An entity's swarm.
struct Placement {
  Entity entity;
  uint32_t swarm = 0;
  bool drawn = false, drew = false;  // in this frame; in the last
  dvec3 origin{0};
  uint64_t version = 0;  // of the grains, when it was last drawn
  std::vector<Routes> routes;  // by chunk
};

// A chunk that is drawn in this frame.
struct Part : SwarmPart {
  const Chunk* chunk = nullptr;
  Routes* routes = nullptr;
  gpu::StreamSlice early, late;  // SwarmBlock, of the lists that are made before and after the depth pyramid
  LodThresholds thresholds;
  bool casts = false;  // shadows
  float cast_share = 1;  // of a ball with the shape's mean shadow, radius / outer radius
};

// Room to sort in.
struct RunOrder {
  std::vector<float> distances;
  std::vector<uint32_t> begins, order;
};

// What a swarm's shadow depends on.
struct CasterSeen {
  uint32_t swarm = 0;
  uint64_t version = 0;
  dvec3 origin{0};
  bool operator==(const CasterSeen&) const = default;
};

}  // namespace scree::lod

namespace scree {

struct SwarmsDrawn::State {
  explicit State(World& world_in);

  World& world;
  Query<const Swarm, const Transform> swarms;
  std::vector<rules::SwarmRun> runs_scratch;
  lod::RunOrder order_scratch;
  std::vector<lod::Resident> resident;  // by swarm
  std::vector<lod::Placement> placements;
  std::vector<lod::Part> parts;         // of this frame
  uint64_t grain_count = 0;
  bool casts = false;  // some part
  uint64_t casters_version = 0;  // goes up when what casts, or where it is, changes
  std::vector<lod::CasterSeen> casters_seen, casters_now;
  uint32_t possible = 0;  // a bit for each representation that some part may have, at the sizes of its grains
  uint32_t routed_possible = 0;  // when the lists were last made
  gpu::StreamBuffer blocks{"lod.blocks", 16 * 1024};
  gpu::Buffer candidates;
  std::shared_ptr<lod::SunMap> sun_map;  // never null
  bool routed = false;  // the lists on the GPU are those of a frame
  bool frozen = false;  // and are not made anew: SwarmView::Frozen
  // Of the last frame.
  dvec3 last_camera{0};
  quat last_rotation{1, 0, 0, 0};
  vec2 last_size_px{0};
  float last_pixels_at_1m = 0;
  uint64_t last_frame = 0;
};

}  // namespace scree

namespace scree::lod {

using SharedState = std::shared_ptr<SwarmsDrawn::State>;

// External resource: which grains the last frame showed.
inline constexpr const char* kSeen = "lod.seen";

// Settings that are not a number count as 0.
inline float notNan(float setting) { return std::isnan(setting) ? 0 : setting; }

// The thresholds that a program routes by.
void setThresholds(rules::SwarmBlock& block, const LodThresholds& thresholds, float band);

// Sizes between which those of all grains of a swarm are, px.
struct SizeRange {
  float least = 0, most = 0;
};
SizeRange sizesOf(const SwarmStore::Stored& stored, const vec3& origin_relative, float pixels_at_1m);
// A bit for each representation that rules::representationOf may choose among such sizes, whatever the grains were
// drawn as.
uint32_t possibleOf(const LodThresholds& thresholds, size_t levels, float band, const SizeRange& sizes);

// What the grains of each run have in common.
void boundRuns(std::span<const rules::SwarmRecord> records, float largest_radius, std::vector<rules::SwarmRun>& runs);
// Notes where the runs are.
void placeRuns(Chunk& chunk, std::span<const rules::SwarmRun> runs);
// Brings the runs into the order of their distance from an eye (relative to the swarm's origin, m), if it has moved so
// far since that this would show, or the grains have: near grains that are drawn first spare the work of what they hide.
void orderRuns(const Chunk& chunk, uint64_t version, Routes& routes, const vec3& eye, RunOrder& scratch);

SystemDesc uploadSystem(const SharedState& state);
SystemDesc giveBackSystem(const SharedState& state);
PassDesc classifyPass(const SharedState& state);
PassDesc listPass(const SharedState& state);
PassDesc lateListPass(const SharedState& state);
PassDesc meshPass(const SharedState& state);
PassDesc lateMeshPass(const SharedState& state);
PassDesc seePass(const SharedState& state);
PassDesc shadowPass(const SharedState& state);
PassDesc viewRoutesPass(const SharedState& state);
PassDesc viewTurnsPass(const SharedState& state);
PassDesc viewOverdrawPass(const SharedState& state);

}  // namespace scree::lod
