// deferred.accumulate: truth mode's mean over the samples of a frame.
#include "engine/gpu/draw.h"
#include "engine/gpu/state.h"
#include "modules/deferred/state.h"
#include "shaders/shared/bindings.h"

namespace scree {

PassDesc accumulatePass(const SharedState& state) {
  const auto program = std::make_shared<gpu::Program>(fullScreenProgram("deferred.accumulate"));
  return {.name = "deferred.accumulate",
          .stage = Stage::Lens,
          .needs_text = "truth mode",
          .needs = [state] { return state->world.singleton<const FrameInput>().sample_count > 1; },
          .uses = {{std::string(kRadiance), Access::Sampled}, {std::string(kTruth), Access::Color}},
          .run = [program](PassContext& context) {
            if (!program->use()) return;
            const int sample = context.input.sample;
            context.frame.bindSampled(kRadiance, rules::kRadianceUnit);
            program->set(0, 1.0f / static_cast<float>(sample + 1));
            // The first sample replaces whatever an earlier frame left.
            gpu::apply({.depth_test = false,
                        .depth_write = false,
                        .blend = sample == 0 ? gpu::Blend::None : gpu::Blend::Alpha});
            gpu::drawFullScreen();
          }};
}

}  // namespace scree
