// deferred.sky, deferred.display_sky: radiance of the sky where nothing was drawn.
#include "engine/gpu/draw.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"

namespace scree {

PassDesc skyPass(const SharedState& state, ShadesInto target) {
  const auto program = std::make_shared<gpu::Program>(fullScreenProgram("deferred.sky", shadedDefines(target)));
  PassDesc desc = shadePass(state, target, "sky");
  desc.uses.push_back({std::string(kGbufferDepth), Access::DepthTest});
  desc.run = [state, target, program](PassContext&) {
    if (!program->use()) return;
    setExposure(*state, target, *program);
    gpu::apply({.depth_func = gpu::Compare::Equal, .depth_write = false});
    gpu::drawFullScreen();
  };
  return desc;
}

}  // namespace scree
