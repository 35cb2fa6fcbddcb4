// One pass of one draw call.
#include "tests/bench/raster_impostors.h"

#include <memory>

#include "engine/core/file.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "engine/gpu/stream.h"
#include "modules/deferred/deferred.h"
#include "modules/impostors/impostors.h"

namespace scree::bench {
namespace {

struct Sprites {
  gpu::Program program;
  gpu::Buffer records;
  gpu::StreamBuffer blocks{"bench.blocks"};
  int count = 0;
};

gpu::Program spriteProgram(const std::filesystem::path& folder) {
  const auto kinds = std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing;
  std::filesystem::copy(shaderRoot(), folder, kinds);
  std::filesystem::copy(SCREE_BENCH_SHADERS, folder, kinds);
  return gpu::Program({.name = "bench.sprites", .vertex = "sprites.vert", .fragment = "sprites.frag", .root = folder});
}

}  // namespace

void addRasterImpostors(HeapScene& scene, const Heap& heap, const std::filesystem::path& folder) {
  const auto sprites = std::make_shared<Sprites>();
  sprites->program = spriteProgram(folder);
  std::vector<rules::SwarmRecord> records;
  for (const SwarmGrain& bean : heap.beans) records.push_back(packed(bean, heap.bean_radius));
  sprites->records = gpu::Buffer("bench.records", std::span<const rules::SwarmRecord>(records));
  sprites->count = static_cast<int>(records.size());
  scene.app.addPass({.name = "bench.sprites",
                     .stage = Stage::Geometry,
                     .uses = gbufferUses({{std::string(kGbufferSpread), Access::StorageWrite}}),
                     .run = [&scene, sprites, radius = heap.bean_radius](PassContext&) {
                       if (!sprites->program.use()) return;
                       rules::SwarmBlock block{};
                       block.origin = vec4(-vec3(scene.world.singleton<const View>().position), radius);
                       block.first_id = block.same_id = 1;
                       sprites->blocks.beginFrame();
                       sprites->blocks.write(block).bindUniform(rules::kPassBinding);
                       sprites->records.bindStorage(rules::kSwarmRecordsBinding);
                       scene.world.singleton<ImpostorStore>().bindTextures(scene.shape);
                       gpu::apply({.cull = gpu::Cull::None, .program_point_size = true});
                       gpu::drawVertexless(GL_POINTS, sprites->count);
                     }});
}

}  // namespace scree::bench
