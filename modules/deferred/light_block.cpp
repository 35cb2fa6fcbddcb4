// deferred.light_block: finds the sun and hands sun and sky to the GPU.
#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "modules/deferred/shadow_map.h"
#include "modules/deferred/state.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/gbuffer.h"

namespace scree {
namespace {

// A scene may hold any number of lights that do not shine.
constexpr size_t kMostLightWarnings = 4;

// Says once of a light, and of a few lights only, what what() says.
template <class What>
void complain(DeferredState& state, Entity entity, const What& what) {
  std::vector<Entity>& warned = state.warned_lights;
  if (warned.size() == kMostLightWarnings ||
      std::find(warned.begin(), warned.end(), entity) != warned.end())
    return;
  warned.push_back(entity);
  logWarning("deferred: light of entity {} {}; it does not shine", entity.index, what());
}

// Colours that are not finite or negative would poison every pixel.
vec3 checkedRadiance(const vec3& radiance) {
  vec3 result(0);
  for (int i = 0; i < 3; ++i)
    if (radiance[i] > 0) result[i] = std::min(radiance[i], rules::kMaxRadiance);
  return result;
}

Sun findSun(DeferredState& state) {
  Sun sun;
  Entity chosen = Entity::kNone;
  state.lights.each([&](Entity entity, const Light& light, const Transform& transform) {
    if (light.kind != LightKind::Directional)
      return complain(state, entity,
                      [] { return "is not directional, which is all that is drawn yet"; });
    const vec3 irradiance = light.color * light.intensity;
    const vec3 to_sun = transform.rotation * vec3(0, 0, 1);
    const float length = glm::length(to_sun);
    if (!finite(irradiance) || glm::any(glm::lessThan(irradiance, vec3(0))) || !(length > 0.5f && length < 2))
      return complain(state, entity, [&light] {
        return fmt::format("has colour ({}, {}, {}) x {} lux: allowed are finite values >= 0",
                           light.color.x, light.color.y, light.color.z, light.intensity);
      });
    if (irradiance == vec3(0)) return;
    if (sun.present && entity.index > chosen.index) return;
    chosen = entity;
    sun = {true, to_sun / length, irradiance};
  });
  return sun;
}

void run(DeferredState& state) {
  World& world = state.world;
  const Sun sun = findSun(state);
  world.singleton<Sun>() = sun;
  beginShadows(world);
  if (!state.batches.any()) state.batches.forget();
  state.shadow_settings = world.singleton<const ShadowSettings>();
  state.exposure = world.singleton<const Exposure>().scale;

  const Sky& sky = world.singleton<const Sky>();
  state.lighting.sky = rules::skyPolynomial(checkedRadiance(sky.zenith), checkedRadiance(sky.horizon),
                                            checkedRadiance(sky.ground));
  state.lighting.to_sun = vec4(sun.to_sun, 0);
  state.lighting.sun_irradiance = vec4(sun.irradiance, 0);
  state.blocks.beginFrame();
  state.blocks.write(state.lighting).bindUniform(rules::kLightingBinding);
}

}  // namespace

SystemDesc lightSystem(const SharedState& state) {
  return {.name = "deferred.light_block",
          .phase = Phase::Prepare,
          .run = [state](World&) { run(*state); }};
}

}  // namespace scree
