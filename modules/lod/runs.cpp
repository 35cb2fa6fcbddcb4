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
  std::vector<float> sizes;
  sizes.reserve(runs.size());
  for (const rules::SwarmRun& run : runs) {
    const vec3 low(run.low_x, run.low_y, run.low_z), high(run.high_x, run.high_y, run.high_z);
    chunk.middles.push_back(0.5f * (low + high));
    sizes.push_back(glm::length(high - low));
  }
  const auto median = sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2);
  std::ranges::nth_element(sizes, median);
  chunk.run_size = *median / std::sqrt(3.0f);
}

void orderRuns(const Chunk& chunk, uint64_t version, Routes& routes, const vec3& eye, RunOrder& scratch) {
  // As a share of how far away the nearest run was: directions to runs turn by 2.3 degrees at most.
  constexpr float kStale = 0.04f;
  if (routes.ordered_version == version && glm::distance(eye, routes.ordered_from) <= kStale * routes.nearest) return;
  const size_t runs = chunk.middles.size();
  scratch.distances.resize(runs);
  float nearest = std::numeric_limits<float>::max(), farthest = 0;
  for (size_t run = 0; run < runs; ++run) {
    const float distance = scratch.distances[run] = glm::distance(chunk.middles[run], eye);
    nearest = std::min(nearest, distance), farthest = std::max(farthest, distance);
  }
  // Of those about as far away, neighbours stay neighbours, whose memory and pixels are near each other. Sorted by counting.
  constexpr uint32_t kSteps = 4096;
  const float step = std::max({chunk.run_size, (farthest - nearest) / static_cast<float>(kSteps - 1), 1e-9f});
  const auto stepOf = [&](float distance) {
    const float steps = (distance - nearest) / step;  // not a number, if the eye's place is not
    return steps > 0 ? static_cast<uint32_t>(std::min(steps, static_cast<float>(kSteps - 1))) : 0;
  };
  scratch.begins.assign(kSteps + 1, 0);
  for (const float distance : scratch.distances) ++scratch.begins[stepOf(distance) + 1];
  for (uint32_t k = 0; k < kSteps; ++k) scratch.begins[k + 1] += scratch.begins[k];
  scratch.order.resize(runs);
  for (size_t run = 0; run < runs; ++run) scratch.order[scratch.begins[stepOf(scratch.distances[run])]++] = static_cast<uint32_t>(run);
  if (!routes.order) routes.order = gpu::Buffer("lod.order", 4 * runs);
  routes.order.upload(std::span<const uint32_t>(scratch.order));
  routes.ordered_from = eye;
  routes.nearest = nearest;
  routes.ordered_version = version;
}

}  // namespace scree::lod
