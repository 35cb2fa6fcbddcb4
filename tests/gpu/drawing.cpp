// State, draws, dispatches and sampler checks of engine/gpu against a real context.
#include <array>
#include <numeric>
#include <vector>

#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "engine/gpu/state.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree::gpu {
namespace {

constexpr const char* kFullScreenVert =
    "void main() {\n"
    "  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);\n"
    "  gl_Position = vec4(p, DEPTH, 1.0);\n"
    "}\n";

class DrawTest : public test::GlTest {
 protected:
  // A full-screen program at clip depth 0.5.
  Program program(std::string name, std::string_view fragment, std::string depth = "0.5") {
    folder_.write("full.vert", kFullScreenVert);
    folder_.write(name + ".frag", fragment);
    return Program({.name = name,
                    .vertex = "full.vert",
                    .fragment = name + ".frag",
                    .defines = {"DEPTH " + depth},
                    .root = folder_.path()});
  }
  test::ShaderFolder folder_;
};

TEST_F(DrawTest, DepthIsReversed) {
  Program near =
      program("near", "layout(location=0) out vec4 o; void main() { o = vec4(1); }", "0.75");
  Program far =
      program("far", "layout(location=0) out vec4 o; void main() { o = vec4(0.5); }", "0.25");
  Texture color("color", {.format = GL_R32F, .size = {4, 4}});
  Texture depth("depth", {.format = GL_DEPTH_COMPONENT32F, .size = {4, 4}});
  Framebuffer target("target");
  target.attachColor(color);
  target.attachDepth(depth);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({4, 4});
  setScissor(std::nullopt);
  apply(DrawState{});
  target.clearColor(0, vec4(0));
  target.clearDepth();
  EXPECT_TRUE(near.use());
  drawFullScreen();
  EXPECT_TRUE(far.use());
  drawFullScreen();
  EXPECT_EQ(readFloats(color, 1), std::vector<float>(16, 1.0f));
  EXPECT_EQ(readFloats(depth, 1), std::vector<float>(16, 0.75f));
}

TEST_F(DrawTest, ClearsIgnoreMasksAndScissorAndRestoreThem) {
  Program grey = program("grey", "layout(location=0) out vec4 o; void main() { o = vec4(0.5); }");
  Texture color("color", {.format = GL_R32F, .size = {2, 2}});
  Texture depth("depth", {.format = GL_DEPTH_COMPONENT32F, .size = {2, 2}});
  Framebuffer target("target");
  target.attachColor(color);
  target.attachDepth(depth);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({2, 2});
  DrawState closed;
  closed.color_write = false;
  closed.depth_write = false;
  apply(closed);
  setScissor(Rect{{0, 0}, {1, 1}});
  target.clearColor(0, vec4(3));
  target.clearDepth(0.125f);
  EXPECT_EQ(readFloats(color, 1), std::vector<float>(4, 3.0f));
  EXPECT_EQ(readFloats(depth, 1), std::vector<float>(4, 0.125f));
  EXPECT_EQ(currentState(), closed);
  grey.use();
  drawFullScreen();
  EXPECT_EQ(readFloats(color, 1), std::vector<float>(4, 3.0f));
  closed.color_write = true;
  apply(closed);
  drawFullScreen();
  EXPECT_EQ(readFloats(color, 1), (std::vector<float>{0.5f, 3, 3, 3}));
  EXPECT_EQ(readFloats(depth, 1), std::vector<float>(4, 0.125f));
}

TEST_F(DrawTest, AWidenedViewportHasTheSameMiddle) {
  const auto seen = [] {
    vec4 rect(0);
    glGetFloatv(GL_VIEWPORT, &rect.x);
    return rect;
  };
  setViewport({7, 4});
  EXPECT_EQ(widenViewport(), 0.5f);
  EXPECT_EQ(seen(), vec4(-3.5f, -2, 14, 8));
  EXPECT_EQ(viewport(), (Rect{{0, 0}, {7, 4}}));
  setViewport(viewport());
  EXPECT_EQ(seen(), vec4(0, 0, 7, 4));
  // As large as GL can: it stays.
  setViewport({limits().viewport_size[0], 4});
  EXPECT_EQ(widenViewport(), 1.0f);
  EXPECT_EQ(seen(), vec4(0, 0, limits().viewport_size[0], 4));
}

TEST_F(DrawTest, StateThatIsSetAlreadyIsSkipped) {
  DrawState blended;
  blended.blend = Blend::Premultiplied;
  blended.cull = Cull::None;
  apply(DrawState{});
  setViewport({8, 8});
  setScissor(std::nullopt);
  const Counters before = counters();
  apply(DrawState{});
  setViewport({8, 8});
  setScissor(std::nullopt);
  EXPECT_EQ((counters() - before).state_changes, 0u);
  apply(blended);
  EXPECT_EQ((counters() - before).state_changes, 2u);
  GLint blend = 0;
  glGetIntegerv(GL_BLEND_SRC_RGB, &blend);
  EXPECT_TRUE(glIsEnabled(GL_BLEND));
  EXPECT_FALSE(glIsEnabled(GL_CULL_FACE));
  EXPECT_EQ(blend, GL_ONE);
  setScissor(Rect{{1, 2}, {3, 4}});
  EXPECT_EQ((counters() - before).state_changes, 3u);
  EXPECT_TRUE(glIsEnabled(GL_SCISSOR_TEST));

  // After foreign code, everything is set anew.
  glEnable(GL_CULL_FACE);
  glDepthFunc(GL_LESS);
  forgetState();
  apply(blended);
  EXPECT_FALSE(glIsEnabled(GL_CULL_FACE));
  GLint func = 0;
  glGetIntegerv(GL_DEPTH_FUNC, &func);
  EXPECT_EQ(func, GL_GREATER);
}

TEST_F(DrawTest, EveryStateFieldReachesGl) {
  DrawState s;
  apply(s);
  s = DrawState{.depth_test = false,
                .depth_write = false,
                .depth_clamp = true,
                .bias_slope = -2,
                .bias_units = -3,
                .cull = Cull::Front,
                .blend = Blend::Add,
                .color_write = false,
                .wireframe = true,
                .program_point_size = true};
  apply(s);
  EXPECT_FALSE(glIsEnabled(GL_DEPTH_TEST));
  EXPECT_TRUE(glIsEnabled(GL_DEPTH_CLAMP));
  EXPECT_TRUE(glIsEnabled(GL_POLYGON_OFFSET_FILL));
  EXPECT_TRUE(glIsEnabled(GL_PROGRAM_POINT_SIZE));
  GLfloat slope = 0;
  glGetFloatv(GL_POLYGON_OFFSET_FACTOR, &slope);
  EXPECT_EQ(slope, -2);
  std::array<GLboolean, 4> mask{};
  glGetBooleanv(GL_COLOR_WRITEMASK, mask.data());
  EXPECT_FALSE(mask[0] || mask[3]);
  GLint face = 0, polygon[2] = {};
  glGetIntegerv(GL_CULL_FACE_MODE, &face);
  EXPECT_EQ(face, GL_FRONT);
  glGetIntegerv(GL_POLYGON_MODE, polygon);
  EXPECT_EQ(polygon[0], GL_LINE);

  // No test but writes: GL must have the test on, always passing.
  s.depth_write = true;
  apply(s);
  GLint func = 0;
  glGetIntegerv(GL_DEPTH_FUNC, &func);
  EXPECT_TRUE(glIsEnabled(GL_DEPTH_TEST));
  EXPECT_EQ(func, GL_ALWAYS);
  for (auto [compare, gl] : {std::pair{Compare::Never, GL_NEVER},
                             {Compare::Less, GL_LESS},
                             {Compare::Equal, GL_EQUAL},
                             {Compare::LessEqual, GL_LEQUAL},
                             {Compare::Greater, GL_GREATER},
                             {Compare::NotEqual, GL_NOTEQUAL},
                             {Compare::GreaterEqual, GL_GEQUAL},
                             {Compare::Always, GL_ALWAYS}}) {
    s.depth_test = true;
    s.depth_func = compare;
    apply(s);
    glGetIntegerv(GL_DEPTH_FUNC, &func);
    EXPECT_EQ(func, gl);
  }
}

TEST_F(DrawTest, BlendModesComputeWhatTheySay) {
  Program half = program(
      "half", "layout(location=0) out vec4 o; void main() { o = vec4(0.5, 0.5, 0.5, 0.25); }");
  Texture color("color", {.format = GL_RGBA32F, .size = {1, 1}});
  Framebuffer target("target");
  target.attachColor(color);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({1, 1});
  setScissor(std::nullopt);
  half.use();
  const std::pair<Blend, std::array<float, 2>> expected[] = {
      {Blend::None, {0.5f, 0.25f}},
      {Blend::Alpha, {0.5f * 0.25f + 0.75f, 0.25f + 0.75f * 0.5f}},
      {Blend::Premultiplied, {0.5f + 0.75f, 0.25f + 0.75f * 0.5f}},
      {Blend::Add, {1.5f, 0.75f}},
      {Blend::Min, {0.5f, 0.25f}},
      {Blend::Max, {1.0f, 0.5f}}};
  for (const auto& [blend, result] : expected) {
    target.clearColor(0, vec4(1, 1, 1, 0.5f));
    DrawState s;
    s.blend = blend;
    apply(s);
    drawFullScreen();
    const std::vector<float> texel = readFloats(color, 4);
    EXPECT_FLOAT_EQ(texel[0], result[0]) << static_cast<int>(blend);
    EXPECT_FLOAT_EQ(texel[3], result[1]) << static_cast<int>(blend);
  }
}

TEST_F(DrawTest, SrgbTargetsEncode) {
  Program grey =
      program("grey", "layout(location=0) out vec4 o; void main() { o = vec4(0.2140411); }");
  Texture color("color", {.format = GL_SRGB8_ALPHA8, .size = {1, 1}});
  Framebuffer target("target");
  target.attachColor(color);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({1, 1});
  setScissor(std::nullopt);
  apply(DrawState{});
  grey.use();
  drawFullScreen();
  EXPECT_NEAR(readBytes(color, 1)[0], 128, 1);
}

TEST_F(DrawTest, AttributesAndIndices) {
  folder_.write("points.vert",
                "layout(location=0) in float x; layout(location=1) in uint id; flat out uint v;\n"
                "void main() { gl_Position = vec4(x, 0, 0.5, 1); v = id; }");
  folder_.write("points.frag",
                "flat in uint v; layout(location=0) out uint o; void main() { o = v; }");
  Program points({.name = "points",
                  .vertex = "points.vert",
                  .fragment = "points.frag",
                  .root = folder_.path()});
  const std::vector<float> x = {-0.75f, -0.25f, 0.25f, 0.75f};
  const std::vector<uint32_t> ids = {10, 20, 30};
  const std::vector<uint32_t> indices = {3, 0, 2};
  Buffer xs("xs", std::span<const float>(x)), instance_ids("ids", std::span<const uint32_t>(ids)),
      index_buffer("indices", std::span<const uint32_t>(indices));
  VertexArray vertices("vertices");
  vertices.attribute(0, 1, GL_FLOAT, 0, 0);
  vertices.attributeInteger(1, 1, GL_UNSIGNED_INT, 0, 1);
  vertices.vertexBuffer(0, xs, 4);
  vertices.vertexBuffer(1, instance_ids, 4, 0, 1);
  vertices.indexBuffer(index_buffer);
  Texture out("out", {.format = GL_R32UI, .size = {4, 1}});
  Framebuffer target("target");
  target.attachColor(out);
  ASSERT_TRUE(target.finish().ok());
  target.clearColor(0, uvec4(1));
  target.bind();
  setViewport({4, 1});
  setScissor(std::nullopt);
  apply(DrawState{.depth_test = false});
  points.use();
  vertices.bind();
  const Counters before = counters();
  drawElementsInstanced(GL_POINTS, 2, GL_UNSIGNED_INT, 4, 1, 0, 2);  // vertices 0, 2 of instance 2
  drawArrays(GL_POINTS, 1, 1);                                       // vertex 1 of instance 0
  drawArrays(GL_POINTS, 1, 0);
  drawElementsInstanced(GL_POINTS, 2, GL_UNSIGNED_INT, 0, 0);
  EXPECT_EQ(readUints(out, 1), (std::vector<uint32_t>{30, 10, 30, 1}));
  EXPECT_EQ((counters() - before).draws, 2u);

  const std::vector<uint32_t> commands = {1, 1, 3, 0, 1, /*stride*/ 0, 0, 0, 1, 1, 0,
                                          0, 2, 0, 0, 0};
  Buffer indirect("indirect", std::span<const uint32_t>(commands));
  drawArraysIndirect(GL_POINTS, indirect, 0);  // 1 vertex, 1 instance, first 3, base instance 0
  EXPECT_EQ(readUints(out, 1), (std::vector<uint32_t>{30, 10, 30, 10}));
}

TEST_F(DrawTest, DispatchesCountAndBoundSizes) {
  folder_.write(
      "add.comp",
      "layout(local_size_x = 64) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
      "layout(location = 3) uniform uint count;\n"
      "void main() { if (gl_GlobalInvocationID.x < count) b[gl_GlobalInvocationID.x] += 5u; }");
  Program add({.name = "add", .compute = "add.comp", .root = folder_.path()});
  Buffer buffer("b", 4 * 1000);
  buffer.fill(1);
  const Counters before = counters();
  add.use();
  add.set(3, 900u);
  buffer.bindStorage(0);
  dispatchItems(900, 64);
  dispatchItems(0, 64);
  const std::vector<uint32_t> result = readBuffer<uint32_t>(buffer, 1000);
  EXPECT_EQ(std::accumulate(result.begin(), result.end(), 0u), 900u * 6 + 100);
  EXPECT_EQ((counters() - before).dispatches, 1u);
  const std::vector<uint32_t> groups = {1, 1, 1};
  Buffer indirect("groups", std::span<const uint32_t>(groups));
  barrier(GL_SHADER_STORAGE_BARRIER_BIT);
  dispatchIndirect(indirect);
  EXPECT_EQ(readBuffer<uint32_t>(buffer, 66)[63], 11u);
  EXPECT_EQ(readBuffer<uint32_t>(buffer, 66)[64], 6u);
  EXPECT_EQ((counters() - before).barriers, 1u);
}

TEST_F(DrawTest, UnboundAndMixedSamplersAreFaultsNotCrashes) {
  Program reader =
      program("reader",
              "layout(binding=3) uniform sampler2D a; layout(binding=4) uniform usampler2D b;\n"
              "layout(location=0) out vec4 o;\n"
              "void main() { o = texelFetch(a, ivec2(0), 0) + vec4(texelFetch(b, ivec2(0), 0).xyz, "
              "0.0); }");
  Texture color("color", {.format = GL_RGBA32F, .size = {1, 1}});
  Framebuffer target("target");
  target.attachColor(color);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({1, 1});
  setScissor(std::nullopt);
  apply(DrawState{});
  reader.use();
  drawFullScreen();
  EXPECT_EQ(messages(), 2u);  // both unbound
  EXPECT_EQ(readFloats(color, 4), std::vector<float>(4, 0.0f));
  drawFullScreen();
  EXPECT_EQ(messages(), 2u);

  whiteTexture().bind(4);  // float, where unsigned integers are read
  drawFullScreen();
  EXPECT_EQ(messages(), 3u);
  EXPECT_NE(lastDebugMessage().find("'reader': sampler 'b' of unit 4"), std::string::npos)
      << lastDebugMessage();

  whiteTexture().bind(3);
  zeroTexture(GL_R32UI).bind(4);
  drawFullScreen();
  EXPECT_EQ(messages(), 3u);
  EXPECT_EQ(readFloats(color, 4), std::vector<float>(4, 1.0f));
  {
    Texture passing("passing", {.format = GL_R32F, .size = {1, 1}});
    passing.bind(3);
  }  // deleted while bound: the unit is empty again
  drawFullScreen();
  EXPECT_EQ(messages(), 4u);
  expectMessages(4);
}

TEST_F(DrawTest, RepeatedBindsAreSkipped) {
  Texture texture("t", {.format = GL_R32F, .size = {1, 1}});
  Program grey = program("grey", "layout(location=0) out vec4 o; void main() { o = vec4(0.5); }");
  grey.use();
  texture.bind(5);
  const Counters before = counters();
  grey.use();
  texture.bind(5);
  EXPECT_EQ((counters() - before).binds, 0u);
  texture.bind(6);
  EXPECT_EQ((counters() - before).binds, 1u);
}

TEST_F(DrawTest, ShadowSamplingComparesReversed) {
  Program reader =
      program("shadow",
              "layout(binding=0) uniform sampler2DShadow s; layout(location=0) out vec4 o;\n"
              "void main() { o = vec4(texture(s, vec3(0.5, 0.5, 0.6)), texture(s, vec3(0.5, 0.5, "
              "0.4)), 0, 1); }");
  Texture depth("depth",
                {.format = GL_DEPTH_COMPONENT32F, .size = {1, 1}, .sampling = {.shadow = true}});
  depth.clear(vec4(0.5f));
  Texture color("color", {.format = GL_RG32F, .size = {1, 1}});
  Framebuffer target("target");
  target.attachColor(color);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({1, 1});
  setScissor(std::nullopt);
  apply(DrawState{});
  reader.use();
  depth.bind(0);
  drawFullScreen();
  // Nearer (greater) than what the map holds: lit.
  EXPECT_EQ(readFloats(color, 2), (std::vector<float>{1, 0}));
}

TEST_F(DrawTest, SamplersOverrideUntilUnbound) {
  Program reader = program("reader",
                           "layout(binding=2) uniform sampler2D s; layout(location=0) out vec4 o;\n"
                           "void main() { o = texture(s, vec2(0.5)); }");
  Texture texture("t", {.format = GL_R32F, .size = {2, 1}});
  texture.upload(std::vector<float>{0, 1}, 1);
  Sampler linear("linear", {.filter = Filter::Linear});
  Texture color("color", {.format = GL_R32F, .size = {1, 1}});
  Framebuffer target("target");
  target.attachColor(color);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setViewport({1, 1});
  setScissor(std::nullopt);
  apply(DrawState{});
  reader.use();
  texture.bind(2);
  linear.bind(2);
  drawFullScreen();
  EXPECT_EQ(readFloats(color, 1)[0], 0.5f);
  unbindSamplers();
  drawFullScreen();
  EXPECT_NE(readFloats(color, 1)[0], 0.5f);
  linear.bind(2);
  unbindSampler(2);
  drawFullScreen();
  EXPECT_NE(readFloats(color, 1)[0], 0.5f);
}

TEST_F(DrawTest, TooManyWorkGroupsEndTheProgram) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Program none = program("none", "layout(location=0) out vec4 o; void main() { o = vec4(1); }");
  ASSERT_TRUE(none.use());
  EXPECT_DEATH(dispatch(1, 1u << 31), "work groups");
}

}  // namespace
}  // namespace scree::gpu
