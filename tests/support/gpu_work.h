// What the GPU did in a piece of code, by its own count: zero-count indirect commands do nothing.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <ostream>

#include "engine/gpu/gl.h"
#include "tests/support/gl_fixture.h"

namespace scree::test {

struct GpuWork {
  uint64_t vertices = 0, fragments = 0, computed = 0;  // invocations of shaders
  bool operator==(const GpuWork&) const = default;
};
inline std::ostream& operator<<(std::ostream& out, const GpuWork& work) {
  return out << work.vertices << " vertices, " << work.fragments << " fragments, " << work.computed << " invocations of compute shaders";
}

// By ARB_pipeline_statistics_query.
template <class Code>
GpuWork workOf(const Code& code) {
  constexpr GLenum kTargets[] = {0x82F0, 0x82F4, 0x82F5};  // vertex, fragment, compute shader invocations
  GLuint queries[3] = {};
  glGenQueries(3, queries);
  for (int k = 0; k < 3; ++k) glBeginQuery(kTargets[k], queries[k]);
  code();
  GLuint64 counts[3] = {};
  for (int k = 0; k < 3; ++k) glEndQuery(kTargets[k]);
  for (int k = 0; k < 3; ++k) glGetQueryObjectui64v(queries[k], GL_QUERY_RESULT, &counts[k]);
  glDeleteQueries(3, queries);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR)) << "no ARB_pipeline_statistics_query";
  return {counts[0], counts[1], counts[2]};
}

}  // namespace scree::test
