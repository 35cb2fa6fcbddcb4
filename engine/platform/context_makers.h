// Private to engine/platform: the makers behind makeContext, and what they share.
#pragma once

#include "engine/platform/context.h"

namespace scree {

// Each makes its context and makes it current; the error is the reason, without the kind's name.
Result<std::unique_ptr<Context>> makeWindowContext(const ContextDesc& desc);
Result<std::unique_ptr<Context>> makeEglContext(const ContextDesc& desc);
Result<std::unique_ptr<Context>> makeOsMesaContext(const ContextDesc& desc);

// What a current context says about itself.
struct DriverInfo {
  std::string renderer;
  std::string version;
};
// Refuses what is not OpenGL 4.5 or later.
Result<DriverInfo> queryDriver(GlLoader load);

// A size within what ContextDesc allows, for resize().
ivec2 clampedSize(ivec2 size);

}  // namespace scree
