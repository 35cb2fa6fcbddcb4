// deferred.opaque, deferred.emissive: draw mesh instances into the G-buffer.
#include <array>

#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"
#include "modules/deferred/mesh_array.h"
#include "modules/deferred/state.h"

namespace scree {
namespace {

gpu::Program opaqueProgram(uint32_t features, bool motion) {
  gpu::ProgramDesc desc{.name = features & kFeatureEmission ? "deferred.emissive" : "deferred.opaque",
                         .vertex = "deferred/opaque.vert",
                         .fragment = "deferred/opaque.frag"};
  const auto define = [&](uint32_t bits, const char* name) {
    if (features & bits) desc.defines.push_back(name);
  };
  define(kFeatureMaps, "TEXTURED");
  define(kFeatureBaseColorMap, "BASE_COLOR_MAP");
  define(kFeatureMetallicRoughnessMap, "METALLIC_ROUGHNESS_MAP");
  define(kFeatureNormalMap, "NORMAL_MAP");
  define(kFeatureEmissiveMap, "EMISSIVE_MAP");
  define(kFeatureEmission, "EMISSION");
  define(kFeatureAlphaMask, "ALPHA_MASK");
  define(kFeatureDoubleSided, "DOUBLE_SIDED");
  if (motion) desc.defines.push_back("MOTION");
  return gpu::Program(std::move(desc));
}

struct OpaquePass {
  std::array<gpu::Program, 2 * kFeatureSets> programs;  // without and with motion
  std::array<bool, 2 * kFeatureSets> made{};
  MeshArray array{"deferred.opaque", 6, true, sizeof(rules::MeshInstanceRecord)};

  gpu::Program& program(uint32_t features, bool motion) {
    const uint32_t index = features + (motion ? kFeatureSets : 0);
    if (!made[index]) programs[index] = opaqueProgram(features, motion);
    made[index] = true;
    return programs[index];
  }
  // Of what is in view, the parts that emit, or those that do not.
  void draw(DeferredState& state, bool emitting, bool motion);
};

void OpaquePass::draw(DeferredState& state, bool emitting, bool motion) {
  MeshStore& meshes = state.world.singleton<MeshStore>();
  MaterialStore& materials = state.world.singleton<MaterialStore>();
  array.bind(meshes, state.opaque_records);
  gpu::DrawState draw_state;
  for (const MeshBatch& batch : state.batches.opaque()) {
    for (const MeshPart& part : meshes.mesh(batch.mesh).parts) {
      const uint32_t material = materialOf(batch, part);
      const uint32_t features = state.materials.features(material);
      if (emitting != ((features & kFeatureEmission) != 0)) continue;
      gpu::Program& drawn_with = program(features, motion);
      if (!drawn_with.use()) continue;
      draw_state.cull = features & kFeatureDoubleSided ? gpu::Cull::None
                        : batch.mirrored               ? gpu::Cull::Front
                                                       : gpu::Cull::Back;
      gpu::apply(draw_state);
      state.materials.bind(material);
      if (features & kFeatureMaps) materials.bind(material);
      gpu::drawElementsInstanced(GL_TRIANGLES, static_cast<int>(part.index_count), GL_UNSIGNED_INT,
                                 size_t{part.first_index} * sizeof(uint32_t),
                                 static_cast<int>(batch.count), part.base_vertex, batch.first);
    }
  }
}

}  // namespace

PassDesc opaquePass(const SharedState& state) {
  const auto pass = std::make_shared<OpaquePass>();
  return {.name = "deferred.opaque",
          .stage = Stage::Geometry,
          .needs_text = "a mesh instance in view",
          .needs = [state] { return state->batches.any() && state->plain_in_view; },
          .uses = gbufferUses(),
          .run = [state, pass](PassContext& context) {
            pass->draw(*state, false, context.frame.isRead(kGbufferMotion));
          }};
}

PassDesc emissivePass(const SharedState& state) {
  const auto pass = std::make_shared<OpaquePass>();
  return {.name = "deferred.emissive",
          .stage = Stage::Emission,
          .needs_text = "a mesh in view that emits light",
          .needs = [state] { return state->batches.any() && state->emission_in_view; },
          .uses = gbufferUses({{std::string(kGbufferEmissive), Access::Color}}),
          .run = [state, pass](PassContext& context) {
            pass->draw(*state, true, context.frame.isRead(kGbufferMotion));
          }};
}

}  // namespace scree
