// lod.upload: brings swarms that changed to the GPU, and each frame the blocks of constants.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include <glm/geometric.hpp>

#include "engine/app/app.h"
#include "engine/core/log.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"
#include "shaders/shared/candidate.h"
#include "shaders/shared/swarm_view.h"

namespace scree::lod {
namespace {

static_assert(sizeof(rules::SwarmRecord) == 24 && sizeof(rules::SwarmBlock) == 208 && sizeof(rules::SwarmRun) == 32);

uint32_t runsOf(uint32_t count) { return (count + rules::kRunGrains - 1) / rules::kRunGrains; }

// Index counts and places of the levels; the rest of the commands is written on the GPU.
rules::SwarmCommands commandsOf(const MeshStore& meshes, const GrainShape& shape) {
  rules::SwarmCommands commands{};
  commands.walked_groups[1] = commands.walked_groups[2] = 1;
  for (size_t level = 0; level < shape.levels.size(); ++level) {
    const std::vector<MeshPart>& parts = meshes.mesh(shape.levels[level].mesh).parts;
    if (parts.size() > rules::kMeshParts)
      fail(fmt::format("lod.upload: shape \"{}\": level {}: {} parts of different materials; at most {} are allowed", shape.name, level,
                       parts.size(), rules::kMeshParts));
    for (size_t k = 0; k < parts.size(); ++k)
      for (const uint32_t first : {0u, rules::kFirst})
        commands.meshes[rules::meshCommand(rules::kMesh + static_cast<uint32_t>(level) + first, static_cast<uint32_t>(k))] = {
            parts[k].index_count, 0, parts[k].first_index, parts[k].base_vertex, 0};
  }
  return commands;
}

Chunk chunkOf(std::span<const rules::SwarmRecord> records, std::span<const rules::SwarmRun> bounds) {
  Chunk chunk;
  chunk.count = static_cast<uint32_t>(records.size());
  chunk.records = gpu::Buffer("lod.records", records);
  chunk.runs = gpu::Buffer("lod.runs", bounds);
  placeRuns(chunk, bounds);
  return chunk;
}

Routes routesOf(uint32_t count, const rules::SwarmCommands& commands) {
  Routes routes;
  routes.count = count;
  const size_t runs = runsOf(count), blocks = (runs + rules::kBlockRuns - 1) / rules::kBlockRuns;
  routes.representations = gpu::Buffer("lod.representations", 4 * rules::kRunWords * runs);
  routes.representations.fill(0);
  routes.seen = gpu::Buffer("lod.seen", 4 * rules::kRunSeenWords * runs);
  routes.seen.fill(0);
  routes.counts = gpu::Buffer("lod.counts", 4 * rules::kCountWords * runs);
  routes.counts.fill(0);
  routes.prefix = gpu::Buffer("lod.prefix", 4 * rules::kRepresentations * (runs + blocks));
  routes.list = gpu::Buffer("lod.list", 4 * size_t{count});
  routes.commands = gpu::Buffer("lod.commands", sizeof(commands), &commands);
  return routes;
}

void makeResident(Resident& resident, const SwarmStore::Stored& stored, std::vector<rules::SwarmRun>& runs) {
  resident.drawn = true;
  if (resident.version == stored.version) return;
  resident.version = stored.version;
  for (size_t k = 0; k < stored.chunks.size(); ++k) {
    const std::span<const rules::SwarmRecord> records(stored.chunks[k]);
    boundRuns(records, stored.largest_radius, runs);
    const std::span<const rules::SwarmRun> bounds(runs);
    if (k == resident.chunks.size()) resident.chunks.emplace_back();
    Chunk& chunk = resident.chunks[k];
    if (chunk.count != records.size()) {
      chunk = chunkOf(records, bounds);
      continue;
    }
    placeRuns(chunk, bounds);
    chunk.records.upload(records);
    chunk.runs.upload(bounds);
  }
  resident.chunks.resize(stored.chunks.size());
}

// Where as many grains as before have moved, what they were drawn as stays.
void makeRoutes(Placement& placement, const Resident& resident, const rules::SwarmCommands& commands) {
  placement.routes.resize(resident.chunks.size());
  for (size_t k = 0; k < resident.chunks.size(); ++k)
    if (placement.routes[k].count != resident.chunks[k].count)
      placement.routes[k] = routesOf(resident.chunks[k].count, commands);
}

// The entity's, made if it is new or has another swarm. `at`: where it is likely to be.
Placement& placementOf(std::vector<Placement>& placements, size_t at, Entity entity, uint32_t swarm) {
  if (at >= placements.size() || placements[at].entity != entity)
    at = static_cast<size_t>(std::ranges::find(placements, entity, &Placement::entity) - placements.begin());
  if (at == placements.size()) placements.emplace_back();
  Placement& placement = placements[at];
  if (placement.entity != entity || placement.swarm != swarm) placement = {.entity = entity, .swarm = swarm};
  placement.drawn = true;
  return placement;
}

void reserveCandidates(gpu::Buffer& candidates, ivec2 size) {
  const size_t cells = rules::candidateBegin(size, rules::kCandidateLevels);
  gpu::reserve(candidates, "lod.candidates", 4 * cells);
}

struct Placed {
  const Resident* resident;
  Placement* placement;
  dvec3 origin, previous_origin;  // in this frame and in the last
  bool casts;
};

// What the last frame tells of this one, for a ball of grains. Near: the camera has neither gone far from there, as
// seen from there, nor turned or zoomed, so that most of what was seen is seen again.
enum class Knows { Nothing, Near, Same };
Knows knowsWhatWasSeen(const SwarmsDrawn::State& state, const View& view, const Placed& placed, const vec3& center, float extent) {
  if (!placed.placement->drew || state.world.singleton<const FrameInput>().frame > state.last_frame + 1) return Knows::Nothing;
  if (view.block.size_px != state.last_size_px || view.block.pixels_at_1m != state.last_pixels_at_1m) return Knows::Nothing;
  const float away = std::max(glm::length(center) - extent, 0.1f * extent);
  const double moved = glm::length((view.position - placed.origin) - (state.last_camera - placed.placement->origin));
  const float turned = 1 - std::abs(glm::dot(view.rotation, state.last_rotation));
  if (!(moved < 0.1 * static_cast<double>(away) && turned < 0.004f)) return Knows::Nothing;
  const bool same = moved == 0 && view.rotation == state.last_rotation && placed.placement->version == placed.resident->version;
  return same ? Knows::Same : Knows::Near;
}

void addParts(SwarmsDrawn::State& state, const Placed& placed, const View& view, const LodSettings& settings) {
  const SwarmStore& store = state.world.singleton<const SwarmStore>();
  const SwarmStore::Stored& stored = store.swarm(placed.placement->swarm);
  const GrainShape& shape = store.shape(stored.shape);
  rules::SwarmBlock block{};
  block.origin = vec4(vec3(placed.origin - view.position), stored.largest_radius);
  block.previous_origin = vec4(vec3(placed.previous_origin - view.previous_position), shape.inner_radius / shape.outer_radius);
  block.center_scale = vec4(shape.center, 1 / shape.outer_radius);
  block.albedo = vec4(shape.albedo, shape.cast_share);
  block.bound = shape.bound;
  block.roughness = shape.roughness;
  block.metallic = shape.metallic;
  const vec3 middle = vec3(block.origin) + 0.5f * (stored.min + stored.max);
  const Knows knows = knowsWhatWasSeen(state, view, placed, middle, 0.5f * glm::length(stored.max - stored.min));
  block.candidate_cell = knows == Knows::Nothing ? rules::kCandidateCell
                         : knows == Knows::Near  ? rules::kCandidateCellMoving
                                                 : rules::kCandidateCellStill;
  const vec2 corner(view.block.tan_half_fov_x, view.block.tan_half_fov_y);
  const LodThresholds t = thresholdsOf(shape, settings, view.block.pixels_at_1m, 1 + glm::dot(corner, corner));
  const float band = std::max(notNan(settings.band), 0.0f);
  setThresholds(block, t, band);
  const uint32_t possible = possibleOf(t, shape.levels.size(), band, sizesOf(stored, vec3(block.origin), view.block.pixels_at_1m));
  state.possible |= possible;
  block.cull = settings.cull ? 1 : 0;
  const bool grains_apart = settings.view == SwarmView::Representation || settings.view == SwarmView::Frozen;
  block.same_id = grains_apart ? 0 : 1;
  for (size_t k = 0; k < placed.resident->chunks.size(); ++k) {
    const Chunk& chunk = placed.resident->chunks[k];
    Routes& routes = placed.placement->routes[k];
    block.count = chunk.count;
    block.first = static_cast<uint32_t>(state.grain_count);
    block.first_id = grains_apart ? rules::kGrainIdBit | (block.first + 1) : placed.placement->entity.index + 1;
    block.run_count = runsOf(chunk.count);
    block.rank_seed = placed.placement->entity.index + (static_cast<uint32_t>(k) << 24);
    if (!state.frozen || routes.ordered_version == 0) orderRuns(chunk, placed.resident->version, routes, -vec3(block.origin), state.order_scratch);
    Part part;
    part.shape = stored.shape;
    part.first = block.first;
    part.count = chunk.count;
    part.runs = block.run_count;
    part.list = &routes.list;
    part.commands = &routes.commands;
    part.chunk = &chunk;
    part.routes = &routes;
    part.thresholds = t;
    part.casts = placed.casts;
    part.cast_share = shape.cast_share;
    part.largest_radius = stored.largest_radius;
    part.least_roughness = stored.least_roughness;
    part.most_roughness = stored.most_roughness;
    part.possible = possible;
    constexpr uint32_t kLate = (1u << rules::kFirst) - (1u << rules::kSmallImpostor);
    block.listed = kLate << rules::kFirst;
    part.early = state.blocks.write(block);
    block.listed = kLate;
    part.late = state.blocks.write(block);
    state.parts.push_back(part);
    state.grain_count += chunk.count;
  }
}

// Tells the shadow map's fit where the swarm is, and notes what its shadow depends on.
void addCaster(SwarmsDrawn::State& state, const Placed& placed, std::vector<CasterSeen>& seen) {
  if (!placed.casts) return;
  const SwarmStore::Stored& stored = state.world.singleton<const SwarmStore>().swarm(placed.placement->swarm);
  const vec3 half = 0.5f * (stored.max - stored.min);
  state.world.singleton<ShadowCasters>().spheres.push_back(
      {placed.origin + dvec3(0.5f * (stored.min + stored.max)), glm::length(half) + stored.largest_radius});
  seen.push_back({placed.placement->swarm, stored.version, placed.origin});
  state.casts = true;
}

// Where the entity is between two ticks, and was in the last frame.
Placed placedAt(World& world, Entity entity, const Transform& transform) {
  const FrameInput& input = world.singleton<const FrameInput>();
  Placed placed{nullptr, nullptr, transform.position, transform.position, world.has<CastsShadow>(entity)};
  if (const PreviousTransform* previous = world.peek<PreviousTransform>(entity)) {
    placed.origin = interpolate(*previous, transform, input.alpha).position;
    placed.previous_origin = interpolate(*previous, transform, double{input.alpha} - input.motion_scale).position;
  }
  return placed;
}

// Gives back what this frame does not draw.
void dropTheRest(SwarmsDrawn::State& state) {
  for (Resident& resident : state.resident)
    if (!std::exchange(resident.drawn, false)) resident = {};
  std::erase_if(state.placements, [](const Placement& placement) { return !placement.drawn; });
  for (Placement& placement : state.placements) placement.drew = std::exchange(placement.drawn, false);
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
  state.resident.resize(store.swarmCount());
  size_t number = 0;
  state.swarms.each([&](Entity entity, const Swarm& swarm, const Transform& transform) {
    const SwarmStore::Stored& stored = store.swarm(swarm.swarm);
    if (stored.count == 0) return;
    if (state.parts.empty()) state.blocks.beginFrame();
    Resident& resident = state.resident[swarm.swarm];
    makeResident(resident, stored, state.runs_scratch);
    Placed placed = placedAt(world, entity, transform);
    placed.resident = &resident;
    placed.placement = &placementOf(state.placements, number++, entity, swarm.swarm);
    makeRoutes(*placed.placement, resident, commandsOf(meshes, store.shape(stored.shape)));
    addParts(state, placed, view, settings);
    addCaster(state, placed, seen);
    placed.placement->origin = placed.origin;
    placed.placement->version = resident.version;
  });
  dropTheRest(state);
  const bool drew = !state.parts.empty();
  state.frozen = settings.view == SwarmView::Frozen && state.routed && drew;
  state.routed = drew;
  if (state.frozen)
    state.possible = state.routed_possible;
  else
    state.routed_possible = state.possible;
  if (!state.frozen) {
    state.last_camera = view.position;
    state.last_rotation = view.rotation;
    state.last_size_px = view.block.size_px;
    state.last_pixels_at_1m = view.block.pixels_at_1m;
    state.last_frame = world.singleton<const FrameInput>().frame;
  }
  if (seen != state.casters_seen) {
    std::swap(seen, state.casters_seen);
    ++state.casters_version;
  }
  if (state.casts)
    world.singleton<ShadowCasters>().drawings.push_back({"lod.shadow", state.casters_version, state.casters_seen.size()});
  if (drew) reserveCandidates(state.candidates, world.singleton<const FrameInput>().size);
}

}  // namespace

SystemDesc uploadSystem(const SharedState& state) {
  return {.name = "lod.upload",
          .phase = Phase::Prepare,
          .needs = [state] { return !state->swarms.empty() || !state->parts.empty(); },
          .run = [state](World&) { upload(*state); }};
}

}  // namespace scree::lod
