// lod.shadow: grains into the sun's shadow map. Splatted by compute, and kept as long as neither the grains nor
// the map's place change: millions of discs cost too much to be drawn anew in each frame.
#include <algorithm>
#include <array>
#include <bit>

#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"
#include "modules/lod/sun_map.h"
#include "shaders/shared/tiles.h"

namespace scree::lod {
namespace {

constexpr int kLastClass = 0, kPerLargest = 1, kShapeShare = 2, kLargeTexels = 3, kListAt = 4, kCellClasses = 5;  // uniforms
constexpr uint32_t kGroup = 64;
constexpr float kLarge = 12;  // radius in texels: a run of 64 grains then is 40,000 rounds at most; see lod/sun_disc.glsl

gpu::Program compute(const char* name, std::vector<std::string> defines = {}) {
  return gpu::Program({.name = std::string("lod.") + name + (defines.empty() ? "" : "_list"),
                       .compute = std::string("lod/") + name + ".comp",
                       .defines = std::move(defines)});
}

// What lod/sun.glsl says of cells.
struct Cells {
  float largest_texels = 0;
  std::array<vec4, 12> classes{};
  uint32_t last_class = 0;
  uint32_t count = 0;  // of all classes
};

Cells cellsOf(float largest_m, float least_m, const rules::ShadowViewBlock& view) {
  const auto side = static_cast<uint32_t>(view.size_px.x);
  Cells cells{.largest_texels = largest_m / view.texel_m};
  // A disc's radius wide: where discs lie close, next to no sun comes through between those that cast.
  const auto first = static_cast<uint32_t>(std::clamp(cells.largest_texels, 1.0f, view.size_px.x));
  const float ratio = least_m > 0 ? std::clamp(largest_m / least_m, 1.0f, 4096.0f) : 4096;
  const auto classOf = [](uint32_t ratio2) { return std::bit_width(ratio2) - 1; };
  const int last = std::min(classOf(static_cast<uint32_t>(2 * ratio * ratio)) / 2, classOf(first));
  cells.last_class = static_cast<uint32_t>(last);
  for (int k = 0; k <= last; ++k) {
    const uint32_t cell = first >> k, across = (side + cell - 1) / cell;
    cells.classes[static_cast<size_t>(k)] = vec4(1.0f / static_cast<float>(cell), across, cells.count, 0);
    cells.count += across * across;
  }
  return cells;
}

size_t tilesOf(const rules::ShadowViewBlock& view) {
  const ivec2 tiles = rules::tileCount(ivec2(view.size_px));
  return static_cast<size_t>(tiles.x) * static_cast<size_t>(tiles.y);
}

struct SunPrograms {
  gpu::Program cells = compute("sun_cells"), depth = compute("sun_depth"), depth_list = compute("sun_depth", {"LIST"}),
               discs = compute("sun_discs");
  gpu::Program copy{{.name = "lod.shadow", .vertex = "lod/sun.vert", .fragment = "lod/sun.frag"}};
};

Cells fit(const SwarmsDrawn::State& state, const rules::ShadowViewBlock& view) {
  const SwarmStore& store = state.world.singleton<const SwarmStore>();
  float largest_m = 0, least_m = 1e30f;
  for (const CasterSeen& caster : state.casters_seen) {
    const SwarmStore::Stored& stored = store.swarm(caster.swarm);
    const float share = store.shape(stored.shape).cast_share;
    largest_m = std::max(largest_m, stored.largest_radius * share);
    least_m = std::min(least_m, stored.least_radius * share);
  }
  return cellsOf(largest_m, least_m, view);
}

void splat(const SwarmsDrawn::State& state, SunPrograms& programs, SunMap& map, const rules::ShadowViewBlock& view) {
  const Cells fitted = fit(state, view);
  const size_t texels = static_cast<size_t>(view.size_px.x) * static_cast<size_t>(view.size_px.y);
  gpu::reserve(map.depth, "lod.sun_depth", 4 * (texels + tilesOf(view)));
  const bool lists = fitted.largest_texels > kLarge;
  gpu::reserve(map.cells, "lod.sun_cells", 4 * (size_t{fitted.count} + (lists ? 4 + 4 * size_t{rules::kMostWorkGroups} : 0)));
  gpu::barrier(GL_BUFFER_UPDATE_BARRIER_BIT);  // programs wrote both when it was last splatted
  map.depth.fill(0);
  map.cells.fill(0);
  map.depth.bindStorage(rules::kSunDepthBinding);
  map.cells.bindStorage(rules::kSunCellsBinding);
  for (gpu::Program* program : {&programs.cells, lists ? &programs.depth_list : &programs.depth}) {
    if (!program->use()) return;
    program->set(kLastClass, fitted.last_class);
    program->set(kPerLargest, 1 / fitted.largest_texels);
    program->set(kCellClasses, std::span<const vec4>(fitted.classes));
    if (program == &programs.depth_list) {
      program->set(kLargeTexels, kLarge);
      program->set(kListAt, fitted.count);
    }
    for (const Part& part : state.parts) {
      if (!part.casts) continue;
      program->set(kShapeShare, part.cast_share);
      part.early.bindUniform(rules::kPassBinding);
      part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
      gpu::dispatchItems(part.runs, kGroup);
    }
    gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
  }
  if (!lists || !programs.discs.use()) return;
  programs.discs.set(kListAt, fitted.count);
  gpu::dispatchIndirect(map.cells, 4 * size_t{fitted.count});
  gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void draw(SwarmsDrawn::State& state, SunPrograms& programs) {
  SunMap& map = *state.sun_map;
  const ShadowView& shadow = state.world.singleton<const ShadowView>();
  if (map.shadow_version != shadow.version || map.casters_version != state.casters_version) {
    splat(state, programs, map, shadow.block);
    map.shadow_version = shadow.version;
    map.casters_version = state.casters_version;
  }
  if (!programs.copy.use()) return;
  map.depth.bindStorage(rules::kSunDepthBinding);
  gpu::apply(shadowDrawState());
  gpu::drawVertexless(GL_TRIANGLES, 6 * static_cast<int>(tilesOf(shadow.block)));
}

}  // namespace

PassDesc shadowPass(const SharedState& state) {
  const auto programs = std::make_shared<SunPrograms>();
  return {.name = "lod.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a swarm that casts, and a shadow that has changed",
          .needs = [state] { return state->casts && shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, programs](PassContext&) { draw(*state, *programs); }};
}

}  // namespace scree::lod
