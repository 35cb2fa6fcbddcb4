// The module's part of a saved world: the solver's memory, so that a loaded world goes on to the bit
// as the one that was saved.
#include <fmt/format.h>

#include "engine/core/bytes.h"
#include "engine/core/log.h"
#include "modules/grains/state.h"

namespace scree::grains {
namespace {

constexpr std::string_view kPart = "grains";

// uint8 whether sensors hold what grains did, then the solver's bytes.
std::string save(const GrainsState& state) {
  const std::string solver = state.solver.saved();
  if (solver.empty()) return {};
  ByteWriter out;
  out.content.reserve(solver.size() + 1);
  out.number(static_cast<uint8_t>(state.stepped));
  out.content.append(solver);
  return std::move(out.content);
}

Result<std::function<void()>> load(const std::weak_ptr<GrainsState>& weak, std::string_view bytes,
                                   uint32_t handles) {
  const bool stepped = !bytes.empty() && bytes[0] != 0;
  Result<GrainSolver> solver = GrainSolver::restored(bytes.substr(bytes.empty() ? 0 : 1), handles);
  if (!solver.ok()) return solver.takeError();
  return std::function<void()>(
      [weak, stepped, restored = std::make_shared<GrainSolver>(std::move(solver).value())] {
        const SharedState state = weak.lock();
        if (state == nullptr) return;
        state->solver = std::move(*restored);
        state->stepped = stepped;
        state->rows_seen = state->regions_seen = 0;
        state->regions_of_sleepers.clear();
        // What the world before was pushed by, and told.
        state->forces.clear();
        state->blows.clear();
        state->world.singleton<GrainGrids>().grids.clear();
        GrainStrikes& told = state->world.singleton<GrainStrikes>();
        told.list.clear();
        told.left_out = 0;
      });
}

}  // namespace

void addToSaves(const SharedState& state) {
  const std::weak_ptr<GrainsState> weak = state;
  const Status status = state->world.setPart(
      kPart, {.save = [weak] {
                const SharedState here = weak.lock();
                return here != nullptr ? save(*here) : std::string();
              },
              .load = [weak](std::string_view bytes, uint32_t handles) {
                return load(weak, bytes, handles);
              }});
  if (!status.ok()) logWarning("addGrains: the world's {}: grains start awake", status.error());
}

}  // namespace scree::grains
