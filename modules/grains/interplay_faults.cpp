// What a file, or a program, may say of emitters, sinks, forces, blows and grids.
#include <fmt/format.h>

#include <cmath>

#include "modules/grains/ranges.h"

namespace scree {
namespace {

using namespace grains;

constexpr double kMostRate = 1e5;   // grains/s
constexpr double kMostAir = 1e4;    // m/s
constexpr double kMostPush = 1e5;   // m/s^2
constexpr double kMostDrag = 1e6;   // 1/s
constexpr double kMostCount = 9e18;

}  // namespace

std::string fault(const GrainEmitter& e) {
  return firstOf(firstFault({{"rate", e.rate, 0, kMostRate},
                             {"mouth", e.mouth, 0, 1e6},
                             {"velocity.x", e.velocity.x, -kMostAir, kMostAir},
                             {"velocity.y", e.velocity.y, -kMostAir, kMostAir},
                             {"velocity.z", e.velocity.z, -kMostAir, kMostAir},
                             {"spread", e.spread, 0, kMostAir},
                             {"due", e.due, 0, 1}}),
                 kindFault(e));
}

std::string fault(const GrainSink& sink) {
  return firstOf(sizeFault(sink.half_extent, 0),
                 firstFault({{"radius", sink.radius, 0, kMostSize},
                             {"count", static_cast<double>(sink.count), 0, kMostCount},
                             {"mass", sink.mass, 0, 1e300}}));
}

std::string fault(const GrainForce& f) {
  return firstOf(sizeFault(f.half_extent, 0),
                 firstFault({{"acceleration.x", f.acceleration.x, -kMostPush, kMostPush},
                             {"acceleration.y", f.acceleration.y, -kMostPush, kMostPush},
                             {"acceleration.z", f.acceleration.z, -kMostPush, kMostPush},
                             {"attraction", f.attraction, -kMostPush, kMostPush},
                             {"falloff", f.falloff, 1e-3f, 1e6},
                             {"drag", f.drag, 0, kMostDrag},
                             {"flow.x", f.flow.x, -kMostAir, kMostAir},
                             {"flow.y", f.flow.y, -kMostAir, kMostAir},
                             {"flow.z", f.flow.z, -kMostAir, kMostAir},
                             {"swirl", f.swirl, -kMostAir, kMostAir},
                             {"wake_above", f.wake_above, 0, 1e12}}));
}

std::string fault(const GrainBlow& blow) {
  return firstFault({{"radius", blow.radius, 0, kMostSize}, {"strength", blow.strength, -1e12, 1e12}});
}

std::string fault(const GrainGrid& grid) {
  double total = 1;
  for (const int32_t n : grid.cells) {
    if (n < 1) return fmt::format("cells = {}; allowed is 1 or more", n);
    total *= n;
  }
  return firstOf(sizeFault(grid.half_extent, 1e-4),
                 firstFault({{"the product of cells", total, 1, kMostGridCells},
                             {"every", static_cast<double>(grid.every), 1, 3600}}));
}

}  // namespace scree
