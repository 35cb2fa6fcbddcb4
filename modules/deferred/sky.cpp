// deferred.sky: radiance of the sky where nothing was drawn.
#include "engine/gpu/draw.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"

namespace scree {

PassDesc skyPass(const SharedState& state) {
  const auto program = std::make_shared<gpu::Program>(fullScreenProgram("deferred.sky"));
  return {.name = "deferred.sky",
          .stage = Stage::Shade,
          .uses = {{std::string(kRadiance), Access::Color}, {std::string(kGbufferDepth), Access::DepthTest}},
          .run = [state, program](PassContext&) {
            if (!program->use()) return;
            gpu::apply({.depth_func = gpu::Compare::Equal, .depth_write = false});
            gpu::drawFullScreen();
          }};
}

}  // namespace scree
