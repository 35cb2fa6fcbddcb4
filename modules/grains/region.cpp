// Regions from Transforms, and what is said of components that are refused.
#include "modules/grains/region.h"

#include <algorithm>

#include "engine/core/log.h"

namespace scree::grains {

Region regionOf(const Transform& transform, vec3 half_extent, float radius, const dvec3& origin) {
  Region region;
  region.centre = vec3(transform.position - origin);
  region.world_from_local = glm::mat3_cast(glm::normalize(transform.rotation));
  const vec3 scale = glm::abs(transform.scale);
  region.half = half_extent * scale;
  region.radius = radius * std::max({scale.x, scale.y, scale.z});
  const mat3& m = region.world_from_local;
  const vec3 reach = radius > 0 ? vec3(region.radius)
                                : glm::abs(m[0]) * region.half.x + glm::abs(m[1]) * region.half.y +
                                      glm::abs(m[2]) * region.half.z;
  // Float arithmetic may put a point of the rim just outside: a little more.
  const vec3 slack = 1e-5f * (reach + glm::abs(region.centre)) + 1e-6f;
  region.low = region.centre - reach - slack;
  region.high = region.centre + reach + slack;
  return region;
}

std::string faultOf(const Transform& transform, const dvec3& origin, vec3 size) {
  const dvec3 p = transform.position - origin;
  const float q = glm::dot(transform.rotation, transform.rotation);
  const vec3 s = transform.scale;
  if (!(q > 0.25f && q < 4 && std::isfinite(s.x + s.y + s.z)))
    return "its Transform must be finite, with a unit rotation";
  const double farthest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  if (!(farthest <= static_cast<double>(kMostDistance)) || !std::isfinite(p.x + p.y + p.z))
    return "its Transform must be within 1e9 m of the field's origin";
  const vec3 scale = glm::abs(s), scaled = size * std::max({scale.x, scale.y, scale.z});
  if (!(std::max({scaled.x, scaled.y, scaled.z}) <= kMostDistance))
    return "scaled, it must be no larger than 1e9 m";
  return {};
}

void refuse(Refusals& refusals, const World& world, const char* system, const char* component,
            Entity entity, const std::string& wrong) {
  if (refusals.now++ == 0 && refusals.before == 0)
    logWarning("{}: {} of {} refused: {}", system, component, nameOf(world, entity), wrong);
}

void closeRefusals(Refusals& refusals) {
  refusals.before = refusals.now;
  refusals.now = 0;
}

}  // namespace scree::grains
