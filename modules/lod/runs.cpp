// Boxes and radii of the runs of a swarm, and their order from the eye.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "modules/lod/state.h"

namespace scree::lod {

void boundRuns(std::span<const rules::SwarmRecord> records, float largest_radius, std::vector<rules::SwarmRun>& runs) {
  runs.resize((records.size() + rules::kRunGrains - 1) / rules::kRunGrains);
  for (size_t run = 0; run < runs.size(); ++run) {
    const size_t first = run * rules::kRunGrains, end = std::min(first + rules::kRunGrains, records.size());
    vec3 low(records[first].x, records[first].y, records[first].z), high = low;
    uint32_t least = rules::kRadiusSteps, most = 0;
    for (const rules::SwarmRecord& r : records.subspan(first, end - first)) {
      low = glm::min(low, vec3(r.x, r.y, r.z)), high = glm::max(high, vec3(r.x, r.y, r.z));
      least = std::min(least, r.size & rules::kRadiusSteps), most = std::max(most, r.size & rules::kRadiusSteps);
    }
    runs[run] = {low.x, low.y, low.z, rules::radiusOf(least, largest_radius),
                 high.x, high.y, high.z, rules::radiusOf(most, largest_radius)};
  }
}

void placeRuns(Chunk& chunk, std::span<const rules::SwarmRun> runs) {
  chunk.middles.clear();
  double size = 0;
  for (const rules::SwarmRun& run : runs) {
    const vec3 low(run.low_x, run.low_y, run.low_z), high(run.high_x, run.high_y, run.high_z);
    chunk.middles.push_back(0.5f * (low + high));
    size += static_cast<double>(glm::length(high - low));
  }
  chunk.run_size = std::max(static_cast<float>(size / std::sqrt(3.0) / static_cast<double>(runs.size())), 1e-9f);
}

void orderRuns(const Chunk& chunk, uint64_t version, Routes& routes, const vec3& eye, RunOrder& scratch) {
  // As a share of how far away the nearest run was: less than a run is wide there.
  constexpr float kStale = 0.04f;
  if (routes.ordered_version == version && glm::distance(eye, routes.ordered_from) <= kStale * routes.nearest) return;
  scratch.keys.clear();
  routes.nearest = std::numeric_limits<float>::max();
  for (size_t run = 0; run < chunk.middles.size(); ++run) {
    const float distance = glm::distance(chunk.middles[run], eye);
    routes.nearest = std::min(routes.nearest, distance);
    // Of those about as far away, neighbours stay neighbours, whose memory and pixels are near each other.
    const float steps = std::min(distance / chunk.run_size, 1e9f);
    scratch.keys.push_back(uint64_t{static_cast<uint32_t>(steps)} << 32 | run);
  }
  std::ranges::sort(scratch.keys);
  scratch.order.clear();
  for (const uint64_t key : scratch.keys) scratch.order.push_back(static_cast<uint32_t>(key));
  if (!routes.order) routes.order = gpu::Buffer("lod.order", 4 * chunk.middles.size());
  routes.order.upload(std::span<const uint32_t>(scratch.order));
  routes.ordered_from = eye;
  routes.ordered_version = version;
}

}  // namespace scree::lod
