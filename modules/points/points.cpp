// points.depth, points.list, points.sum, points.count, points.resolve, and the buffers between them: all zero between two
// frames, and given back where there is no swarm.
#include "modules/points/points.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "engine/app/app.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/lod.h"
#include "shaders/shared/points.h"

namespace scree {
namespace {

constexpr const char *kKeys = "points.keys", *kList = "points.list", *kSums = "points.sums", *kTiles = "points.tiles";
constexpr int kSurface = 0, kFacing = 1, kLeastArea = 2;  // uniform locations
constexpr size_t kAll = offsetof(rules::SwarmCommands, point_groups), kSeen = offsetof(rules::SwarmCommands, seen_groups);
// A pixel is drawn if points of a bed cover at least this share of it, or a point shows in it.
constexpr float kLeastShare = 0.5f;

// What a program is compiled for.
enum Feature : unsigned { kMotion = 1, kIds = 2, kSurfaces = 4, kFeatureSets = 8 };

gpu::Program programOf(const std::string& name, unsigned features) {
  gpu::ProgramDesc desc{.name = "points." + name};
  if (name == "resolve") {
    desc.vertex = "lib/tiles.vert";
    desc.fragment = "points/resolve.frag";
  } else {
    desc.compute = "points/" + name + ".comp";
  }
  const auto define = [&](unsigned feature, const char* text) {
    if ((features & feature) == 0) return;
    desc.defines.push_back(text);
    desc.name += std::string("_") + text;
  };
  define(kMotion, "MOTION");
  define(kIds, "IDS");
  define(kSurfaces, "SURFACES");
  return gpu::Program(std::move(desc));
}

using Programs = std::array<std::optional<gpu::Program>, kFeatureSets>;

struct Points {
  explicit Points(App& app) : world(app.world()) {}

  World& world;
  gpu::Buffer keys, sums, carries, foremost, ids, surfaces;  // by pixel
  MarkedTiles tiles{kTiles};
  gpu::Program depth = programOf("depth", 0), list = programOf("list", 0);
  gpu::Program count{{.name = "points.count", .compute = "points/sum.comp", .defines = {"OVERDRAW"}}};
  Programs sum, resolve, empty;

  const SwarmsDrawn& swarms() { return world.singleton<const SwarmsDrawn>(); }
  void giveBack() {
    for (gpu::Buffer* buffer : {&keys, &sums, &carries, &foremost, &ids, &surfaces}) *buffer = {};
    tiles.giveBack();
  }
  const GrainShape& shape(size_t part) {
    return world.singleton<const SwarmStore>().shape(swarms().part(part).shape);
  }
  // What points look like, but for colour.
  struct Look {
    vec2 surface{0};  // roughness, metalness; of some point
    bool one = true;  // of all of them
    float facing = 0;  // mean over the parts
  };
  Look look() {
    Look look;
    float parts = 0;
    for (size_t k = 0; k < swarms().size(); ++k) {
      const SwarmPart& part = swarms().part(k);
      if ((part.possible >> rules::kPoint & 1) == 0) continue;
      const vec2 surface(shape(k).roughness * part.least_roughness, shape(k).metallic);
      look.one = look.one && (parts == 0 || surface == look.surface) && part.least_roughness == part.most_roughness;
      look.surface = surface;
      look.facing += shape(k).facing;
      ++parts;
    }
    look.facing /= std::max(parts, 1.0f);
    return look;
  }
  // Points that differ in more than colour sum that up too.
  unsigned features(const Frame& frame) {
    return (frame.isRead(kGbufferMotion) ? kMotion : 0u) | (frame.isRead(kGbufferId) ? kIds : 0u) | (look().one ? 0u : kSurfaces);
  }
  static gpu::Program& made(Programs& programs, const char* name, unsigned set) {
    if (!programs[set]) programs[set] = programOf(name, set);
    return *programs[set];
  }
  // The buffer of `words` a pixel, bound.
  static void ready(gpu::Buffer& buffer, const char* label, size_t words, int binding, ivec2 size) {
    if (gpu::reserve(buffer, label, 4 * words * static_cast<size_t>(size.x) * static_cast<size_t>(size.y))) buffer.fill(0);
    buffer.bindStorage(static_cast<unsigned>(binding));
  }
  // Of each part: work groups for kAll points or the kSeen.
  void dispatch(size_t groups) {
    const SwarmsDrawn& drawn = swarms();
    for (size_t k = 0; k < drawn.size(); ++k) {
      drawn.bind(k);
      gpu::dispatchIndirect(*drawn.part(k).commands, groups);
    }
  }
};

void splatDepth(Points& points, ivec2 size) {
  if (!points.depth.use()) return;
  Points::ready(points.keys, kKeys, 1, rules::kPointKeysBinding, size);
  points.tiles.ready(size);
  points.dispatch(kAll);
}

void listSeen(Points& points) {
  if (!points.list.use()) return;
  points.keys.bindStorage(rules::kPointKeysBinding);
  points.dispatch(kAll);
}

void splatSums(Points& points, ivec2 size, unsigned features) {
  features &= kIds | kSurfaces;
  if (!Points::made(points.sum, "sum", features).use()) return;
  Points::ready(points.sums, kSums, 4, rules::kPointSumsBinding, size);
  Points::ready(points.carries, "points.carries", 1, rules::kPointCarriesBinding, size);
  Points::ready(points.foremost, "points.foremost", 1, rules::kPointForemostBinding, size);
  if ((features & kIds) != 0) Points::ready(points.ids, "points.ids", 1, rules::kPointIdsBinding, size);
  if ((features & kSurfaces) != 0)
    Points::ready(points.surfaces, "points.surfaces", 2, rules::kPointSurfacesBinding, size);
  points.keys.bindStorage(rules::kPointKeysBinding);
  points.dispatch(kSeen);
}

// For SwarmView::Overdraw.
void count(Points& points, const gpu::Texture& overdraw) {
  if (!points.count.use()) return;
  overdraw.bindImage(rules::kOverdrawImage, GL_READ_WRITE);
  points.dispatch(kSeen);
}

void resolve(Points& points, unsigned features) {
  gpu::Program& program = Points::made(points.resolve, "resolve", features);
  if (!program.use()) return;
  const Points::Look look = points.look();
  program.set(kSurface, look.surface);
  program.set(kFacing, look.facing);
  program.set(kLeastArea, kLeastShare);
  points.keys.bindStorage(rules::kPointKeysBinding);
  points.sums.bindStorage(rules::kPointSumsBinding);
  points.carries.bindStorage(rules::kPointCarriesBinding);
  points.foremost.bindStorage(rules::kPointForemostBinding);
  if ((features & kIds) != 0) points.ids.bindStorage(rules::kPointIdsBinding);
  if ((features & kSurfaces) != 0) points.surfaces.bindStorage(rules::kPointSurfacesBinding);
  gpu::apply({.cull = gpu::Cull::None});
  points.tiles.draw();
  if (Points::made(points.empty, "empty", features & kIds).use()) points.tiles.empty();
}

}  // namespace

void addPoints(App& app) {
  const auto points = std::make_shared<Points>(app);
  const auto needs = [points] { return points->swarms().mayBe(rules::kPoint); };
  constexpr const char* kNeeds = "a swarm that may be points";
  app.frame().addExternal(kKeys);
  app.frame().addExternal(kList);
  app.frame().addExternal(kSums);
  app.frame().addExternal(kTiles);

  app.addSystem({.name = "points.give_back",
                 .phase = Phase::Prepare,
                 .needs = [points] { return points->tiles.held() && points->swarms().size() == 0; },
                 .run = [points](World&) { points->giveBack(); }});

  app.addPass({.name = "points.depth",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {std::string(kSwarmLists)},
               .uses = {{std::string(kSwarmRoutes), Access::StorageRead},
                        {std::string(kSwarmLists), Access::Indirect},
                        {kKeys, Access::StorageWrite},
                        {kList, Access::StorageWrite},
                        {kTiles, Access::StorageWrite}},
               .run = [points](PassContext& context) { splatDepth(*points, context.input.size); }});
  app.addPass({.name = "points.list",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {kKeys},
               .uses = {{std::string(kSwarmRoutes), Access::StorageRead},
                        {std::string(kSwarmLists), Access::Indirect},
                        {kKeys, Access::StorageRead},
                        {kList, Access::StorageWrite}},
               .run = [points](PassContext&) { listSeen(*points); }});
  app.addPass({.name = "points.sum",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {kList},
               .uses = {{kList, Access::StorageRead},
                        {kList, Access::Indirect},
                        {kKeys, Access::StorageWrite},
                        {kSums, Access::StorageWrite}},
               .run = [points](PassContext& context) {
                 splatSums(*points, context.input.size, points->features(context.frame));
               }});
  app.addPass({.name = "points.count",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {kList},
               .uses = {{kList, Access::StorageRead},
                        {kList, Access::Indirect},
                        {std::string(kPointOverdraw), Access::StorageWrite}},
               .run = [points](PassContext& context) { count(*points, context.frame.texture(kPointOverdraw)); }});
  app.addPass({.name = "points.resolve",
               .stage = Stage::GeometryLate,
               .needs_text = kNeeds,
               .needs = needs,
               .needs_content = {kSums},
               .uses = gbufferUses({{kKeys, Access::StorageWrite},
                                    {std::string(kGbufferSpread), Access::StorageWrite},
                                    {kSums, Access::StorageWrite},
                                    {kTiles, Access::Indirect},
                                    {kTiles, Access::StorageWrite}}),
               .run = [points](PassContext& context) { resolve(*points, points->features(context.frame)); }});
}

}  // namespace scree
