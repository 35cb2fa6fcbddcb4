// What the module keeps between frames, and the parts that deferred.cpp registers.
#pragma once

#include <memory>

#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/gpu/program.h"
#include "engine/gpu/stream.h"
#include "modules/deferred/deferred.h"
#include "modules/deferred/lobe_textures.h"
#include "modules/deferred/material_block.h"
#include "modules/deferred/mesh_batches.h"
#include "modules/deferred/shadow_fit.h"

namespace scree {

// Owned by the systems and passes that addDeferred registers, so that its GL objects die with them.
struct DeferredState {
  explicit DeferredState(App& app);

  World& world;
  const Frame& frame;
  Query<const Light, const Transform> lights;
  MeshBatches batches;
  MaterialBlock materials;
  LobeTextures lobes;
  gpu::StreamBuffer blocks{"deferred.blocks", 4096};       // uniform blocks of the frame
  gpu::StreamBuffer instances{"deferred.instances", 256 * 1024};
  gpu::StreamSlice opaque_records;
  bool plain_in_view = false, emission_in_view = false;  // meshes without emission, and with it
  rules::LightingBlock lighting{};
  // As of Phase::Prepare.
  ShadowSettings shadow_settings;
  float exposure = 1;
  std::vector<Entity> warned_lights;  // that were complained about; at most kMostLightWarnings
};
using SharedState = std::shared_ptr<DeferredState>;

// One system or pass each, in the file of that name.
SystemDesc lightSystem(const SharedState& state);   // light_block.cpp
SystemDesc gatherSystem(const SharedState& state);  // gather.cpp
PassDesc opaquePass(const SharedState& state);
PassDesc emissivePass(const SharedState& state);    // opaque.cpp
PassDesc shadowPass(const SharedState& state);
// Hands world.singleton<ShadowView>() to programs.
void bindShadowView(DeferredState& state);  // shadow.cpp
// Whether a pass that shades writes kRadiance, or the display at once because nobody reads kRadiance
// but deferred.present.
enum class ShadesInto : uint8_t { Radiance, Display };
PassDesc lightPass(const SharedState& state, ShadesInto target);
PassDesc skyPass(const SharedState& state, ShadesInto target);
PassDesc accumulatePass(const SharedState& state);
PassDesc presentPass(const SharedState& state);

// In shade.cpp: name, stage, needs and first use of a pass that shades; what it sets its programs.
PassDesc shadePass(const SharedState& state, ShadesInto target, std::string_view verb);
std::vector<std::string> shadedDefines(ShadesInto target, std::vector<std::string> more = {});
void setExposure(const DeferredState& state, ShadesInto target, gpu::Program& program);
bool presentNeeded(const DeferredState& state);

// A program whose vertex shader covers the screen: lib/full_screen.vert, or one that does more.
gpu::Program fullScreenProgram(std::string name, std::vector<std::string> defines = {},
                               std::string vertex = "lib/full_screen.vert");

}  // namespace scree
