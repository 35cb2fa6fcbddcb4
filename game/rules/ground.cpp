// Sphere against oriented boxes and planes: closest points in the collider's own axes.
#include "game/rules/ground.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "game/rules/rules.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"

namespace scree::hourglass {
namespace {

// Corrections of one call; a corner of three faces needs three, more only refine.
constexpr int kCorrections = 6;

struct Surface {
  double distance;  // negative inside
  dvec3 normal;     // world axes, away from the collider
};

Surface boxSurface(const Transform& transform, const BoxCollider& box, const dvec3& point) {
  const glm::dquat rotation(transform.rotation);
  const dvec3 local = glm::conjugate(rotation) * (point - transform.position);
  const dvec3 extent = dvec3(box.half_extent) * glm::abs(dvec3(transform.scale));
  const dvec3 outside = local - glm::clamp(local, -extent, extent);
  const double length = glm::length(outside);
  if (length > 0) return {length, rotation * (outside / length)};
  const dvec3 depth = extent - glm::abs(local);
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (depth[i] < depth[axis]) axis = i;
  dvec3 normal{0};
  normal[axis] = local[axis] < 0 ? -1 : 1;
  return {-depth[axis], rotation * normal};
}

Surface planeSurface(const Transform& transform, const dvec3& point) {
  const dvec3 normal = glm::dquat(transform.rotation) * dvec3(0, 1, 0);
  return {glm::dot(point - transform.position, normal), normal};
}

template <class Visit>
void eachSurface(World& world, const dvec3& point, Visit visit) {
  world.query<const Transform, const BoxCollider, Without<PloughPart>>().each(
      [&](const Transform& transform, const BoxCollider& box) {
        visit(boxSurface(transform, box, point));
      });
  world.query<const Transform, With<PlaneCollider>>().each(
      [&](const Transform& transform) { visit(planeSurface(transform, point)); });
}

}  // namespace

SphereContact pushOut(World& world, dvec3 center, double radius) {
  SphereContact contact;
  for (int i = 0; i < kCorrections; ++i) {
    Surface nearest{radius, {}};
    eachSurface(world, center, [&](const Surface& surface) {
      if (surface.distance < nearest.distance) nearest = surface;
    });
    if (nearest.distance >= radius) break;
    center += nearest.normal * (radius - nearest.distance);
    if (nearest.normal.y > contact.ground_normal.y) contact.ground_normal = vec3(nearest.normal);
  }
  contact.center = center;
  return contact;
}

bool isSupported(World& world, const dvec3& point, double reach) {
  bool supported = false;
  eachSurface(world, point,
              [&](const Surface& surface) { supported |= surface.distance <= reach; });
  return supported;
}

}  // namespace scree::hourglass
