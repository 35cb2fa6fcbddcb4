// lod.classify, lod.list, lod.list_late: how each grain is drawn, and the lists that say so.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "modules/lod/state.h"
#include "modules/occlusion/occlusion.h"

namespace scree::lod {
namespace {

constexpr uint32_t kGroup = 64;  // local size of the programs that have an invocation a run

gpu::Program program(std::string name, std::vector<std::string> defines = {}) {
  gpu::ProgramDesc desc;
  desc.compute = "lod/" + name.substr(name.find('.') + 1) + ".comp";
  for (const std::string& define : defines) name += "_" + define;
  desc.name = std::move(name);
  desc.defines = std::move(defines);
  return gpu::Program(std::move(desc));
}

void bindPart(const Part& part, const gpu::StreamSlice& block) {
  block.bindUniform(rules::kPassBinding);
  part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
  part.chunk->runs.bindStorage(rules::kSwarmRunsBinding);
  part.routes->order.bindStorage(rules::kSwarmOrderBinding);
  part.routes->representations.bindStorage(rules::kSwarmRepresentationsBinding);
  part.routes->seen.bindStorage(rules::kSwarmSeenBinding);
  part.routes->counts.bindStorage(rules::kSwarmCountsBinding);
  part.routes->prefix.bindStorage(rules::kSwarmPrefixBinding);
  part.routes->list.bindStorage(rules::kSwarmListBinding);
  part.routes->commands.bindStorage(rules::kSwarmCommandsBinding);
}

void dispatch(const Part& part, size_t groups) { gpu::dispatchIndirect(part.routes->commands, groups); }

constexpr size_t kWalkedGroups = offsetof(rules::SwarmCommands, walked_groups), kFirstGroups = offsetof(rules::SwarmCommands, first_groups),
                 kLateGroups = offsetof(rules::SwarmCommands, late_groups);
constexpr GLbitfield kWalkedBarrier = GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT;

// Prefix sums of the runs' counts, commands, lists. A frame whose first counts find nothing to list, or leave no rest,
// makes no lists of that.
struct ListPrograms {
  gpu::Program commands;
  gpu::Program prefix = program("lod.prefix"), list = program("lod.list");

  void run(const Part& part, size_t list_groups) {
    static_assert(kGroup == rules::kBlockRuns);  // one number of groups for a run an invocation and a block a group
    gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
    if (!prefix.use()) return;
    if (list_groups == kLateGroups)
      dispatch(part, kLateGroups);
    else
      gpu::dispatchItems(part.runs, kGroup);
    gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
    if (!commands.use()) return;
    gpu::dispatch(1);
    gpu::barrier(kWalkedBarrier);
    if (list.use()) dispatch(part, list_groups);
  }
};

}  // namespace

PassDesc classifyPass(const SharedState& state) {
  const auto runs = std::make_shared<gpu::Program>(program("lod.runs"));
  const auto grains = std::make_shared<gpu::Program>(program("lod.classify"));
  return {.name = "lod.classify",
          .stage = Stage::Route,
          .needs_text = "a swarm",
          .needs = [state] { return !state->parts.empty(); },
          .uses = {{std::string(kSwarmRoutes), Access::StorageWrite}, {kSeen, Access::StorageRead}},
          .run = [state, runs, grains](PassContext&) {
            if (state->frozen) return;
            if (state->possible >> rules::kSmallImpostor != 0) {  // points are no candidates
              gpu::barrier(GL_BUFFER_UPDATE_BARRIER_BIT);         // the last frame's programs wrote it
              state->candidates.fill(0);
            }
            state->candidates.bindStorage(rules::kCandidateMapBinding);
            for (const Part& part : state->parts) {
              bindPart(part, part.early);
              if (!runs->use()) return;
              gpu::dispatchItems(part.runs, kGroup);
              gpu::barrier(kWalkedBarrier);
              if (!grains->use()) return;
              dispatch(part, kWalkedGroups);
            }
          }};
}

PassDesc listPass(const SharedState& state) {
  const auto first = std::make_shared<gpu::Program>(program("lod.first"));
  const auto lists = std::make_shared<ListPrograms>(program("lod.commands", {"FIRST"}));
  return {.name = "lod.list",
          .stage = Stage::Route,
          .needs_text = "a swarm",
          .needs = [state] { return !state->parts.empty(); },
          .needs_content = {std::string(kSwarmRoutes)},
          .uses = {{std::string(kSwarmRoutes), Access::StorageWrite},
                   {std::string(kSwarmLists), Access::StorageWrite},
                   {kSeen, Access::StorageWrite}},
          .run = [state, first, lists](PassContext&) {
            if (state->frozen) return;
            state->candidates.bindStorage(rules::kCandidateMapBinding);
            for (const Part& part : state->parts) {
              bindPart(part, part.early);
              if (!first->use()) return;
              dispatch(part, kWalkedGroups);
              lists->run(part, kFirstGroups);
              gpu::barrier(GL_BUFFER_UPDATE_BARRIER_BIT);
              part.routes->seen.fill(0);
            }
          }};
}

PassDesc lateListPass(const SharedState& state) {
  const auto runs = std::make_shared<gpu::Program>(program("lod.hide"));
  const auto grains = std::make_shared<gpu::Program>(program("lod.late"));
  const auto lists = std::make_shared<ListPrograms>(program("lod.commands"));
  return {.name = "lod.list_late",
          .stage = Stage::RouteLate,
          .needs_text = "a swarm that may be more than points",
          .needs = [state] { return state->possible >> rules::kSmallImpostor != 0; },
          .needs_content = {std::string(kSwarmLists)},
          .uses = {{std::string(kSwarmRoutes), Access::StorageWrite},
                   {std::string(kSwarmLists), Access::StorageRead},
                   {std::string(kSwarmLists), Access::Indirect},
                   {std::string(kOcclusionPyramid), Access::Sampled},
                   {std::string(kSwarmLateLists), Access::StorageWrite}},
          .run = [state, runs, grains, lists](PassContext& context) {
            if (state->frozen) return;
            bindPyramid(state->world, context);
            for (const Part& part : state->parts) {
              bindPart(part, part.late);
              if (!runs->use()) return;
              dispatch(part, kLateGroups);
              gpu::barrier(kWalkedBarrier);
              if (!grains->use()) return;
              dispatch(part, kWalkedGroups);
              lists->run(part, kLateGroups);
            }
          }};
}

PassDesc seePass(const SharedState& state) {
  const auto see = std::make_shared<gpu::Program>(program("lod.see"));
  return {.name = "lod.see",
          .stage = Stage::Shade,
          .needs_text = "a swarm that may be more than points",
          .needs = [state] { return state->possible >> rules::kSmallImpostor != 0; },
          .needs_content = {std::string(kSwarmVisible)},
          .uses = {{std::string(kSwarmVisible), Access::Sampled},
                   {std::string(kSwarmLists), Access::Indirect},
                   {kSeen, Access::StorageWrite}},
          .run = [state, see](PassContext& context) {
            if (state->frozen || !see->use()) return;
            context.frame.texture(kSwarmVisible).bind(rules::kPassTextureUnit);
            for (const Part& part : state->parts) {
              bindPart(part, part.early);
              dispatch(part, offsetof(rules::SwarmCommands, see_groups));
            }
          }};
}

}  // namespace scree::lod
