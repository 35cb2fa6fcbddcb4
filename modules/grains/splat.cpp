// grains.splat: volume fraction and mean velocity of grains on the cells of each GrainGrid.
//
// Sums are of integers: no result depends on the order of the grains or on the threads, and what a
// grain gives to its eight cells is what it has, to the last unit.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/app.h"
#include "engine/core/parallel.h"
#include "modules/grains/region.h"

namespace scree::grains {
namespace {

__extension__ using Int128 = __int128;

constexpr int kWeightBits = 20;   // of a trilinear weight along one axis
constexpr int kSumBits = 61;      // of the largest sum
constexpr size_t kSums = 4;       // a cell: volume, and volume x velocity
constexpr size_t kCellChunk = 16384;

// Of the grains of a grid, so that their sums fit.
struct Units {
  int volume = 0, velocity = 0;  // exponents of 2
};

int exponentAbove(double x) { return x > 0 && std::isfinite(x) ? std::ilogb(x) + 1 : 0; }

Units unitsFor(std::span<const Splat> splats) {
  double volume = 0, speed = 0;
  for (const Splat& splat : splats) {
    volume = std::max(volume, splat.volume);
    for (int axis = 0; axis < 3; ++axis)
      speed = std::max(speed, static_cast<double>(std::abs(splat.velocity[axis])));
  }
  const int count = exponentAbove(static_cast<double>(splats.size()));
  return {exponentAbove(volume) + count - kSumBits, exponentAbove(speed)};
}

class Splatter {
 public:
  Splatter(const std::array<int32_t, 3>& cells, Units units, std::vector<int64_t>& sums)
      : cells_(cells), units_(units), sums_(sums) {}

  void add(const Splat& splat) {
    const auto whole = static_cast<int64_t>(std::ldexp(splat.volume, -units_.volume));
    std::array<std::array<int64_t, 2>, 3> weight, cell;
    size_t nearest = 0;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double place = splat.place[static_cast<int>(axis)], floor = std::floor(place);
      weight[axis][1] = std::llround((place - floor) * (int64_t{1} << kWeightBits));
      weight[axis][0] = (int64_t{1} << kWeightBits) - weight[axis][1];
      const int64_t last = cells_[axis] - 1;
      cell[axis][0] = std::clamp(static_cast<int64_t>(floor), int64_t{0}, last);
      cell[axis][1] = std::clamp(static_cast<int64_t>(floor) + 1, int64_t{0}, last);
      nearest |= size_t{weight[axis][1] > weight[axis][0]} << axis;
    }
    std::array<int64_t, 8> part;
    int64_t left = whole;
    for (size_t k = 0; k < 8; ++k) {
      const int64_t xy = weight[0][k & 1] * weight[1][k >> 1 & 1];
      part[k] = static_cast<int64_t>(Int128{whole} * xy * weight[2][k >> 2] >> 3 * kWeightBits);
      left -= part[k];
    }
    part[nearest] += left;
    const dvec3 speed = dvec3(splat.velocity) * std::ldexp(1.0, -units_.velocity);
    for (size_t k = 0; k < 8; ++k) {
      const int64_t at = cell[0][k & 1] + cells_[0] * (cell[1][k >> 1 & 1] + cells_[1] * cell[2][k >> 2]);
      int64_t* sum = &sums_[kSums * static_cast<size_t>(at)];
      sum[0] += part[k];
      for (int axis = 0; axis < 3; ++axis)
        sum[1 + axis] += std::llround(static_cast<double>(part[k]) * speed[axis]);
    }
  }

 private:
  const std::array<int32_t, 3> cells_;
  Units units_;
  std::vector<int64_t>& sums_;
};

void gatherSplats(GrainsState& state, const Region& region, const std::array<int32_t, 3>& cells,
                  double cell_volume) {
  const dvec3 count(cells[0], cells[1], cells[2]), half(region.half);
  state.splats.clear();
  eachGrainNear(state, region.low, region.high, [&](const SeenGrain& grain) {
    if (!region.holds(grain.position)) return;
    const dvec3 place = (dvec3(region.local(grain.position)) + half) / (2.0 * half) * count - 0.5;
    const double layer = std::clamp(std::floor(place.z), 0.0, count.z - 1);
    state.splats.push_back({place, volumeOf(grain.radius) / cell_volume, grain.velocity,
                            static_cast<uint32_t>(layer)});
  });
}

// By layer: two layers that are not neighbours touch different cells.
void sortByLayer(GrainsState& state, uint32_t layers) {
  std::vector<uint32_t>& begin = state.layer_begin;
  begin.assign(size_t{layers} + 1, 0);
  for (const Splat& splat : state.splats) ++begin[splat.layer + 1];
  for (uint32_t k = 0; k < layers; ++k) begin[k + 1] += begin[k];
  state.splats_by_layer.resize(state.splats.size());
  for (const Splat& splat : state.splats) state.splats_by_layer[begin[splat.layer]++] = splat;
  for (uint32_t k = layers; k > 0; --k) begin[k] = begin[k - 1];
  begin[0] = 0;
}

void splat(GrainsState& state, const GrainGrid& grid, const Region& region, GrainGridValues& out) {
  const dvec3 half(region.half);
  size_t cells = 1;
  for (const int32_t n : grid.cells) cells *= static_cast<size_t>(n);
  out.cells = grid.cells;
  out.cell_volume = 8 * half.x * half.y * half.z / static_cast<double>(cells);
  out.fraction.resize(cells);
  out.velocity.resize(cells);
  gatherSplats(state, region, grid.cells, out.cell_volume);
  const auto layers = static_cast<uint32_t>(grid.cells[2]);
  sortByLayer(state, layers);
  const Units units = unitsFor(state.splats);
  state.cell_sums.assign(kSums * cells, 0);
  Splatter splatter(grid.cells, units, state.cell_sums);
  const Worth worth = worthOf(state.splats.size(), kFewGrains);
  for (uint32_t parity = 0; parity < 2; ++parity) {
    parallelChunks((layers + 1 - parity) / 2, 1, [&](size_t k, size_t, size_t) {
      const size_t layer = 2 * k + parity;
      for (uint32_t at = state.layer_begin[layer]; at < state.layer_begin[layer + 1]; ++at)
        splatter.add(state.splats_by_layer[at]);
    }, worth);
  }
  const double volume_unit = std::ldexp(1.0, units.volume), speed_unit = std::ldexp(1.0, units.velocity);
  parallelChunks(cells, kCellChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t cell = begin; cell < end; ++cell) {
      const int64_t* sum = &state.cell_sums[kSums * cell];
      const auto volume = static_cast<double>(sum[0]);
      out.fraction[cell] = volume * volume_unit;
      out.velocity[cell] = vec3(0);
      if (sum[0] <= 0) continue;
      for (int axis = 0; axis < 3; ++axis)
        out.velocity[cell][axis] =
            static_cast<float>(static_cast<double>(sum[1 + axis]) / volume * speed_unit);
    }
  });
}

// The entity's values; made, in the order of entities, if there are none.
GrainGridValues& valuesOf(GrainGrids& grids, Entity entity) {
  const auto at = std::lower_bound(
      grids.grids.begin(), grids.grids.end(), entity,
      [](const GrainGridValues& values, Entity key) { return values.entity < key; });
  if (at != grids.grids.end() && at->entity == entity) return *at;
  GrainGridValues values;
  values.entity = entity;
  return *grids.grids.insert(at, std::move(values));
}

void splatAll(GrainsState& state) {
  World& world = state.world;
  GrainGrids& grids = world.singleton<GrainGrids>();
  const uint64_t tick = world.singleton<const Tick>().index;
  const dvec3 origin = fieldOrigin(world);
  std::vector<Entity>& entities = state.entities;
  entities.clear();
  state.grids.each([&](Entity entity, const Transform& transform, const GrainGrid& grid) {
    std::string wrong = fault(grid);
    if (wrong.empty()) wrong = faultOf(transform, origin, grid.half_extent);
    const vec3 half = grid.half_extent * glm::abs(transform.scale);
    if (wrong.empty() && !(std::min({half.x, half.y, half.z}) >= 1e-4f))
      wrong = "scaled, its half_extent must be 1e-4 m or more";
    if (wrong.empty()) {
      entities.push_back(entity);
    } else {
      refuse(state.refused_grids, world, "grains.splat", "GrainGrid", entity, wrong);
    }
  });
  closeRefusals(state.refused_grids);
  std::sort(entities.begin(), entities.end());
  std::erase_if(grids.grids, [&](const GrainGridValues& values) {
    return !std::binary_search(entities.begin(), entities.end(), values.entity);
  });
  for (const Entity entity : entities) {
    const GrainGrid& grid = *world.peek<GrainGrid>(entity);
    GrainGridValues& values = valuesOf(grids, entity);
    const bool fresh = values.tick == 0 || values.cells != grid.cells;
    if (!fresh && tick % static_cast<uint64_t>(grid.every) != 0) continue;
    splat(state, grid, regionOf(*world.peek<Transform>(entity), grid.half_extent, 0, origin), values);
    values.tick = tick;
  }
}

}  // namespace

SystemDesc splatSystem(const SharedState& state) {
  return {.name = "grains.splat",
          .phase = Phase::Simulate,
          // Once more after the last has gone, to forget its values.
          .needs =
              [state] {
                return !state->grids.empty() ||
                       !state->world.singleton<const GrainGrids>().grids.empty();
              },
          .run = [state](World&) { splatAll(*state); }};
}

}  // namespace scree::grains
