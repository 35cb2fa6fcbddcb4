// One EGL context for all benches of a run.
#include "tests/bench/gl_context.h"

#include <memory>

#include "engine/core/log.h"
#include "engine/gpu/load.h"
#include "engine/platform/context.h"

namespace scree::bench {

void openContext() {
  static std::unique_ptr<Context> context;
  if (context) return;
  Result<std::unique_ptr<Context>> made = makeContext({.kind = ContextKind::Egl, .size = {64, 64}});
  if (!made.ok()) fail(made.error());
  context = std::move(*made);
  context->makeCurrent();
  if (Status loaded = gpu::loadFunctions(context->getProcAddress()); !loaded.ok()) fail(loaded.error());
}

}  // namespace scree::bench
