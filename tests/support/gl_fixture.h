// GoogleTest base class for tests that need OpenGL: one context a process, and a test fails on any
// GL debug message or error.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace scree::test {

// The context of this process: of the kind that the environment variable SCREE_TEST_CONTEXT names,
// egl (the default), osmesa or window. Made on first use, with debug output on, and never given
// back. An empty string if all is well, else why there is none.
const std::string& ensureContext();

class GlTest : public ::testing::Test {
 protected:
  // Fails the test, never skips it, if there is no context.
  void SetUp() override;
  void TearDown() override;

  // GL messages that this test provokes on purpose: so many more than before are accepted, exactly.
  void expectMessages(uint64_t count) { expected_messages_ += count; }
  // GL messages since SetUp().
  uint64_t messages() const;

 private:
  uint64_t messages_before_ = 0;
  uint64_t expected_messages_ = 0;
};

}  // namespace scree::test
