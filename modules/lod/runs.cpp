// Boxes and radii of the runs of a swarm.
#include <algorithm>

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

vec3 driftOf(std::span<const rules::SwarmRun> runs) {
  vec3 drift(0);
  for (size_t k = 0; k < runs.size(); ++k) {
    const rules::SwarmRun& run = runs[k];
    drift += (2 * k < runs.size() ? -1.0f : 1.0f) * vec3(run.low_x + run.high_x, run.low_y + run.high_y, run.low_z + run.high_z);
  }
  return drift / static_cast<float>(std::max<size_t>(runs.size(), 1));
}

}  // namespace scree::lod
