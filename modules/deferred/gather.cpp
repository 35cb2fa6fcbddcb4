// deferred.gather: culls mesh instances and uploads what the mesh passes draw.
#include "engine/core/log.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

// Fills a slice of the stream with `count` records; an empty slice if there are none.
template <class Record, class Write>
gpu::StreamSlice upload(gpu::StreamBuffer& stream, size_t count, const Write& write) {
  if (count == 0) return {};
  const gpu::StreamSlice slice = stream.allocate(count * sizeof(Record));
  write(std::span(static_cast<Record*>(slice.data), count));
  return slice;
}

void run(DeferredState& state) {
  World& world = state.world;
  MeshBatches& batches = state.batches;
  batches.update(world, world.singleton<const FrameInput>(), world.singleton<const View>(),
                 world.singleton<const Sun>().present, world.singleton<ShadowCasters>());
  if (batches.opaqueCount() + batches.castingCount() == 0) return;
  state.materials.update(world.singleton<const MaterialStore>());
  state.instances.beginFrame();
  state.opaque_records = upload<rules::MeshInstanceRecord>(
      state.instances, batches.opaqueCount(), [&](auto records) { batches.writeOpaque(records); });
  state.caster_records = upload<rules::MeshCasterRecord>(
      state.instances, batches.castingCount(), [&](auto records) { batches.writeCasting(records); });
}

}  // namespace

SystemDesc gatherSystem(const SharedState& state) {
  return {.name = "deferred.gather",
          .phase = Phase::Prepare,
          .needs = [state] { return state->batches.any(); },
          .run = [state](World&) { run(*state); }};
}

}  // namespace scree
