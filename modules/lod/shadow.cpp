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
#include "shaders/shared/tiles.h"

namespace scree::lod {
namespace {

constexpr int kLastClass = 0, kPerLargest = 1, kShapeShare = 2, kLargeTexels = 3, kListAt = 4, kCellClasses = 5;  // uniforms
constexpr uint32_t kGroup = 64;
constexpr float kLarge = 12;  // radius in texels: a run of 64 grains then is 40,000 rounds at most; see lod/sun_disc.glsl
constexpr size_t kMostListed = 65535;

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

struct SunMap {
  gpu::Program cells_program = compute("sun_cells"), depth_program = compute("sun_depth"),
               depth_list_program = compute("sun_depth", {"LIST"}), discs_program = compute("sun_discs");
  gpu::Program copy{{.name = "lod.shadow", .vertex = "lod/sun.vert", .fragment = "lod/sun.frag"}};
  gpu::Buffer cells;
  gpu::Buffer depth;  // by texel, and which tiles are not empty
  uint64_t shadow_version = 0, casters_version = 0;  // of what `depth` holds

  void splat(const SwarmsDrawn::State& state, const rules::ShadowViewBlock& view);
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

void SunMap::splat(const SwarmsDrawn::State& state, const rules::ShadowViewBlock& view) {
  const Cells fitted = fit(state, view);
  const size_t texels = static_cast<size_t>(view.size_px.x) * static_cast<size_t>(view.size_px.y);
  gpu::reserve(depth, "lod.sun_depth", 4 * (texels + tilesOf(view)));
  const bool lists = fitted.largest_texels > kLarge;
  gpu::reserve(cells, "lod.sun_cells", 4 * (size_t{fitted.count} + (lists ? 4 + 4 * kMostListed : 0)));
  depth.fill(0);
  cells.fill(0);
  depth.bindStorage(rules::kSunDepthBinding);
  cells.bindStorage(rules::kSunCellsBinding);
  for (gpu::Program* program : {&cells_program, lists ? &depth_list_program : &depth_program}) {
    if (!program->use()) return;
    program->set(kLastClass, fitted.last_class);
    program->set(kPerLargest, 1 / fitted.largest_texels);
    program->set(kCellClasses, std::span<const vec4>(fitted.classes));
    if (program == &depth_list_program) {
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
  if (!lists || !discs_program.use()) return;
  discs_program.set(kListAt, fitted.count);
  gpu::dispatchIndirect(cells, 4 * size_t{fitted.count});
  gpu::barrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void draw(const SwarmsDrawn::State& state, SunMap& map) {
  const ShadowView& shadow = state.world.singleton<const ShadowView>();
  if (map.shadow_version != shadow.version || map.casters_version != state.casters_version) {
    map.splat(state, shadow.block);
    map.shadow_version = shadow.version;
    map.casters_version = state.casters_version;
  }
  if (!map.copy.use()) return;
  map.depth.bindStorage(rules::kSunDepthBinding);
  gpu::apply(shadowDrawState());
  gpu::drawVertexless(GL_TRIANGLES, 6 * static_cast<int>(tilesOf(shadow.block)));
}

}  // namespace

PassDesc shadowPass(const SharedState& state) {
  const auto map = std::make_shared<SunMap>();
  return {.name = "lod.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a swarm that casts, and a shadow that has changed",
          .needs = [state] { return state->casts && shadowsWanted(state->world); },
          .uses = shadowUses(),
          .run = [state, map](PassContext&) { draw(*state, *map); }};
}

}  // namespace scree::lod
