// lod.shadow: grains into the sun's shadow map. Splatted by compute, and kept as long as neither the grains nor
// the map's place change: millions of discs cost too much to be drawn anew in each frame.
#include <cmath>

#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"

namespace scree::lod {
namespace {

constexpr int kCellTexels = 0, kShapeShare = 1;  // uniform locations
constexpr uint32_t kGroup = 64;

gpu::Program compute(const char* name) {
  return gpu::Program({.name = std::string("lod.") + name, .compute = std::string("lod/") + name + ".comp"});
}

struct SunMap {
  gpu::Program cells_program = compute("sun_cells"), depth_program = compute("sun_depth");
  gpu::Program copy{{.name = "lod.shadow", .vertex = "lib/full_screen.vert", .fragment = "lod/sun.frag"}};
  gpu::Buffer cells, depth;
  uint64_t shadow_version = 0, casters_version = 0;  // of what `depth` holds

  void splat(const SwarmsDrawn::State& state, const rules::ShadowViewBlock& view);
};

// One of the cell's grains casts for all of them: half a radius wide, what shines past it is lost in the
// filter. The smallest that there is, so that every grain of every swarm finds its own cell.
float cellTexels(const SwarmsDrawn::State& state, float texel_m) {
  float least = 1e30f;
  for (const Part& part : state.parts)
    if (part.casts) least = std::min(least, part.largest_radius);
  return std::max(1.0f, std::floor(least / texel_m));
}

void SunMap::splat(const SwarmsDrawn::State& state, const rules::ShadowViewBlock& view) {
  const float cell = cellTexels(state, view.texel_m);
  const auto side = static_cast<size_t>(view.size_px.x), cell_side = static_cast<size_t>(std::ceil(view.size_px.x / cell));
  gpu::reserve(depth, "lod.sun_depth", 4 * side * static_cast<size_t>(view.size_px.y));
  gpu::reserve(cells, "lod.sun_cells", 4 * cell_side * (cell_side + 1));
  depth.fill(0);
  cells.fill(0);
  depth.bindStorage(rules::kSunDepthBinding);
  cells.bindStorage(rules::kSunCellsBinding);
  for (gpu::Program* program : {&cells_program, &depth_program}) {
    if (!program->use()) return;
    program->set(kCellTexels, cell);
    for (const Part& part : state.parts) {
      if (!part.casts) continue;
      program->set(kShapeShare, part.cast_share);
      part.early.bindUniform(rules::kPassBinding);
      part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
      gpu::dispatchItems(part.runs, kGroup);
    }
    gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
}

void draw(const SwarmsDrawn::State& state, SunMap& map) {
  const ShadowView& shadow = state.world.singleton<const ShadowView>();
  if (!(shadow.block.enabled > 0)) return;
  if (map.shadow_version != shadow.version || map.casters_version != state.casters_version) {
    map.splat(state, shadow.block);
    map.shadow_version = shadow.version;
    map.casters_version = state.casters_version;
  }
  if (!map.copy.use()) return;
  map.depth.bindStorage(rules::kSunDepthBinding);
  gpu::apply(shadowDrawState());
  gpu::drawFullScreen();
}

}  // namespace

PassDesc shadowPass(const SharedState& state) {
  const auto map = std::make_shared<SunMap>();
  return {.name = "lod.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a sun and a swarm that casts shadows",
          .needs = [state] { return state->casts && shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, map](PassContext&) { draw(*state, *map); }};
}

}  // namespace scree::lod
