// Spheres dropped into a box: the lattice, overlaps by a grid of their own, CPU time.
#include "tests/bench/drop.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "engine/core/random.h"

namespace scree::bench {
namespace {

double percentile99(std::vector<float>& values) {
  const auto at = values.begin() + static_cast<long>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

}  // namespace

Drop makeDrop(size_t count) {
  const float spacing = 2.4f * kDropRadius;
  const size_t side = std::max<size_t>(2, static_cast<size_t>(std::lround(std::cbrt(count))));
  Drop drop;
  drop.width = spacing * static_cast<float>(side);
  drop.height = spacing * static_cast<float>(count / (side * side) + 2);
  for (size_t k = 0; k < count; ++k) {
    const auto shake = [&](uint64_t axis) {
      return 0.3f * kDropRadius * (randomUnit(1, k, 0, axis) - 0.5f);
    };
    const vec3 cell(static_cast<float>(k % side) + 0.5f,
                    static_cast<float>(k / (side * side)) + 0.75f,
                    static_cast<float>(k / side % side) + 0.5f);
    drop.position.push_back(cell * spacing + vec3(shake(0), shake(1), shake(2)));
  }
  return drop;
}

void OverlapSample::add(std::span<const vec3> positions) {
  // Cells of a grain's diameter, sorted so that a row along x is one stretch of the list.
  constexpr float kSide = 2 * kDropRadius;
  constexpr int64_t kRow = int64_t{1} << 21, kLayer = kRow * kRow;
  struct Placed {
    int64_t cell;
    vec3 position;
  };
  std::vector<Placed> sorted;
  for (const vec3 p : positions) {
    const vec3 at = glm::clamp(glm::floor(p / kSide), vec3(-1e6f), vec3(1e6f));  // inside kRow
    sorted.push_back({static_cast<int64_t>(at.z) * kLayer + static_cast<int64_t>(at.y) * kRow +
                          static_cast<int64_t>(at.x),
                      p});
  }
  const auto before = [](const Placed& a, int64_t cell) { return a.cell < cell; };
  std::sort(sorted.begin(), sorted.end(),
            [](const Placed& a, const Placed& b) { return a.cell < b.cell; });
  for (auto one = sorted.begin(); one != sorted.end(); ++one) {
    const auto against = [&](std::vector<Placed>::iterator other, int64_t last) {
      for (; other != sorted.end() && other->cell <= last; ++other) {
        const vec3 d = one->position - other->position;
        const float square = glm::dot(d, d);
        if (square < kSide * kSide)
          overlaps_.push_back((kSide - std::sqrt(square)) / kDropRadius);
      }
    };
    against(one + 1, one->cell + 1);
    for (const int64_t row : {kRow, kLayer - kRow, kLayer, kLayer + kRow}) {
      const int64_t middle = one->cell + row;
      against(std::lower_bound(one, sorted.end(), middle - 1, before), middle + 1);
    }
  }
}

Overlap OverlapSample::result() const {
  if (overlaps_.empty()) return {};
  std::vector<float> sorted = overlaps_;
  double sum = 0;
  for (const float overlap : sorted) sum += static_cast<double>(overlap);
  return {sum / static_cast<double>(sorted.size()), percentile99(sorted),
          static_cast<double>(*std::max_element(sorted.begin(), sorted.end()))};
}

double fastestPercent(std::span<const vec3> velocities) {
  std::vector<float> speeds;
  for (const vec3 v : velocities) speeds.push_back(glm::length(v));
  return speeds.empty() ? 0 : percentile99(speeds);
}

double cpuMs() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

}  // namespace scree::bench
