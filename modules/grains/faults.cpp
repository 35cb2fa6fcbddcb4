// What a file, or a program, may say of the module's components.
#include <fmt/format.h>

#include "modules/grains/ranges.h"

namespace scree {
namespace {

using namespace grains;

constexpr const char* kOwn = "is made by the simulation itself; spawn grains with a GrainBlock";

template <class Surface>
std::string surfaceFault(const Surface& s) {
  return firstFault({{"friction", s.friction, 0, kMostFriction},
                     {"rolling_friction", s.rolling_friction, 0, kMostFriction},
                     {"restitution", s.restitution, 0, 1},
                     {"cohesion", s.cohesion, 0, kMostCohesion},
                     {"surface_velocity.x", s.surface_velocity.x, -1e5, 1e5},
                     {"surface_velocity.y", s.surface_velocity.y, -1e5, 1e5},
                     {"surface_velocity.z", s.surface_velocity.z, -1e5, 1e5}});
}

}  // namespace

std::string fault(const GrainField& f) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(f.bounds_min[axis] < f.bounds_max[axis]))
      return fmt::format("bounds_min.{0} = {1}; allowed is less than bounds_max.{0} = {2}", "xyz"[axis],
                         f.bounds_min[axis], f.bounds_max[axis]);
  }
  return firstFault({{"origin.x", f.origin.x, -kMostSize, kMostSize},
                     {"origin.y", f.origin.y, -kMostSize, kMostSize},
                     {"origin.z", f.origin.z, -kMostSize, kMostSize},
                     {"gravity.x", f.gravity.x, -1e4, 1e4},
                     {"gravity.y", f.gravity.y, -1e4, 1e4},
                     {"gravity.z", f.gravity.z, -1e4, 1e4},
                     {"substeps", static_cast<double>(f.substeps), 1, 64},
                     {"passes", static_cast<double>(f.passes), 1, 64},
                     {"damping", f.damping, 0, 60}});
}

std::string fault(const GrainBlock& b) {
  double total = 1;
  for (const int32_t n : b.count) {
    if (n < 0) return fmt::format("count = {}; allowed is 0 or more", n);
    total *= n;
  }
  const float largest = b.radius * (1 + b.radius_jitter);
  std::string wrong = firstOf(firstFault({{"the product of count", total, 0, kMaxGrains}}), kindFault(b));
  if (wrong.empty() && b.spacing != 0)  // 0: chosen by the size
    wrong = firstFault({{"spacing", b.spacing, 2.0 * largest, 1e6}});
  return wrong;
}

std::string fault(const PlaneCollider& plane) { return surfaceFault(plane); }
std::string fault(const BoxCollider& box) {
  return firstOf(sizeFault(box.half_extent), surfaceFault(box));
}
std::string fault(const CapsuleCollider& c) {
  return firstOf(firstFault({{"radius", c.radius, 0, kMostSize},
                             {"the largest of a and b", glm::length(c.a) + glm::length(c.b), 0, kMostSize}}),
                 surfaceFault(c));
}
std::string fault(const SphereCollider& s) {
  return firstOf(firstFault({{"radius", s.radius, 0, kMostSize},
                             {"the length of center", glm::length(s.center), 0, kMostSize}}),
                 surfaceFault(s));
}
std::string fault(const HullCollider& hull) { return surfaceFault(hull); }
std::string fault(const MeshCollider& mesh) {
  return firstOf(firstFault({{"thickness", mesh.thickness, 0, 1e6}}), surfaceFault(mesh));
}
std::string fault(const SdfCollider& sdf) {
  return firstOf(firstFault({{"resolution", static_cast<double>(sdf.resolution), 4, 128}}), surfaceFault(sdf));
}
std::string fault(const RegionSensor& region) { return sizeFault(region.half_extent); }

std::string fault(const ColliderPose&) { return kOwn; }
std::string fault(const Grain&) { return kOwn; }
std::string fault(const GrainVelocity&) { return kOwn; }
std::string fault(const GrainSpin&) { return kOwn; }
std::string fault(const GrainOrientation&) { return kOwn; }
std::string fault(const GrainPrevious&) { return kOwn; }
std::string fault(const GrainMaterial&) { return kOwn; }
std::string fault(const GrainLook&) { return kOwn; }

}  // namespace scree
