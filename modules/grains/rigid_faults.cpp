// What a file, or a program, may say of rigid bodies.
#include <glm/geometric.hpp>

#include <fmt/format.h>

#include <cmath>

#include "modules/grains/ranges.h"
#include "modules/grains/solver.h"

namespace scree {
namespace {

using namespace grains;

// A direction; any length that can be made 1.
std::string axisFault(const char* name, vec3 axis) {
  const float length = glm::length(axis);
  if (length >= 1e-6f && length <= 1e6f) return {};
  return fmt::format("{} = ({}, {}, {}); its length must be 1e-6 to 1e6", name, axis.x, axis.y, axis.z);
}

}  // namespace

std::string fault(const RigidBody& b) {
  std::string wrong = firstFault({{"density", b.density, kLeastDensity, kMostDensity},
                                  {"velocity.x", b.velocity.x, -kMostSpeed, kMostSpeed},
                                  {"velocity.y", b.velocity.y, -kMostSpeed, kMostSpeed},
                                  {"velocity.z", b.velocity.z, -kMostSpeed, kMostSpeed},
                                  {"spin.x", b.spin.x, -kMostSpeed, kMostSpeed},
                                  {"spin.y", b.spin.y, -kMostSpeed, kMostSpeed},
                                  {"spin.z", b.spin.z, -kMostSpeed, kMostSpeed},
                                  {"damping", b.damping, 0, 60}});
  if (wrong.empty() && b.mass != 0) wrong = firstFault({{"mass", b.mass, 1e-12, 1e15}});  // 0: by density
  return wrong;
}

std::string fault(const BodyHinge& h) {
  std::string wrong = firstFault({{"point.x", h.point.x, -1e6, 1e6},
                                  {"point.y", h.point.y, -1e6, 1e6},
                                  {"point.z", h.point.z, -1e6, 1e6},
                                  {"resistance", h.resistance, 0, 1e12}});
  if (wrong.empty()) wrong = axisFault("axis", h.axis);
  if (wrong.empty() && h.placed)
    wrong = firstOf(firstFault({{"pivot.x", h.pivot.x, -kMostSize, kMostSize},
                                {"pivot.y", h.pivot.y, -kMostSize, kMostSize},
                                {"pivot.z", h.pivot.z, -kMostSize, kMostSize}}),
                    axisFault("line", h.line));
  return wrong;
}

std::string fault(const BodySlider& s) {
  std::string wrong = firstFault({{"stiffness", s.stiffness, 0, 1e12},
                                  {"resistance", s.resistance, 0, 1e12},
                                  {"low", s.low, -1e9, 1e9},
                                  {"high", s.high, s.low, 1e9}});
  if (wrong.empty()) wrong = axisFault("axis", s.axis);
  if (wrong.empty() && s.placed)
    wrong = firstFault({{"home.x", s.home.x, -kMostSize, kMostSize},
                        {"home.y", s.home.y, -kMostSize, kMostSize},
                        {"home.z", s.home.z, -kMostSize, kMostSize}});
  return wrong;
}

}  // namespace scree
