// Random grains as the router would draw them, and how far their outlines are off, against what it predicts.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/ecs/world.h"
#include "modules/impostors/outline.h"
#include "modules/lod/lod.h"
#include "modules/lod/state.h"
#include "tests/impostors/shapes.h"

namespace scree::test {

// A shape as the router knows it, and the meshes of its levels in the unit of the outer radius.
struct RoutedShape {
  std::string name;
  ImpostorAtlas atlas;
  GrainShape shape, bare;  // as it is, and without an impostor
  std::vector<impostors::UnitGrain> levels;
};

inline impostors::UnitGrain levelOf(const MeshStore& meshes, const GrainShape& shape, size_t level) {
  impostors::UnitGrain grain;
  for (const MeshPart& part : meshes.mesh(shape.levels[level].mesh).parts) {
    const auto first = static_cast<uint32_t>(grain.positions.size());
    for (const Vertex& v : meshes.vertices(part))
      grain.positions.push_back((dvec3(v.position) - dvec3(shape.center)) / static_cast<double>(shape.outer_radius));
    const auto indices = meshes.indices(part);
    for (size_t k = 0; k + 2 < indices.size(); k += 3)
      grain.triangles.push_back({.v = {first + indices[k], first + indices[k + 1], first + indices[k + 2]}});
  }
  grain.vertices.resize(grain.positions.size());
  return grain;
}

inline std::vector<RoutedShape> routedShapes(World& world) {
  std::vector<RoutedShape> shapes;
  for (const std::string name : {"coffee_bean", "pebble", "bolt"}) {
    const std::string file = std::string(SCREE_SOURCE_DIR) + "/content/models/" + name + ".glb",
                      cache = std::string(SCREE_BINARY_DIR) + "/" + name + "_outlines.impostor";
    RoutedShape routed{.name = name};
    Result<ImpostorAtlas> atlas = impostorOf(file, {}, cache);
    Result<uint32_t> handle = loadGrainShape(world, file, {}, cache);
    EXPECT_TRUE(atlas.ok() && handle.ok());
    if (!atlas.ok() || !handle.ok()) return shapes;
    routed.atlas = std::move(atlas).value();
    routed.shape = world.singleton<const SwarmStore>().shape(*handle);
    routed.bare = routed.shape;
    routed.bare.impostor.clear();
    for (size_t k = 0; k < routed.shape.levels.size(); ++k)
      routed.levels.push_back(levelOf(world.singleton<const MeshStore>(), routed.shape, k));
    shapes.push_back(std::move(routed));
  }
  return shapes;
}

inline rules::SwarmBlock routingBlock(const LodThresholds& t, float band) {
  rules::SwarmBlock block{};
  lod::setThresholds(block, t, band);
  return block;
}

// One grain before one camera.
struct GrainView {
  size_t shape = 0;
  impostors::OutlineView view;
  float size_px = 1, pixels_at_1m = 400;
  uint32_t drawn_before = rules::kNotDrawn;
  uint32_t drawn_as = rules::kNotDrawn;
  float own = 0;
  bool bare = false;
  double predicted_px = 0, measured_px = 0;
};

// From anywhere, of 0.3 to 100 px, in pictures of 360 to 2,160 rows and fields of view of 0.35 to 1.5 rad; drawn before
// as anything or not at all. The place within a pixel is that of the samples' lattice, which is not the pixels'.
inline GrainView randomGrainView(uint64_t number, size_t shapes) {
  constexpr uint64_t kSeed = 71;
  const auto unit = [&](uint64_t k) { return randomUnit(kSeed, number, 0, k); };
  GrainView view;
  view.shape = static_cast<size_t>(unit(0) * static_cast<float>(shapes));
  const float z = 2 * unit(1) - 1, turn = 6.2831853f * unit(2), ring = std::sqrt(std::max(1 - z * z, 0.0f));
  const float rows = 360 * std::pow(6.0f, unit(3)), fov = 0.35f + 1.15f * unit(4);
  view.pixels_at_1m = 0.5f * rows / std::tan(0.5f * fov);
  view.size_px = std::min(0.3f * std::pow(100 / 0.3f, unit(5)), 0.9f * view.pixels_at_1m);
  view.view = impostors::outlineView(glm::normalize(vec3(ring * std::cos(turn), ring * std::sin(turn), z)),
                                     view.size_px / view.pixels_at_1m);
  const float roll = 6.2831853f * unit(6);
  const vec3 right = view.view.right, up = view.view.up;
  view.view.right = right * std::cos(roll) + up * std::sin(roll);
  view.view.up = up * std::cos(roll) - right * std::sin(roll);
  view.drawn_before = unit(7) < 0.5f ? rules::kNotDrawn : static_cast<uint32_t>(unit(8) * 8);
  view.own = unit(9);
  view.bare = unit(10) < 0.3f;
  return view;
}

// What its outline is off by, in pixels: of samples so fine that a pixel's place does not matter.
inline double measuredPx(const RoutedShape& routed, const GrainView& view, float samples_a_radius) {
  using namespace impostors;
  const OutlineMask truth = meshOutline(routed.levels.front(), view.view, samples_a_radius);
  const float diameter = 2 * view.size_px;
  const int mip = rules::impostorLevel(routed.atlas.texels, diameter, rules::kImpostorShapeBias);
  const bool small = view.drawn_as == rules::kSmallImpostor;
  const OutlineMask mask = view.drawn_as >= rules::kMesh
                               ? meshOutline(routed.levels[view.drawn_as - rules::kMesh], view.view, samples_a_radius)
                           : view.drawn_as == rules::kPoint ? discOutline(routed.shape.cast_share, view.view, samples_a_radius)
                                                            : impostorOutline(routed.atlas, view.view, mip, small, samples_a_radius);
  return static_cast<double>(view.size_px) * outlineOff(mask, truth);
}

// Draws views [first, first + count), and expects every measured error to be within the one predicted, and that within the
// tolerance.
inline std::vector<GrainView> expectBounded(const std::vector<RoutedShape>& shapes, uint64_t first, size_t count) {
  constexpr float kSamples = 100;  // a radius
  std::vector<GrainView> views(count);
  parallelChunks(count, 8, [&](size_t, size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      GrainView& view = views[k] = randomGrainView(first + k, shapes.size());
      const RoutedShape& routed = shapes[view.shape];
      const GrainShape& shape = view.bare ? routed.bare : routed.shape;
      const LodSettings settings{.tolerance_px = k % 3 == 0 ? 0.25f : k % 3 == 1 ? 0.5f : 1.0f};
      const rules::SwarmBlock block = routingBlock(thresholdsOf(shape, settings, view.pixels_at_1m), settings.band);
      view.drawn_as = rules::representationOf(view.size_px, view.own, view.drawn_before, block);
      view.predicted_px = outlineErrorPx(shape, view.drawn_as, view.size_px, view.pixels_at_1m);
      view.measured_px = measuredPx(routed, view, kSamples);
      // A grain that keeps what it was drawn as may be off by a little more.
      if (view.drawn_before == rules::kNotDrawn) {
        EXPECT_LE(view.predicted_px, static_cast<double>(settings.tolerance_px) * 1.0001) << "view " << first + k;
      }
    }
  });
  const char* names[] = {"none", "point", "small impostor", "impostor", "mesh 0", "mesh 1", "mesh 2", "mesh 3"};
  std::vector<size_t> drawn(8), beyond(8);
  std::vector<double> sum(8), most(8);
  for (size_t k = 0; k < count; ++k) {
    const GrainView& view = views[k];
    ++drawn[view.drawn_as];
    const double share = view.measured_px / std::max(view.predicted_px, 1e-9);
    if (view.drawn_as != rules::kMesh) sum[view.drawn_as] += share, most[view.drawn_as] = std::max(most[view.drawn_as], share);
    if (view.measured_px <= view.predicted_px) continue;
    if (++beyond[view.drawn_as] <= 5)
      ADD_FAILURE() << shapes[view.shape].name << " of " << view.size_px << " px at 1 / " << 1 / view.view.nearness
                    << " radii as " << names[view.drawn_as] << ", view " << first + k << ": off by " << view.measured_px << " px, predicted "
                    << view.predicted_px;
  }
  for (size_t r = 1; r < 8; ++r)
    std::printf("%-14s %5zu views, measured / predicted %.3f on average, %.3f at most, %zu beyond\n", names[r], drawn[r],
                drawn[r] > 0 ? sum[r] / static_cast<double>(drawn[r]) : 0.0, most[r], beyond[r]);
  return views;
}

}  // namespace scree::test
