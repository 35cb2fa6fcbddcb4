// What the passes that shade have in common: into the radiance target or, if nobody else would read
// that, straight into the frame's output, which saves writing and reading it.
#include <fmt/format.h>

#include "modules/deferred/state.h"

namespace scree {
namespace {

// A frame that shows nothing but sky is not worth programs of its own.
bool displaysAtOnce(const DeferredState& state) {
  return state.batches.any() && state.batches.opaqueCount() > 0 &&
         !state.frame.isWanted(kRadiance, "deferred.present");
}

}  // namespace

bool presentNeeded(const DeferredState& state) {
  return !displaysAtOnce(state);
}

PassDesc shadePass(const SharedState& state, ShadesInto target, std::string_view verb) {
  const bool display = target == ShadesInto::Display;
  return {.name = fmt::format("deferred.{}{}", display ? "display_" : "", verb),
          .stage = display ? Stage::Present : Stage::Shade,
          .needs_text = display ? "a mesh in view and no reader of radiance" : "a reader of radiance, or no mesh in view",
          .needs = [state, display] { return displaysAtOnce(*state) == display; },
          .uses = {{std::string(display ? Frame::kOutput : kRadiance), Access::Color}}};
}

std::vector<std::string> shadedDefines(ShadesInto target, std::vector<std::string> more) {
  if (target == ShadesInto::Display) more.push_back("DISPLAY");
  return more;
}

void setExposure(const DeferredState& state, ShadesInto target, gpu::Program& program) {
  if (target == ShadesInto::Display) program.set(0, state.exposure);
}

}  // namespace scree
