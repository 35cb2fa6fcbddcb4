// The solver's strikes as the game is told them.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "modules/grains/state.h"

namespace scree::grains {
namespace {

// Of a collider's key; Entity::kNone if it has gone.
Entity colliderOf(const GrainsState& state, uint32_t key) {
  for (const Entity entity : state.collider_entities)
    if (entity.index == key / kKeysOfEntity) return entity;
  return Entity::kNone;
}

}  // namespace

void tellStrikes(GrainsState& state, const dvec3& origin) {
  const GrainStrikes& asked = state.world.singleton<const GrainStrikes>();
  const std::span<const Strike> found = state.solver.strikes();
  if (found.empty() && asked.list.empty() && asked.left_out == 0) return;
  GrainStrikes& told = state.world.singleton<GrainStrikes>();
  told.list.clear();
  std::vector<uint32_t>& order = state.strike_order;
  order.resize(found.size());
  for (uint32_t k = 0; k < order.size(); ++k) order[k] = k;
  const size_t kept = std::min<size_t>({found.size(), told.most, kMostStrikes});
  const auto stronger = [&](uint32_t a, uint32_t b) {
    return found[a].impulse != found[b].impulse ? found[a].impulse > found[b].impulse : a < b;
  };
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                    stronger);
  for (size_t k = 0; k < kept; ++k) {
    const Strike& strike = found[order[k]];
    const bool collider = strike.b == Entity::kNone;
    told.list.push_back({.position = origin + dvec3(strike.position),
                         .normal = strike.normal,
                         .impulse = strike.impulse,
                         .speed = strike.speed,
                         .a = strike.a,
                         .b = collider ? colliderOf(state, strike.collider) : strike.b,
                         .collider = collider});
  }
  told.left_out = found.size() - kept;
}

}  // namespace scree::grains
