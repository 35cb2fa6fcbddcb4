// deferred.present: exposure, tone curve and sRGB encoding into the frame's output.
#include "engine/gpu/draw.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"
#include "shaders/shared/bindings.h"

namespace scree {

PassDesc presentPass(const SharedState& state) {
  const auto program = std::make_shared<gpu::Program>(fullScreenProgram("deferred.present"));
  return {.name = "deferred.present",
          .stage = Stage::Present,
          .needs_text = "radiance that was not displayed at once",
          .needs = [state] { return presentNeeded(*state); },
          .uses = {{std::string(kRadiance), Access::Sampled},
                   {std::string(kTruth), Access::Sampled},
                   {std::string(Frame::kOutput), Access::Color}},
          .run = [state, program](PassContext& context) {
            if (!program->use()) return;
            const bool truth = context.frame.hasContent(kTruth);
            context.frame.bindSampled(truth ? kTruth : kRadiance, rules::kRadianceUnit);
            program->set(0, state->exposure);
            gpu::apply({.depth_test = false, .depth_write = false});
            gpu::drawFullScreen();
          }};
}

}  // namespace scree
