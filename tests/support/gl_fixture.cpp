// The test process's context.
#include "tests/support/gl_fixture.h"

#include <cstdlib>
#include <memory>

#include "engine/core/log.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/state.h"
#include "engine/platform/context.h"

namespace scree::test {
namespace {

std::string makeTestContext() {
  const char* wanted = std::getenv("SCREE_TEST_CONTEXT");
  Result<ContextKind> kind = parseContextKind(wanted && *wanted ? wanted : "egl");
  if (!kind.ok()) return "SCREE_TEST_CONTEXT: " + kind.error();
  ContextDesc desc;
  desc.kind = *kind;
  desc.size = {64, 64};
  desc.debug = true;
  Result<std::unique_ptr<Context>> made = makeContext(desc);
  if (!made.ok()) return made.error();
  // Never destroyed: objects that a test leaves in static storage must not outlive it.
  static Context* const context = std::move(*made).release();
  context->makeCurrent();
  if (Status loaded = gpu::loadFunctions(context->getProcAddress()); !loaded.ok())
    return loaded.error();
  // OSMesa knows no debug flag, but has debug output.
  gpu::enableDebugOutput();
  logInfo("test context: {}", context->description());
  return {};
}

}  // namespace

const std::string& ensureContext() {
  static const std::string problem = makeTestContext();
  return problem;
}

void GlTest::SetUp() {
  ASSERT_EQ(ensureContext(), "");
  gpu::drainErrors();
  gpu::forgetState();
  messages_before_ = gpu::debugMessageCount();
}

void GlTest::TearDown() {
  if (!ensureContext().empty()) return;
  glFinish();
  const int errors = gpu::drainErrors();
  if (expected_messages_ == 0) {
    EXPECT_EQ(errors, 0) << "GL error codes";
  }
  EXPECT_EQ(messages(), expected_messages_) << "last message: " << gpu::lastDebugMessage();
}

uint64_t GlTest::messages() const {
  return gpu::debugMessageCount() - messages_before_;
}

}  // namespace scree::test
