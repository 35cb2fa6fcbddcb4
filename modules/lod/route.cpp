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

enum class Lists { First, Late };

void dispatch(const Part& part, size_t groups) { gpu::dispatchIndirect(part.routes->commands, groups); }

// Counts, prefix sums, commands, lists. A frame whose first counts find nothing to list, or leave no rest, makes no
// lists of that.
struct ListPrograms {
  gpu::Program count, commands;
  gpu::Program prefix = program("lod.prefix"), list = program("lod.list");

  ListPrograms(gpu::Program count_in, gpu::Program commands_in)
      : count(std::move(count_in)), commands(std::move(commands_in)) {}

  void run(const Part& part, Lists lists) {
    static_assert(kGroup == rules::kBlockRuns);  // one number of groups for a run an invocation and a block a group
    constexpr size_t kFirstGroups = offsetof(rules::SwarmCommands, first_groups), kLateGroups = offsetof(rules::SwarmCommands, late_groups);
    const auto countStep = [&] {
      if (lists == Lists::Late)
        dispatch(part, kLateGroups);
      else
        gpu::dispatchItems(part.runs, kGroup);
      gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
    };
    bindPart(part, lists == Lists::Late ? part.late : part.early);
    if (!count.use()) return;
    countStep();
    if (!prefix.use()) return;
    countStep();
    if (!commands.use()) return;
    gpu::dispatch(1);
    gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
    if (!list.use()) return;
    dispatch(part, lists == Lists::Late ? kLateGroups : kFirstGroups);
  }
};

}  // namespace

PassDesc classifyPass(const SharedState& state) {
  const auto classify = std::make_shared<gpu::Program>(program("lod.classify"));
  return {.name = "lod.classify",
          .stage = Stage::Route,
          .needs_text = "a swarm",
          .needs = [state] { return !state->parts.empty(); },
          .uses = {{std::string(kSwarmRoutes), Access::StorageWrite}, {kSeen, Access::StorageRead}},
          .run = [state, classify](PassContext&) {
            if (state->frozen || !classify->use()) return;
            gpu::barrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // the last frame's programs wrote it
            state->candidates.fill(0);
            state->candidates.bindStorage(rules::kCandidateMapBinding);
            for (const Part& part : state->parts) {
              bindPart(part, part.early);
              gpu::dispatchItems(part.runs, kGroup);
            }
          }};
}

PassDesc listPass(const SharedState& state) {
  const auto programs =
      std::make_shared<ListPrograms>(program("lod.count"), program("lod.commands", {"FIRST"}));
  return {.name = "lod.list",
          .stage = Stage::Route,
          .needs_text = "a swarm",
          .needs = [state] { return !state->parts.empty(); },
          .needs_content = {std::string(kSwarmRoutes)},
          .uses = {{std::string(kSwarmRoutes), Access::StorageWrite},
                   {std::string(kSwarmLists), Access::StorageWrite},
                   {kSeen, Access::StorageWrite}},
          .run = [state, programs](PassContext&) {
            if (state->frozen) return;
            state->candidates.bindStorage(rules::kCandidateMapBinding);
            for (const Part& part : state->parts) programs->run(part, Lists::First);
          }};
}

PassDesc lateListPass(const SharedState& state) {
  const auto programs = std::make_shared<ListPrograms>(program("lod.count", {"LATE"}), program("lod.commands"));
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
          .run = [state, programs](PassContext& context) {
            if (state->frozen) return;
            bindPyramid(state->world, context);
            for (const Part& part : state->parts) programs->run(part, Lists::Late);
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
