// Fits the shadow map to a frame's casters, and finds whether it shows them already.
#include "modules/deferred/shadow_map.h"

#include "engine/ecs/world.h"
#include "engine/gpu/counters.h"

namespace scree {
namespace {

bool allTold(const ShadowCasters& casters) {
  size_t told = 0;
  for (const ShadowCasters::Drawing& drawing : casters.drawings) told += drawing.spheres;
  return told == casters.spheres.size();
}

void decide(World& world, ShadowMap& map) {
  const ShadowCasters& casters = world.singleton<const ShadowCasters>();
  const Sun& sun = world.singleton<const Sun>();
  ShadowView& view = world.singleton<ShadowView>();
  map.decided = true;
  map.wanted = false;
  view.block = {};
  if (!sun.present || casters.spheres.empty()) return;
  const ShadowSettings& settings = world.singleton<const ShadowSettings>();
  const dvec3 camera = world.singleton<const View>().position;
  const int side = shadowMapSide(settings, world.singleton<const FrameInput>().size.y);
  const ShadowFit fit = fitShadow(casters.spheres, camera, sun.to_sun, side, settings.max_distance_m);
  const uint64_t reloads = gpu::counters().reloads;
  if (view.version == 0 || fit != map.fit || reloads != map.reloads) ++view.version;
  map.fit = fit;
  map.reloads = reloads;
  view.block = shadowViewBlock(fit, camera);
  if (!fit.enabled) return;
  const bool told = allTold(casters);
  map.due.view_version = told ? view.version : 0;
  map.due.drawings = casters.drawings;
  map.wanted = !told || map.due != map.shown;
}

}  // namespace

void beginShadows(World& world) {
  ShadowCasters& casters = world.singleton<ShadowCasters>();
  casters.spheres.clear();
  casters.drawings.clear();
  world.singleton<ShadowMap>().decided = false;
}

// Once a frame, when all systems of Phase::Prepare have said what they draw.
bool shadowsWanted(World& world) {
  ShadowMap& map = world.singleton<ShadowMap>();
  if (!map.decided) decide(world, map);
  return map.wanted;
}

}  // namespace scree
