// deferred.gather: culls mesh instances and uploads what the mesh passes draw.
#include "engine/core/log.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

void run(DeferredState& state) {
  World& world = state.world;
  MeshBatches& batches = state.batches;
  ShadowCasters& casters = world.singleton<ShadowCasters>();
  batches.update(world, world.singleton<const FrameInput>(), world.singleton<const View>(),
                 world.singleton<const Sun>().present, casters);
  state.plain_in_view = state.emission_in_view = false;
  const size_t casting = batches.castingCount(true) + batches.castingCount(false);
  if (casting > 0) casters.drawings.push_back({"deferred.shadow", batches.castingVersion(), casting});
  if (batches.opaqueCount() + casting == 0) return;
  state.materials.update(world.singleton<const MaterialStore>());
  state.instances.beginFrame();
  if (batches.opaqueCount() == 0) return;
  state.opaque_records =
      state.instances.allocate(batches.opaqueCount() * sizeof(rules::MeshInstanceRecord));
  batches.writeOpaque({static_cast<rules::MeshInstanceRecord*>(state.opaque_records.data),
                       batches.opaqueCount()});
  const MeshStore& meshes = world.singleton<const MeshStore>();
  for (const MeshBatch& batch : batches.opaque())
    for (const MeshPart& part : meshes.mesh(batch.mesh).parts)
      (state.materials.features(materialOf(batch, part)) & kFeatureEmission ? state.emission_in_view
                                                                            : state.plain_in_view) = true;
}

}  // namespace

SystemDesc gatherSystem(const SharedState& state) {
  return {.name = "deferred.gather",
          .phase = Phase::Prepare,
          .needs = [state] { return state->batches.any(); },
          .run = [state](World&) { run(*state); }};
}

}  // namespace scree
