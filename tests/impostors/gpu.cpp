// The shared rules as GLSL give what they give as C++.
#include <filesystem>
#include <vector>

#include "engine/core/random.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "shaders/shared/impostor.h"
#include "shaders/shared/spread.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree {
namespace {

class ImpostorGpu : public test::GlTest {};

constexpr size_t kFloats = 32;  // a case writes this many numbers

// What the program below writes, by the C++ copy.
std::vector<float> expected(vec3 d, int n) {
  using namespace rules;
  std::vector<float> out;
  const auto put3 = [&](vec3 v) {
    for (int c = 0; c < 3; ++c) out.push_back(v[c]);
  };
  const ImpostorViews v = impostorViews(d, n);
  for (uint32_t layer : {v.layer0, v.layer1, v.layer2}) out.push_back(static_cast<float>(layer));
  put3(v.weight);
  put3(v.axis0);
  put3(v.axis1);
  put3(impostorViewDirection(v.layer2, n));
  const ImpostorBasis basis = impostorBasis(v.axis0);
  put3(basis.right);
  put3(basis.up);
  const ImpostorProxy proxy{vec4(0.05f, -0.1f, 0.02f, 0), vec4(1.2f, 1.9f, 1.5f, 0),
                            vec4(0.3f, -0.2f, 0.15f, 0)};
  const ImpostorRay ray = impostorRay(d * 5.0f + basis.right * 0.3f, d * -1.0f);
  const vec3 on_proxy = impostorOnProxy(ray, proxy);
  put3(on_proxy);
  const vec2 uv =
      impostorUv(impostorStep(ray, on_proxy, v.axis0, 0.3f), v.axis0, impostorExtent(64));
  out.push_back(uv.x);
  out.push_back(uv.y);
  const vec2 mixed = impostorUv(impostorMixed(ray, v.axis0, 0.8f), v.axis0, impostorExtent(64));
  out.push_back(mixed.x);
  out.push_back(mixed.y);
  out.push_back(spreadAlpha2(0.01f, abs(d.x)));
  out.push_back(
      static_cast<float>(impostorLevel(128, 3.0f + 60.0f * abs(d.y), kImpostorShapeBias)));
  out.resize(kFloats, 0);
  return out;
}

constexpr const char* kProgram = "#include \"shared/spread.h\"\n" R"(#include "shared/impostor.h"
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { vec4 cases[]; };
layout(std430, binding = 1) buffer Out { float values[]; };
uint at;
void put(float x) { values[at++] = x; }
void put3(vec3 v) { put(v.x); put(v.y); put(v.z); }
void main() {
  uint k = gl_GlobalInvocationID.x;
  if (k >= uint(cases.length())) return;
  at = k * 32u;
  vec3 d = cases[k].xyz;
  int n = int(cases[k].w);
  ImpostorViews v = impostorViews(d, n);
  put(float(v.layer0)); put(float(v.layer1)); put(float(v.layer2));
  put3(v.weight);
  put3(v.axis0);
  put3(v.axis1);
  put3(impostorViewDirection(v.layer2, n));
  ImpostorBasis basis = impostorBasis(v.axis0);
  put3(basis.right);
  put3(basis.up);
  ImpostorProxy proxy;
  proxy.center = vec4(0.05, -0.1, 0.02, 0.0);
  proxy.diagonal = vec4(1.2, 1.9, 1.5, 0.0);
  proxy.upper = vec4(0.3, -0.2, 0.15, 0.0);
  ImpostorRay ray = impostorRay(d * 5.0 + basis.right * 0.3, -d);
  vec3 on_proxy = impostorOnProxy(ray, proxy);
  put3(on_proxy);
  vec2 uv = impostorUv(impostorStep(ray, on_proxy, v.axis0, 0.3), v.axis0, impostorExtent(64));
  put(uv.x); put(uv.y);
  vec2 mixed = impostorUv(impostorMixed(ray, v.axis0, 0.8), v.axis0, impostorExtent(64));
  put(mixed.x); put(mixed.y);
  put(spreadAlpha2(0.01, abs(d.x)));
  put(float(impostorLevel(128, 3.0 + 60.0 * abs(d.y), kImpostorShapeBias)));
}
)";

TEST_F(ImpostorGpu, RulesAreThoseOfTheCpu) {
  std::vector<vec4> cases;
  for (int n = rules::kImpostorMinEdge; n <= rules::kImpostorMaxEdge; ++n) {
    for (int axis = 0; axis < 3; ++axis)
      for (float sign : {1.0f, -1.0f}) {
        vec4 d(-0.0f, 0.0f, -0.0f, static_cast<float>(n));
        d[axis] = sign;
        cases.push_back(d);
      }
    for (uint64_t k = 0; k < 200; ++k) {
      vec3 d(0);
      for (uint64_t draw = 0; glm::dot(d, d) < 0.05f; draw += 3)
        d = vec3(randomUnit(3, k, static_cast<uint64_t>(n), draw),
                 randomUnit(3, k, static_cast<uint64_t>(n), draw + 1),
                 randomUnit(3, k, static_cast<uint64_t>(n), draw + 2)) *
                2.0f -
            1.0f;
      if (k % 5 == 0) d[static_cast<int>(k / 5 % 3)] = 0;  // on the circles where signs change
      cases.emplace_back(glm::normalize(d), n);
    }
  }
  test::ShaderFolder root;
  std::filesystem::copy(
      std::string(SCREE_SOURCE_DIR) + "/shaders", root.path(),
      std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
  root.write("probe.comp", kProgram);
  gpu::Program program(
      {.name = "test.impostor_rules", .compute = "probe.comp", .root = root.path()});
  const Status compiled = program.compile();
  ASSERT_TRUE(compiled.ok()) << compiled.error();
  ASSERT_TRUE(program.use());
  gpu::Buffer in("test.cases", std::span<const vec4>(cases));
  gpu::Buffer out("test.values", cases.size() * kFloats * sizeof(float));
  out.fill(0);
  in.bindStorage(0);
  out.bindStorage(1);
  gpu::dispatchItems(cases.size(), 64);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const auto read = gpu::readBuffer<float>(out, cases.size() * kFloats);
  size_t other_triangle = 0;
  for (size_t k = 0; k < cases.size(); ++k) {
    const int n = static_cast<int>(cases[k].w);
    const std::vector<float> want = expected(vec3(cases[k]), n);
    // On a border of the lattice, rounding may take the triangle on the other side: then the weight
    // of the view that differs is as good as zero.
    bool same = true;
    for (size_t c = 0; c < 3; ++c) same = same && read[k * kFloats + c] == want[c];
    if (!same) {
      float least = 1;
      for (size_t c = 3; c < 6; ++c) least = std::min(least, want[c]);
      ASSERT_LT(least, 1e-4f) << k;
      ++other_triangle;
      continue;
    }
    for (size_t c = 3; c < kFloats; ++c)
      ASSERT_NEAR(read[k * kFloats + c], want[c], c < 6 ? 4e-6f * static_cast<float>(n) : 3e-4f)
          << k << " number " << c;
  }
  EXPECT_LT(other_triangle, cases.size() / 100);
}

}  // namespace
}  // namespace scree
