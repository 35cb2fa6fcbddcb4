// Clumps become grains: one by one, or as a block.
#include <fmt/format.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "engine/core/random.h"
#include "modules/grains/clump_shape.h"
#include "modules/grains/ranges.h"
#include "modules/grains/spawn_rows.h"
#include "modules/grains/state.h"

namespace scree {

std::string fault(const ClumpSpec& spec) {
  using namespace grains;
  std::string wrong = firstFault({{"count", static_cast<double>(spec.count), 2, kMostMembers}});
  for (size_t k = 0; k < kMostMembers && wrong.empty(); ++k) {
    if (static_cast<int32_t>(k) >= spec.count) break;
    const std::string at = fmt::format("member[{}]", k);
    wrong = firstFault({{at + ".position.x", spec.member[k].position.x, -1e5, 1e5},
                        {at + ".position.y", spec.member[k].position.y, -1e5, 1e5},
                        {at + ".position.z", spec.member[k].position.z, -1e5, 1e5},
                        {at + ".radius", spec.member[k].radius, kLeastRadius, kMostRadius}});
  }
  const quat& q = spec.rotation;
  return firstOf(wrong, firstFault({{"density", spec.material.density, kLeastDensity, kMostDensity},
                                    {"friction", spec.material.friction, 0, kMostFriction},
                                    {"rolling_friction", spec.material.rolling_friction, 0, kMostFriction},
                                    {"restitution", spec.material.restitution, 0, 1},
                                    {"cohesion", spec.material.cohesion, 0, kMostCohesion},
                                    {"position.x", spec.position.x, -kMostSize, kMostSize},
                                    {"position.y", spec.position.y, -kMostSize, kMostSize},
                                    {"position.z", spec.position.z, -kMostSize, kMostSize},
                                    {"the square of rotation", glm::dot(q, q), 0.25, 4},
                                    {"the speed", glm::length(spec.velocity), 0, kMostSpeed},
                                    {"the spin", glm::length(spec.spin), 0, 1e10}}));
}

namespace grains {
namespace {

struct Placed {
  ClumpForm form;
  float scale = 1;  // of the form
  const ClumpSpec* spec = nullptr;
};

void spawnPlaced(World& world, std::span<const Placed> clumps) {
  size_t total = 0;
  for (const Placed& clump : clumps) total += clump.form.count;
  if (total == 0) return;
  const TableRows rows =
      world.spawnMany<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious, GrainRest,
                      GrainMaterial, GrainLook, GrainClump>(total);
  const NewGrains grains(rows);
  const std::span<GrainClump> clump = rows.column<GrainClump>();
  const std::span<const Entity> entity = rows.entities();
  size_t row = 0;
  for (const Placed& placed : clumps) {
    const ClumpSpec& spec = *placed.spec;
    const quat rotation = glm::normalize(spec.rotation);
    for (uint32_t k = 0; k < placed.form.count; ++k, ++row) {
      const vec3 arm = placed.scale * placed.form.arm[k];
      const vec3 reach = rotation * arm;
      GrainMaterial material = spec.material;
      material.density = std::max(kLeastDensity, spec.material.density * placed.form.density_share);
      grains.put(row, {{spec.position + reach, placed.scale * placed.form.radius[k]},
                       {spec.velocity + glm::cross(spec.spin, reach)},
                       {spec.spin},
                       {rotation},
                       material,
                       spec.look});
      clump[row] = {entity[row - k], k, placed.form.count, arm};
    }
  }
}

}  // namespace

std::string faultOfClumps(const ClumpShape& shape, float smallest, float largest) {
  std::string wrong = fault(shape);
  if (!wrong.empty()) return "ClumpShape: " + wrong;
  // Asked of each emitter in each tick: not by the form, which takes long to make.
  const ClumpShape& own = membersOf(shape);
  const auto [least, most] = std::minmax_element(own.radius.begin(), own.radius.begin() + own.count);
  return firstFault({{"the smallest member's radius", smallest * *least, kLeastRadius, kMostRadius},
                     {"the largest member's radius", largest * *most, kLeastRadius, kMostRadius}});
}

void spawnClumpsOf(World& world, const ClumpForm& form, std::span<const float> scale,
                   std::span<const ClumpSpec> specs) {
  std::vector<Placed> placed;
  placed.reserve(specs.size());
  for (size_t k = 0; k < specs.size(); ++k) placed.push_back({form, scale[k], &specs[k]});
  spawnPlaced(world, placed);
}

}  // namespace grains

void spawnClumps(World& world, std::span<const ClumpSpec> specs) {
  using namespace grains;
  std::vector<Placed> placed;
  uint64_t refused = 0;
  for (size_t k = 0; k < specs.size(); ++k) {
    const ClumpSpec& spec = specs[k];
    if (const std::string wrong = fault(spec); !wrong.empty()) {
      if (refused++ == 0) logWarning("spawnClumps: clump {} of {} refused: {}", k, specs.size(), wrong);
      continue;
    }
    const auto n = static_cast<size_t>(spec.count);
    const auto same = [&](const ClumpSpec& last) {
      return last.count == spec.count &&
             std::equal(last.member.begin(), last.member.begin() + n, spec.member.begin(),
                        [](const Grain& a, const Grain& b) {
                          return a.position == b.position && a.radius == b.radius;
                        });
    };
    if (!placed.empty() && same(*placed.back().spec)) {
      placed.push_back({placed.back().form, 1, &spec});
      continue;
    }
    std::array<Sphere, kMostMembers> spheres;
    for (size_t m = 0; m < n; ++m) spheres[m] = {spec.member[m].position, spec.member[m].radius};
    placed.push_back({formOf(std::span<const Sphere>(spheres).first(n)), 1, &spec});
  }
  if (refused > 1) logWarning("spawnClumps: {} clumps refused, the first is named above", refused);
  if (refused > 0) grainField(world).refused += refused;
  spawnPlaced(world, placed);
}

}  // namespace scree
