// lod.upload: brings swarms that changed to the GPU, and each frame the blocks of constants.
#include <algorithm>

#include <glm/geometric.hpp>

#include "engine/app/app.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"
#include "shaders/shared/candidate.h"
#include "shaders/shared/swarm_view.h"

namespace scree::lod {
namespace {

static_assert(sizeof(rules::SwarmRecord) == 24 && sizeof(rules::SwarmBlock) == 144 && sizeof(rules::SwarmRun) == 32);

uint32_t runsOf(uint32_t count) { return (count + rules::kRunGrains - 1) / rules::kRunGrains; }

// Index counts and places of the levels; the rest of the commands is written on the GPU.
rules::SwarmCommands commandsOf(const MeshStore& meshes, const GrainShape& shape) {
  rules::SwarmCommands commands{};
  for (size_t level = 0; level < shape.levels.size(); ++level) {
    const std::vector<MeshPart>& parts = meshes.mesh(shape.levels[level].mesh).parts;
    for (size_t k = 0; k < parts.size(); ++k)
      for (const uint32_t first : {0u, rules::kFirst})
        commands.meshes[rules::meshCommand(rules::kMesh + static_cast<uint32_t>(level) + first, static_cast<uint32_t>(k))] = {
            parts[k].index_count, 0, parts[k].first_index, parts[k].base_vertex, 0};
  }
  return commands;
}

Chunk chunkOf(std::span<const rules::SwarmRecord> records, std::span<const rules::SwarmRun> bounds, const rules::SwarmCommands& commands) {
  Chunk chunk;
  chunk.count = static_cast<uint32_t>(records.size());
  const size_t runs = runsOf(chunk.count), blocks = (runs + rules::kBlockRuns - 1) / rules::kBlockRuns;
  chunk.records = gpu::Buffer("lod.records", records);
  chunk.runs = gpu::Buffer("lod.runs", bounds);
  chunk.drift = driftOf(bounds);
  chunk.representations = gpu::Buffer("lod.representations", 4 * rules::kRunWords * runs);
  chunk.representations.fill(0);
  chunk.seen = gpu::Buffer("lod.seen", 4 * rules::kRunSeenWords * runs);
  chunk.seen.fill(0);
  chunk.counts = gpu::Buffer("lod.counts", 4 * rules::kCountWords * runs);
  chunk.prefix = gpu::Buffer("lod.prefix", 4 * rules::kRepresentations * (runs + blocks));
  chunk.list = gpu::Buffer("lod.list", 4 * size_t{chunk.count});
  chunk.commands = gpu::Buffer("lod.commands", sizeof(commands), &commands);
  return chunk;
}

void makeResident(Resident& resident, const SwarmStore& store, const MeshStore& meshes, std::vector<rules::SwarmRun>& runs) {
  const SwarmStore::Stored& stored = store.swarm(resident.swarm);
  if (resident.version == stored.version) return;
  resident.version = stored.version;
  // As many grains as before: what they were drawn as, and the buffers, stay.
  const auto fits = [&](size_t k) {
    return k < resident.chunks.size() && resident.chunks[k].count == stored.chunks[k].size();
  };
  for (size_t k = 0; k < stored.chunks.size(); ++k) {
    const std::span<const rules::SwarmRecord> records(stored.chunks[k]);
    boundRuns(records, stored.largest_radius, runs);
    const std::span<const rules::SwarmRun> bounds(runs);
    if (fits(k)) {
      resident.chunks[k].drift = driftOf(bounds);
      resident.chunks[k].records.upload(records);
      resident.chunks[k].runs.upload(bounds);
      continue;
    }
    if (k == resident.chunks.size()) resident.chunks.emplace_back();
    resident.chunks[k] = chunkOf(records, bounds, commandsOf(meshes, store.shape(stored.shape)));
  }
  resident.chunks.resize(stored.chunks.size());
}

void reserveCandidates(gpu::Buffer& candidates, ivec2 size) {
  const size_t cells = rules::candidateBegin(size, rules::kCandidateLevels);
  gpu::reserve(candidates, "lod.candidates", 4 * cells);
}

struct Placed {
  const Resident* resident;
  const Transform* transform;
  Entity entity;
  bool casts;
};

uint32_t possibleOf(const LodThresholds& t, size_t levels) {
  uint32_t possible = 0;
  const auto add = [&](uint32_t representation) { possible |= 1u << representation; };
  if (t.point_px > 0) add(rules::kPoint);
  if (t.impostor_px > t.impostor_from_px) {
    if (t.impostor_from_px < t.small_px) add(rules::kSmallImpostor);
    if (t.impostor_px > t.small_px) add(rules::kImpostor);
  }
  const float most = std::max(t.point_px, t.impostor_px);
  if (most > rules::kLargestPx) return possible;  // one for all sizes
  for (uint32_t level = 0; level < levels; ++level) add(rules::kMesh + level);
  return possible;
}

// What the last frame tells of this one, for a ball of grains. Near: the camera has neither gone far, as seen from
// there, nor turned much, so that most of what was seen is seen again.
enum class Knows { Nothing, Near, Same };
Knows knowsWhatWasSeen(const SwarmsDrawn::State& state, const View& view, const vec3& center, float extent) {
  if (!state.drew || state.world.singleton<const FrameInput>().frame > state.last_frame + 1) return Knows::Nothing;
  const float away = std::max(glm::length(center) - extent, 0.1f * extent);
  const double moved = glm::length(view.position - state.last_camera);
  const float turned = 1 - std::abs(glm::dot(view.rotation, state.last_rotation));
  if (!(moved < 0.1 * static_cast<double>(away) && turned < 0.004f)) return Knows::Nothing;
  return moved == 0 && view.rotation == state.last_rotation ? Knows::Same : Knows::Near;
}

void addParts(SwarmsDrawn::State& state, const Placed& placed, const View& view, const LodSettings& settings) {
  const SwarmStore& store = state.world.singleton<const SwarmStore>();
  const SwarmStore::Stored& stored = store.swarm(placed.resident->swarm);
  const GrainShape& shape = store.shape(stored.shape);
  const dvec3 origin = placed.transform->position;
  rules::SwarmBlock block{};
  block.origin = vec4(vec3(origin - view.position), stored.largest_radius);
  block.previous_origin =
      vec4(vec3(origin - view.previous_position), shape.inner_radius / shape.outer_radius);
  block.center_scale = vec4(shape.center, 1 / shape.outer_radius);
  block.albedo = vec4(shape.albedo, shape.cast_share);
  block.roughness = shape.roughness;
  block.metallic = shape.metallic;
  const vec3 middle = vec3(block.origin) + 0.5f * (stored.min + stored.max);
  const Knows knows = knowsWhatWasSeen(state, view, middle, 0.5f * glm::length(stored.max - stored.min));
  block.candidate_cell = knows == Knows::Nothing ? rules::kCandidateCell
                         : knows == Knows::Near  ? rules::kCandidateCellMoving
                                                 : rules::kCandidateCellStill;
  const LodThresholds t = thresholdsOf(shape, settings, view.block.pixels_at_1m);
  block.mesh_px = vec4(t.mesh_px[0], t.mesh_px[1], t.mesh_px[2], t.mesh_px[3]);
  block.point_px = t.point_px;
  block.impostor_px = t.impostor_px;
  block.impostor_from_px = t.impostor_from_px;
  block.small_px = t.small_px;
  block.band = settings.band;
  block.cull = settings.cull ? 1 : 0;
  const bool grains_apart = settings.view == SwarmView::Representation || settings.view == SwarmView::Frozen;
  block.same_id = grains_apart ? 0 : 1;
  for (const Chunk& chunk : placed.resident->chunks) {
    block.count = chunk.count;
    block.first = static_cast<uint32_t>(state.grain_count);
    block.first_id = grains_apart ? rules::kGrainIdBit | (block.first + 1) : placed.entity.index + 1;
    block.run_count = runsOf(chunk.count);
    block.last_first = glm::dot(chunk.drift, view.rotation * vec3(0, 0, -1)) < 0 ? 1 : 0;
    Part part;
    part.shape = stored.shape;
    part.first = block.first;
    part.count = chunk.count;
    part.runs = block.run_count;
    part.list = &chunk.list;
    part.commands = &chunk.commands;
    part.chunk = &chunk;
    part.thresholds = t;
    part.casts = placed.casts;
    part.cast_share = shape.cast_share;
    part.largest_radius = stored.largest_radius;
    constexpr uint32_t kLate = (1u << rules::kFirst) - (1u << rules::kSmallImpostor);
    block.listed = kLate << rules::kFirst;
    part.early = state.blocks.write(block);
    block.listed = kLate;
    part.late = state.blocks.write(block);
    state.parts.push_back(part);
    state.grain_count += chunk.count;
    state.possible |= possibleOf(t, shape.levels.size());
  }
}

// Tells the shadow map's fit where the swarm is, and notes what its shadow depends on.
void addCaster(SwarmsDrawn::State& state, const Placed& placed, std::vector<CasterSeen>& seen) {
  if (!placed.casts) return;
  const SwarmStore::Stored& stored = state.world.singleton<const SwarmStore>().swarm(placed.resident->swarm);
  if (stored.count == 0) return;
  const dvec3 origin = placed.transform->position;
  const vec3 half = 0.5f * (stored.max - stored.min);
  state.world.singleton<ShadowCasters>().spheres.push_back(
      {origin + dvec3(0.5f * (stored.min + stored.max)), glm::length(half) + stored.largest_radius});
  seen.push_back({placed.resident->swarm, stored.version, origin});
  state.casts = true;
}

void upload(SwarmsDrawn::State& state) {
  World& world = state.world;
  const View& view = world.singleton<const View>();
  const LodSettings& settings = world.singleton<const LodSettings>();
  const SwarmStore& store = world.singleton<const SwarmStore>();
  const MeshStore& meshes = world.singleton<const MeshStore>();
  state.parts.clear();
  state.grain_count = 0;
  state.possible = 0;
  state.casts = false;
  std::vector<CasterSeen>& seen = state.casters_now;
  seen.clear();
  state.blocks.beginFrame();
  state.resident.resize(store.swarmCount());
  state.swarms.each([&](Entity entity, const Swarm& swarm, const Transform& transform) {
    store.swarm(swarm.swarm);
    Resident& resident = state.resident[swarm.swarm];
    resident.swarm = swarm.swarm;
    makeResident(resident, store, meshes, state.runs_scratch);
    const Placed placed{&resident, &transform, entity, world.has<CastsShadow>(entity)};
    addParts(state, placed, view, settings);
    addCaster(state, placed, seen);
  });
  state.drew = !state.parts.empty();
  state.frozen = settings.view == SwarmView::Frozen && state.routed && state.drew;
  state.routed = state.drew;
  if (!state.frozen) {
    state.last_camera = view.position;
    state.last_rotation = view.rotation;
    state.last_frame = world.singleton<const FrameInput>().frame;
  }
  if (seen != state.casters_seen) {
    std::swap(seen, state.casters_seen);
    ++state.casters_version;
  }
  reserveCandidates(state.candidates, world.singleton<const FrameInput>().size);
}

}  // namespace

SystemDesc uploadSystem(const SharedState& state) {
  return {.name = "lod.upload",
          .phase = Phase::Prepare,
          .needs = [state] { return !state->swarms.empty() || !state->parts.empty(); },
          .run = [state](World&) { upload(*state); }};
}

}  // namespace scree::lod
