// lod.meshes, lod.meshes_late: near grains, as instances of their shape's mesh.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/state.h"

namespace scree::lod {
namespace {

constexpr unsigned kGrainSlot = 1;
constexpr int kOverdrawAttachment = 5;  // after the G-buffer's and kSwarmVisible
constexpr int kBaseColor = 0, kRoughnessMetallic = 1, kDoubleSided = 2;  // uniform locations

struct MeshPrograms {
  gpu::Program still = program({}), moving = program({"MOTION"});
  gpu::Program counting = program({"OVERDRAW 5"}), counting_moving = program({"MOTION", "OVERDRAW 5"});
  gpu::VertexArray array;
  uint64_t pool_version = 0;

  static gpu::Program program(std::vector<std::string> defines) {
    std::string name = "lod.meshes";
    for (const std::string& define : defines) name.append("_").append(define, 0, define.find(' '));
    return gpu::Program({.name = std::move(name),
                         .vertex = "lod/mesh.vert",
                         .fragment = "lod/mesh.frag",
                         .defines = std::move(defines)});
  }
  void bindArray(MeshStore& meshes) {
    meshes.vertexArray();
    if (!array) {
      array = gpu::VertexArray("lod.meshes");
      array.attributeInteger(rules::kFirstFreeAttribute, 1, GL_UNSIGNED_INT, 0, kGrainSlot);
    }
    if (pool_version != meshes.poolVersion()) {
      meshes.attach(array);
      pool_version = meshes.poolVersion();
    }
    array.bind();
  }
};

// `first`: rules::kFirst, or 0.
void draw(SwarmsDrawn::State& state, MeshPrograms& programs, const Frame& frame, uint32_t first) {
  const bool motion = frame.isRead(kGbufferMotion), counts = frame.isRead(kSwarmOverdraw);
  gpu::Program& program = counts ? (motion ? programs.counting_moving : programs.counting)
                                 : (motion ? programs.moving : programs.still);
  if (!program.use()) return;
  MeshStore& meshes = state.world.singleton<MeshStore>();
  MaterialStore& materials = state.world.singleton<MaterialStore>();
  const SwarmStore& store = state.world.singleton<const SwarmStore>();
  programs.bindArray(meshes);
  gpu::DrawState draw_state;
  if (counts) {
    draw_state.blend = gpu::Blend::Add;
    draw_state.blend_attachment = kOverdrawAttachment;
  }
  for (const Part& part : state.parts) {
    const GrainShape& shape = store.shape(part.shape);
    part.early.bindUniform(rules::kPassBinding);
    part.chunk->records.bindStorage(rules::kSwarmRecordsBinding);
    programs.array.vertexBuffer(kGrainSlot, part.routes->list, sizeof(uint32_t), 0, 1);
    const std::vector<MeshPart>& mesh_parts = meshes.mesh(shape.levels.front().mesh).parts;
    for (size_t k = 0; k < mesh_parts.size(); ++k) {
      const MaterialData& material = materials.material(mesh_parts[k].material);
      draw_state.cull = material.double_sided ? gpu::Cull::None : gpu::Cull::Back;
      gpu::apply(draw_state);
      program.set(kDoubleSided, material.double_sided ? 1 : 0);
      program.set(kBaseColor, material.base_color);
      program.set(kRoughnessMetallic, vec2(material.roughness, material.metallic));
      materials.bind(mesh_parts[k].material);
      constexpr size_t kCommand = sizeof(rules::DrawElementsCommand);
      gpu::drawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, part.routes->commands,
                                offsetof(rules::SwarmCommands, meshes) +
                                    rules::meshCommand(rules::kMesh + first, static_cast<uint32_t>(k)) * kCommand,
                                static_cast<int>(shape.levels.size()), static_cast<int>(rules::kMeshParts * kCommand));
    }
  }
}

PassDesc passOf(const SharedState& state, const char* name, Stage stage, std::string_view lists, uint32_t first) {
  const auto programs = std::make_shared<MeshPrograms>();
  return {.name = name,
          .stage = stage,
          .needs_text = "a swarm that may be meshes",
          .needs = [state] { return state->possible >> rules::kMesh != 0; },
          .needs_content = {std::string(lists)},
          .uses = gbufferUses({{std::string(kSwarmVisible), Access::Color},
                               {std::string(kSwarmOverdraw), Access::Color},
                               {std::string(lists), Access::Indirect},
                               {std::string(lists), Access::Vertex}}),
          .run = [state, programs, first](PassContext& context) {
            draw(*state, *programs, context.frame, first);
          }};
}

}  // namespace

PassDesc meshPass(const SharedState& state) {
  return passOf(state, "lod.meshes", Stage::Geometry, kSwarmLists, rules::kFirst);
}

PassDesc lateMeshPass(const SharedState& state) {
  return passOf(state, "lod.meshes_late", Stage::GeometryLate, kSwarmLateLists, 0);
}

}  // namespace scree::lod
