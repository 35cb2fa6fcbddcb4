// Shapes and swarms on the CPU.
#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/core/log.h"
#include "modules/lod/lod.h"
#include "modules/lod/order.h"

namespace scree {
namespace {

bool allowedPlace(float x, float y, float z) {
  const auto near = [](float v) { return std::abs(v) <= kMostSwarmExtent; };
  return near(x) && near(y) && near(z);
}

bool allowed(const SwarmGrain& grain) {
  const quat& q = grain.rotation;
  return allowedPlace(grain.position.x, grain.position.y, grain.position.z) && std::isfinite(q.x + q.y + q.z + q.w) &&
         grain.radius > 0 && grain.radius <= kMostSwarmRadius;
}

void warnOfRefused(const SwarmStore::Stored& stored, uint64_t given) {
  if (stored.refused == 0) return;
  logWarning("SwarmStore: swarm \"{}\": {} of {} grains left out: positions must be within {:g} m of the swarm's origin, rotations finite, "
             "radii above 0, at most {:g} m and at least 1/{} of the largest",
             stored.name, stored.refused, given, kMostSwarmExtent, kMostSwarmRadius, rules::kRadiusSteps);
}

void sortInSpace(SwarmStore::Stored& stored, std::span<const SwarmGrain> grains) {
  std::vector<vec3> positions(grains.size());
  for (size_t k = 0; k < grains.size(); ++k) positions[k] = allowed(grains[k]) ? grains[k].position : vec3(0);
  stored.order = lod::orderInSpace(positions);
}

// Grains that moved keep their rows, and those that others join or leave nearly all of them: what each was drawn as, and
// which stand for others from afar, goes with the row.
void keepRows(std::vector<uint32_t>& order, size_t count) {
  size_t end = order.size();
  for (size_t row = 0; row < end;)
    if (order[row] < count) ++row;
    else order[row] = order[--end];
  const auto known = static_cast<uint32_t>(std::min(order.size(), count));
  order.resize(end);
  for (uint32_t given = known; given < count; ++given) order.push_back(given);
}

// Counts a grain that is kept.
void bound(SwarmStore::Stored& stored, const rules::SwarmRecord& record) {
  const vec3 p(record.x, record.y, record.z);
  const float radius = rules::radiusOf(record.size, stored.largest_radius);
  stored.min = stored.count == 0 ? p : glm::min(stored.min, p);
  stored.max = stored.count == 0 ? p : glm::max(stored.max, p);
  stored.least_radius = stored.count == 0 ? radius : std::min(stored.least_radius, radius);
  const float roughness = rules::roughnessOf(record.look);
  stored.least_roughness = stored.count == 0 ? roughness : std::min(stored.least_roughness, roughness);
  stored.most_roughness = stored.count == 0 ? roughness : std::max(stored.most_roughness, roughness);
  ++stored.count;
}

// The mean distance of neighbours in the order, m.
double pack(SwarmStore::Stored& stored, std::span<const SwarmGrain> grains) {
  stored.count = stored.refused = 0;
  for (std::vector<rules::SwarmRecord>& chunk : stored.chunks) chunk.clear();
  double steps = 0;
  vec3 last(0);
  for (const uint32_t given : stored.order) {
    const SwarmGrain& grain = grains[given];
    if (!allowed(grain) || rules::radiusOf(packed(grain, stored.largest_radius).size, 1) == 0) {
      ++stored.refused;
      continue;
    }
    const vec3 way = glm::abs(grain.position - last);
    if (stored.count > 0) steps += static_cast<double>(way.x) + static_cast<double>(way.y) + static_cast<double>(way.z);
    last = grain.position;
    const size_t chunk = stored.count / kSwarmChunk;
    if (chunk == stored.chunks.size()) stored.chunks.emplace_back();
    bound(stored, stored.chunks[chunk].emplace_back(packed(grain, stored.largest_radius)));
  }
  stored.chunks.resize((stored.count + kSwarmChunk - 1) / kSwarmChunk);
  return steps / static_cast<double>(std::max<uint64_t>(stored.count, 1));
}

// Sorted anew once that would make neighbours much nearer.
constexpr double kMostStepGrowth = 2;

void take(SwarmStore::Stored& stored, std::span<const SwarmGrain> grains) {
  stored.largest_radius = 0;
  for (const SwarmGrain& grain : grains)
    if (allowed(grain)) stored.largest_radius = std::max(stored.largest_radius, grain.radius);
  const bool fresh = stored.order.empty();
  if (fresh) sortInSpace(stored, grains);
  else keepRows(stored.order, grains.size());
  const double step = pack(stored, grains);
  if (fresh) stored.sorted_step_m = step;
  if (step > kMostStepGrowth * stored.sorted_step_m) {
    sortInSpace(stored, grains);
    stored.sorted_step_m = pack(stored, grains);
  }
  warnOfRefused(stored, grains.size());
  ++stored.version;
}

bool within(float x, float least, float most) { return x >= least && x <= most; }

std::string faultOfErrors(const GrainShape& shape) {
  constexpr float kMost = std::numeric_limits<float>::max();
  for (size_t k = 0; k < shape.levels.size(); ++k)
    if (!within(shape.levels[k].error, 0, kMost)) return fmt::format("level {}: error {}, must be finite and at least 0", k, shape.levels[k].error);
  if (!within(shape.point_outline, 0, kMost)) return fmt::format("point outline {}, must be finite and at least 0", shape.point_outline);
  float before = 0;
  for (size_t k = 0; k < shape.impostor.size(); ++k) {
    const SizeError& e = shape.impostor[k];
    if (!(e.size_px > 0 && within(e.size_px, before, kMost)))
      return fmt::format("impostor size {}: {} px, must be above 0, finite and not below the one before", k, e.size_px);
    before = e.size_px;
    for (const float x : {e.outline, e.small_outline, e.near, e.small_near})
      if (!within(x, 0, kMost)) return fmt::format("impostor size {}: outline error {}, must be finite and at least 0", k, x);
    for (const float x : {e.ssim, e.mesh_ssim, e.small_ssim})
      if (!within(x, -1, 1)) return fmt::format("impostor size {}: similarity {}, -1 to 1 are allowed", k, x);
  }
  return {};
}

// What is wrong with a shape; empty: nothing. Whether its meshes exist, lod.upload sees.
std::string fault(const GrainShape& shape) {
  constexpr float kLeastRadius = 1e-30f, kMostRadius = 1e10f;  // inverses are finite
  if (shape.levels.empty() || shape.levels.size() > rules::kMeshLevels)
    return fmt::format("{} mesh levels, 1 to {} are allowed", shape.levels.size(), rules::kMeshLevels);
  if (!within(shape.outer_radius, kLeastRadius, kMostRadius))
    return fmt::format("outer radius {}, {:g} to {:g} are allowed", shape.outer_radius, kLeastRadius, kMostRadius);
  if (!within(shape.inner_radius, 0, shape.outer_radius))
    return fmt::format("inner radius {}, 0 to {} are allowed", shape.inner_radius, shape.outer_radius);
  const vec3& c = shape.center;
  if (!allowedPlace(c.x, c.y, c.z))
    return fmt::format("centre {} {} {}, coordinates to {:g} are allowed", c.x, c.y, c.z, kMostSwarmExtent);
  if (!soundEllipsoid(shape.bound)) return "its bound is no ellipsoid; half-axes of 0.01 to 3 outer radii are allowed";
  for (const float x : {shape.albedo.x, shape.albedo.y, shape.albedo.z, shape.roughness, shape.metallic, shape.cast_share, shape.facing})
    if (!within(x, 0, std::numeric_limits<float>::max()))
      return fmt::format("albedo {} {} {}, roughness {}, metallic {}, cast share {}, facing {}: all must be finite and at least 0",
                         shape.albedo.x, shape.albedo.y, shape.albedo.z, shape.roughness, shape.metallic, shape.cast_share, shape.facing);
  return faultOfErrors(shape);
}

}  // namespace

rules::SwarmRecord packed(const SwarmGrain& grain, float largest_radius) {
  const quat& q = grain.rotation;
  return {grain.position.x,
          grain.position.y,
          grain.position.z,
          rules::packRotation(vec4(q.x, q.y, q.z, q.w)),
          rules::packGrainLook(grain.tint, grain.roughness),
          rules::packGrainSize(grain.radius / largest_radius, grain.seed)};
}

bool soundEllipsoid(const rules::Ellipsoid& e) {
  const vec3 a(e.axis_a), b(e.axis_b), c(e.axis_c), center(e.center);
  float longest = 0;
  for (const vec4& axis : {e.axis_a, e.axis_b, e.axis_c}) {
    const float length2 = glm::dot(vec3(axis), vec3(axis));
    if (!(length2 >= 1e-4f && length2 <= 10 && std::abs(axis.w * length2 - 1) <= 1e-3f)) return false;
    longest = std::max(longest, std::sqrt(length2));
  }
  const auto perpendicular = [](const vec3& u, const vec3& v) { return std::abs(glm::dot(u, v)) <= 1e-3f * glm::length(u) * glm::length(v); };
  return perpendicular(a, b) && perpendicular(b, c) && perpendicular(c, a) && glm::length(center) <= 2 &&
         e.center.w >= (glm::length(center) + longest) * (1 - 1e-5f) && e.center.w <= 6;
}

uint32_t SwarmStore::addShape(GrainShape shape) {
  if (const std::string wrong = fault(shape); !wrong.empty()) fail(fmt::format("SwarmStore::addShape: shape \"{}\": {}", shape.name, wrong));
  shapes_.push_back(std::move(shape));
  return static_cast<uint32_t>(shapes_.size() - 1);
}

const GrainShape& SwarmStore::shape(uint32_t handle) const {
  if (handle >= shapes_.size()) fail(fmt::format("SwarmStore: shape {}; there are {}", handle, shapes_.size()));
  return shapes_[handle];
}

uint32_t SwarmStore::add(std::string name, uint32_t shape_handle, std::span<const SwarmGrain> grains) {
  shape(shape_handle);
  Stored& stored = swarms_.emplace_back();
  stored.name = std::move(name);
  stored.shape = shape_handle;
  take(stored, grains);
  return static_cast<uint32_t>(swarms_.size() - 1);
}

uint32_t SwarmStore::add(std::string name, uint32_t shape_handle, uint64_t count, float largest_radius,
                         const Fill& fill) {
  shape(shape_handle);
  if (!(largest_radius > 0 && largest_radius <= kMostSwarmRadius))
    fail(fmt::format("SwarmStore::add: swarm \"{}\": largest radius {}, must be above 0 and at most {:g} m", name, largest_radius,
                     kMostSwarmRadius));
  Stored& stored = swarms_.emplace_back();
  stored.name = std::move(name);
  stored.shape = shape_handle;
  stored.largest_radius = largest_radius;
  stored.version = 1;
  for (uint64_t first = 0; first < count; first += kSwarmChunk) {
    std::vector<rules::SwarmRecord>& chunk = stored.chunks.emplace_back(std::min<uint64_t>(kSwarmChunk, count - first));
    fill(first, chunk);
    const auto wrong = [](const rules::SwarmRecord& r) {
      return !allowedPlace(r.x, r.y, r.z) || rules::radiusOf(r.size, 1) == 0;
    };
    const auto kept = std::remove_if(chunk.begin(), chunk.end(), wrong);
    stored.refused += static_cast<uint64_t>(chunk.end() - kept);
    chunk.erase(kept, chunk.end());
    for (const rules::SwarmRecord& record : chunk) bound(stored, record);
    if (chunk.empty()) stored.chunks.pop_back();
  }
  warnOfRefused(stored, count);
  return static_cast<uint32_t>(swarms_.size() - 1);
}

void SwarmStore::replace(uint32_t handle, std::span<const SwarmGrain> grains) {
  swarm(handle);
  take(swarms_[handle], grains);
}

const SwarmStore::Stored& SwarmStore::swarm(uint32_t handle) const {
  if (handle >= swarms_.size()) fail(fmt::format("SwarmStore: swarm {}; there are {}", handle, swarms_.size()));
  return swarms_[handle];
}

}  // namespace scree
