// GoogleTest assertions over the image gate.
#pragma once

#include <gtest/gtest.h>

#include "tests/support/image_gate.h"

namespace scree::images {

inline testing::AssertionResult asAssertion(const GateResult& result) {
  return (result.passed ? testing::AssertionSuccess() : testing::AssertionFailure())
         << result.message;
}

}  // namespace scree::images

// EXPECT_GOLDEN(image, "grains/heap") or EXPECT_GOLDEN(image, "grains/heap", bounds): compares with
// tests/grains/golden/heap.png.
#define EXPECT_GOLDEN(image, name, ...)     \
  EXPECT_TRUE(::scree::images::asAssertion( \
      ::scree::images::gate(image, ::scree::images::goldenPath(name) __VA_OPT__(, ) __VA_ARGS__)))
// EXPECT_SAME_IMAGE(a, b) or EXPECT_SAME_IMAGE(a, b, bounds): default is every pixel equal.
#define EXPECT_SAME_IMAGE(actual, expected, ...) \
  EXPECT_TRUE(::scree::images::asAssertion(      \
      ::scree::images::compareImages(actual, expected __VA_OPT__(, ) __VA_ARGS__)))
