// Frames on a real context: what is created, cleared, bound, timed and resized.
#include <string>
#include <vector>

#include "engine/frame/frame.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "engine/gpu/state.h"
#include "tests/support/gl_allocations.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree {
namespace {

const std::string kOut(Frame::kOutput);

class FrameTest : public test::GlTest {
 protected:
  FrameTest() {
    folder_.write("full.vert",
                  "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,"
                  " gl_VertexID == 2 ? 3.0 : -1.0, 0.5, 1.0); }");
    folder_.write("one.frag", "layout(location = 0) out vec4 o; void main() { o = vec4(VALUE); }");
    folder_.write("copy.frag",
                  "layout(binding = 0) uniform sampler2D s; layout(location = 0) out vec4 o;\n"
                  "void main() { o = texelFetch(s, ivec2(gl_FragCoord.xy), 0); }");
  }
  gpu::Program one(const std::string& value = "1.0") {
    return gpu::Program({.name = "one",
                         .vertex = "full.vert",
                         .fragment = "one.frag",
                         .defines = {"VALUE " + value},
                         .root = folder_.path()});
  }
  gpu::Program copy() {
    return gpu::Program(
        {.name = "copy", .vertex = "full.vert", .fragment = "copy.frag", .root = folder_.path()});
  }
  void run(Frame& frame, ivec2 size = {8, 4}) {
    FrameInput input;
    input.size = size;
    input.frame = frames_++;
    frame.run(input);
  }
  static const PassReport& report(const Frame& frame, std::string_view name) {
    for (const PassReport& r : frame.report())
      if (r.name == name) return r;
    ADD_FAILURE() << "no pass " << name;
    return frame.report().front();
  }
  uint64_t frames_ = 0;
  test::ShaderFolder folder_;
};

TEST_F(FrameTest, AnUnusedPassCostsNothing) {
  Frame frame;
  bool used = false;
  gpu::Program program = one();
  frame.addTarget("big", {.format = GL_RGBA32F, .fixed_size = {256, 256}});
  frame.addPass({.name = "off",
                 .stage = Stage::Geometry,
                 .needs = [&] { return used; },
                 .uses = {{"big", Access::Color}},
                 .run =
                     [&](PassContext&) {
                       program.use();
                       gpu::drawFullScreen();
                     }});
  frame.addPass({.name = "unread",
                 .stage = Stage::Geometry,
                 .uses = {{"big", Access::Color}},
                 .run = [&](PassContext&) { FAIL(); }});
  frame.addPass({.name = "reader",
                 .stage = Stage::Present,
                 .needs = [&] { return used; },
                 .uses = {{"big", Access::Sampled}, {kOut, Access::Color}},
                 .run = [&](PassContext&) {}});
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 3; ++i) run(frame);
  gpu::Counters spent = gpu::counters() - before;
  EXPECT_EQ(spent.textures + spent.buffers + spent.framebuffers + spent.programs + spent.queries,
            0u);
  EXPECT_EQ(spent.draws + spent.dispatches + spent.binds + spent.state_changes + spent.barriers,
            0u);
  EXPECT_FALSE(frame.hasTexture("big"));
  EXPECT_FALSE(frame.hasTexture(kOut));
  EXPECT_EQ(frame.runCount("off"), 0u);
}

TEST_F(FrameTest, ColorTargetsThatNobodyReadsAreNotAttached) {
  Frame frame;
  folder_.write("two.frag", R"(
    layout(location = 0) out float a;
    layout(location = 1) out float b;
    void main() { a = 1.0; b = 2.0; })");
  gpu::Program two(
      {.name = "two", .vertex = "full.vert", .fragment = "two.frag", .root = folder_.path()});
  for (const char* name : {"a", "b"})
    frame.addTarget(name, {.format = GL_R32F, .clear_value = vec4(7)});
  frame.addPass({.name = "clear",
                 .stage = Stage::Geometry,
                 .uses = {{"a", Access::Clear}, {"b", Access::Clear}}});
  std::vector<bool> fresh;
  bool draws = true;
  frame.addPass({.name = "draw",
                 .stage = Stage::Shade,
                 .uses = {{"a", Access::Color}, {"b", Access::Color}},
                 .run = [&](PassContext& c) {
                   EXPECT_EQ(c.framebuffer->colorCount(), 2);
                   fresh.push_back(c.first_run_after_off);
                   two.use();
                   if (draws) gpu::drawFullScreen();
                 }});
  const auto floats = [&](const char* name) { return gpu::readFloats(frame.texture(name), 1).front(); };
  frame.keep("b", true);
  run(frame);
  EXPECT_FALSE(frame.hasTexture("a"));
  EXPECT_EQ(floats("b"), 2);  // still the second output

  // Read by somebody: it is there from that frame on, and the pass's history counts as lost.
  frame.keep("a", true);
  run(frame);
  EXPECT_EQ(floats("a"), 1);
  EXPECT_EQ(floats("b"), 2);

  // Neither drawn to nor cleared again once nobody reads it.
  frame.keep("b", false);
  draws = false;
  run(frame);
  EXPECT_EQ(floats("a"), 7);
  EXPECT_EQ(floats("b"), 2);
  const gpu::Counters before = gpu::counters();
  run(frame);
  EXPECT_EQ((gpu::counters() - before).framebuffers, 0u);
  EXPECT_EQ(fresh, (std::vector<bool>{true, true, false, false}));
}

TEST_F(FrameTest, PassesDrawIntoTheirTargets) {
  Frame frame;
  gpu::Program grey = one("0.5"), copies = copy();
  frame.addTarget("radiance", {.format = GL_RGBA16F});
  frame.addPass({.name = "draw",
                 .stage = Stage::Shade,
                 .uses = {{"radiance", Access::Color}},
                 .run = [&](PassContext& c) {
                   EXPECT_EQ(c.framebuffer->colorCount(), 1);
                   EXPECT_EQ(gpu::viewport(), (gpu::Rect{{0, 0}, {8, 4}}));
                   EXPECT_FALSE(gpu::currentState().depth_test);
                   EXPECT_FALSE(gpu::currentState().depth_write);
                   EXPECT_EQ(c.input.size, ivec2(8, 4));
                   grey.use();
                   gpu::drawFullScreen();
                 }});
  frame.addPass({.name = "present",
                 .stage = Stage::Present,
                 .uses = {{"radiance", Access::Sampled}, {kOut, Access::Color}},
                 .run = [&](PassContext& c) {
                   c.frame.texture("radiance").bind(0);
                   copies.use();
                   gpu::drawFullScreen();
                 }});
  run(frame);
  EXPECT_EQ(gpu::readBytes(frame.texture(kOut), 1), std::vector<uint8_t>(32, 128));
  EXPECT_EQ(report(frame, "draw").counters.draws, 1u);
  EXPECT_EQ(report(frame, "draw").counters.textures, 1u);
  EXPECT_EQ(report(frame, "draw").counters.programs, 1u);
  EXPECT_EQ(frame.runCount("draw"), 1u);
  EXPECT_NE(frame.describe().find("radiance      RGBA16F 8x4, 1 KiB\n"), std::string::npos)
      << frame.describe();
}

TEST_F(FrameTest, SteadyStateAllocatesAndCreatesNothing) {
  Frame frame;
  gpu::Program grey = one("0.5"), copies = copy();
  frame.addTarget("radiance", {.format = GL_RGBA16F});
  frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F});
  frame.addPass({.name = "clear",
                 .stage = Stage::Geometry,
                 .uses = {{"radiance", Access::Clear}, {"depth", Access::Clear}}});
  frame.addPass({.name = "draw",
                 .stage = Stage::Shade,
                 .uses = {{"radiance", Access::Color}, {"depth", Access::Depth}},
                 .run = [&](PassContext&) {
                   grey.use();
                   gpu::drawFullScreen();
                 }});
  frame.addPass({.name = "off",
                 .stage = Stage::Shade,
                 .needs = [] { return false; },
                 .uses = {{"radiance", Access::Color}},
                 .run = [](PassContext&) {}});
  frame.addPass({.name = "present",
                 .stage = Stage::Present,
                 .uses = {{"radiance", Access::Sampled}, {kOut, Access::Color}},
                 .run = [&](PassContext& c) {
                   c.frame.texture("radiance").bind(0);
                   copies.use();
                   gpu::drawFullScreen();
                 }});
  for (int i = 0; i < 5; ++i) run(frame);
  const gpu::Counters before = gpu::counters();
  {
    const test::AllocationCount allocations;
    for (int i = 0; i < 50; ++i) run(frame);
    EXPECT_EQ(allocations.count(), 0);
  }
  const gpu::Counters spent = gpu::counters() - before;
  EXPECT_EQ(spent.textures + spent.buffers + spent.framebuffers + spent.programs + spent.queries,
            0u);
  EXPECT_EQ(spent.barriers, 0u);
  EXPECT_EQ(spent.draws, 100u);
  EXPECT_EQ(frame.runCount("present"), 55u);
}

TEST_F(FrameTest, ClearPassesNeedNoCode) {
  Frame frame;
  frame.addTarget("float", {.format = GL_RGBA16F, .clear_value = vec4(1, 2, 3, 4)});
  frame.addTarget("uint", {.format = GL_R32UI, .clear_value = vec4(77)});
  frame.addTarget("int", {.format = GL_R32I, .clear_value = vec4(-5)});
  frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F, .clear_value = vec4(0.25f)});
  frame.addPass({.name = "clear",
                 .stage = Stage::Geometry,
                 .uses = {{"float", Access::Clear},
                          {"int", Access::Clear},
                          {"depth", Access::Clear},
                          {"uint", Access::Clear}}});
  for (const char* name : {"float", "uint", "int", "depth"}) frame.keep(name, true);
  run(frame, {1, 1});
  EXPECT_EQ(gpu::readFloats(frame.texture("float"), 4), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(gpu::readUints(frame.texture("uint"), 1), std::vector<uint32_t>{77});
  EXPECT_EQ(gpu::readUints(frame.texture("int"), 1),
            std::vector<uint32_t>{static_cast<uint32_t>(-5)});
  EXPECT_EQ(gpu::readFloats(frame.texture("depth"), 1), std::vector<float>{0.25f});
  EXPECT_FALSE(frame.hasContent("float"));
}

TEST_F(FrameTest, TargetsFollowTheOutputsSize) {
  Frame frame;
  gpu::Program white = one();
  frame.addTarget("screen", {.format = GL_R32F, .levels = 0});
  frame.addTarget("map", {.format = GL_R32F, .fixed_size = {16, 16}});
  ivec2 seen{0, 0};
  frame.addPass({.name = "screen",
                 .stage = Stage::Shade,
                 .uses = {{"screen", Access::Color}},
                 .run = [&](PassContext&) {
                   seen = gpu::viewport().size;
                   white.use();
                   gpu::drawFullScreen();
                 }});
  frame.addPass({.name = "map",
                 .stage = Stage::Shade,
                 .uses = {{"map", Access::Color}},
                 .run = [&](PassContext&) {
                   EXPECT_EQ(gpu::viewport().size, ivec2(16, 16));
                   white.use();
                   gpu::drawFullScreen();
                 }});
  frame.keep("screen", true);
  frame.keep("map", true);
  const uint64_t live = gpu::counters().live_texture_bytes;
  for (ivec2 size : {ivec2(8, 4), ivec2(13, 7), ivec2(1, 1), ivec2(640, 360), ivec2(8, 4)}) {
    run(frame, size);
    EXPECT_EQ(seen, size);
    EXPECT_EQ(frame.texture("screen").size(), size);
    EXPECT_EQ(gpu::readFloats(frame.texture("screen"), 1),
              std::vector<float>(static_cast<size_t>(size.x * size.y), 1.0f));
    EXPECT_EQ(frame.texture("map").size(), ivec2(16, 16));
  }
  EXPECT_EQ(gpu::counters().live_texture_bytes - live, (32u + 8 + 2 + 1 + 256) * 4);
  const gpu::Counters before = gpu::counters();
  run(frame, {8, 4});
  EXPECT_EQ((gpu::counters() - before).textures, 0u);
  // A minimised window: nothing runs, nothing changes.
  run(frame, {0, 0});
  EXPECT_EQ(frame.texture("screen").size(), ivec2(8, 4));
  EXPECT_EQ(frame.runCount("screen"), 6u);
}

// GL checks the bound framebuffer at dispatches too: one that had lost its attachments with the old size would be
// complained of (TearDown), and one that is not bound would keep them alive.
TEST_F(FrameTest, DispatchesBeforeTheFirstDrawOfAnotherSize) {
  Frame frame;
  gpu::Program white = one();
  folder_.write("none.comp", "layout(local_size_x = 1) in; void main() {}");
  gpu::Program none({.name = "none", .compute = "none.comp", .root = folder_.path()});
  frame.addExternal("list");
  frame.addTarget("screen", {.format = GL_R32F});
  frame.addPass({.name = "list",
                 .stage = Stage::Route,
                 .uses = {{"list", Access::StorageWrite}},
                 .run = [&](PassContext&) {
                   none.use();
                   gpu::dispatch(1);
                 }});
  frame.addPass({.name = "screen",
                 .stage = Stage::Shade,
                 .uses = {{"list", Access::StorageRead}, {"screen", Access::Color}},
                 .run = [&](PassContext&) {
                   white.use();
                   gpu::drawFullScreen();
                 }});
  frame.keep("screen", true);
  for (const ivec2 size : {ivec2(8, 4), ivec2(5, 3), ivec2(16, 16)}) {
    run(frame, size);
    EXPECT_EQ(gpu::readFloats(frame.texture("screen"), 1),
              std::vector<float>(static_cast<size_t>(size.x * size.y), 1.0f));
  }
}

TEST_F(FrameTest, ASharedShadowMapTakesSeveralPasses) {
  Frame frame;
  gpu::Program none({.name = "depth", .vertex = "full.vert", .root = folder_.path()});
  frame.addTarget("map", {.format = GL_DEPTH_COMPONENT32F, .fixed_size = {4, 2}});
  frame.addPass({.name = "clear", .stage = Stage::Geometry, .uses = {{"map", Access::Clear}}});
  for (int half = 0; half < 2; ++half)
    frame.addPass({.name = "casters" + std::to_string(half),
                   .stage = Stage::Geometry,
                   .uses = {{"map", Access::Depth}},
                   .run = [&, half](PassContext&) {
                     EXPECT_TRUE(gpu::currentState().depth_test);
                     EXPECT_TRUE(gpu::currentState().depth_write);
                     gpu::setViewport({{2 * half, 0}, {2, 2 - half}});
                     none.use();
                     gpu::drawFullScreen();
                   }});
  frame.keep("map", true);
  for (int i = 0; i < 2; ++i) {
    run(frame, {64, 64});
    EXPECT_EQ(gpu::readFloats(frame.texture("map"), 1),
              (std::vector<float>{0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0, 0}));
  }
}

TEST_F(FrameTest, DepthTestedPassesDoNotWriteDepth) {
  Frame frame;
  gpu::Program white = one();
  frame.addTarget("color", {.format = GL_R32F});
  frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F, .clear_value = vec4(0.25f)});
  frame.addPass({.name = "clear", .stage = Stage::Geometry, .uses = {{"depth", Access::Clear}}});
  frame.addPass({.name = "test",
                 .stage = Stage::Shade,
                 .uses = {{"color", Access::Color}, {"depth", Access::DepthTest}},
                 .run = [&](PassContext&) {
                   white.use();
                   gpu::drawFullScreen();
                 }});
  frame.keep("color", true);
  run(frame, {1, 1});
  EXPECT_EQ(gpu::readFloats(frame.texture("color"), 1), std::vector<float>{1.0f});
  EXPECT_EQ(gpu::readFloats(frame.texture("depth"), 1), std::vector<float>{0.25f});
}

TEST_F(FrameTest, PassesKnowWhenTheirHistoryIsLost) {
  Frame frame;
  bool wanted = true;
  std::vector<bool> fresh;
  frame.addTarget("history", {.format = GL_R32F});
  frame.addPass({.name = "accumulate",
                 .stage = Stage::Lens,
                 .needs = [&] { return wanted; },
                 .uses = {{"history", Access::Color}},
                 .run = [&](PassContext& c) { fresh.push_back(c.first_run_after_off); }});
  frame.keep("history", true);
  run(frame);
  run(frame);
  run(frame);
  EXPECT_EQ(fresh, (std::vector<bool>{true, false, false}));
  wanted = false;
  run(frame);
  wanted = true;
  run(frame);
  run(frame);
  EXPECT_EQ(fresh, (std::vector<bool>{true, false, false, true, false}));
  run(frame, {9, 9});  // a new texture
  run(frame, {9, 9});
  EXPECT_EQ(fresh, (std::vector<bool>{true, false, false, true, false, true, false}));
}

TEST_F(FrameTest, AReadTargetThatNobodyWritesIsMadeOnlyOnDemand) {
  Frame frame;
  gpu::Program copies = copy();
  bool ask = false;
  frame.addTarget("shadow", {.format = GL_R32F, .fixed_size = {512, 512}});
  frame.addPass({.name = "present",
                 .stage = Stage::Present,
                 .uses = {{"shadow", Access::Sampled}, {kOut, Access::Color}},
                 .run = [&](PassContext& c) {
                   EXPECT_FALSE(c.frame.hasContent("shadow"));
                   if (ask)
                     c.frame.texture("shadow").bind(0);
                   else
                     c.frame.bindSampled("shadow", 0);
                   copies.use();
                   gpu::drawFullScreen();
                 }});
  run(frame);
  EXPECT_FALSE(frame.hasTexture("shadow"));
  EXPECT_EQ(gpu::readBytes(frame.texture(kOut), 1), std::vector<uint8_t>(32, 0));
  ask = true;
  run(frame);
  EXPECT_TRUE(frame.hasTexture("shadow"));
}

TEST_F(FrameTest, NoSamplerLeaksIntoTheNextPass) {
  Frame frame;
  gpu::Sampler sampler("linear", {.filter = gpu::Filter::Linear});
  frame.addTarget("a", {.format = GL_RGBA8});
  GLint left_over = -1;
  frame.addPass({.name = "binds", .uses = {{"a", Access::Color}}, .run = [&](PassContext&) {
                   sampler.bind(3);
                 }});
  frame.addPass({.name = "after", .uses = {{"a", Access::Color}}, .run = [&](PassContext&) {
                   glActiveTexture(GL_TEXTURE3);
                   glGetIntegerv(GL_SAMPLER_BINDING, &left_over);
                 }});
  frame.keep("a", true);
  run(frame);
  EXPECT_EQ(left_over, 0);
}

TEST_F(FrameTest, TimesArriveByPass) {
  Frame frame;
  gpu::Program white = one();
  frame.addTarget("a", {.format = GL_RGBA16F});
  int draws = 1;
  for (const char* name : {"light", "heavy"})
    frame.addPass({.name = name,
                   .stage = Stage::Shade,
                   .uses = {{"a", Access::Color}},
                   .run = [&, heavy = std::string_view(name) == "heavy"](PassContext&) {
                     white.use();
                     for (int i = 0; i < (heavy ? 60 : draws); ++i) gpu::drawFullScreen();
                   }});
  frame.keep("a", true);
  EXPECT_LT(frame.report()[0].gpu_ms, 0);
  frame.separatePasses(true);
  for (int i = 0; i < 8; ++i) {
    run(frame, {256, 256});
    frame.finishTimers();
  }
  const PassReport &light = report(frame, "light"), &heavy = report(frame, "heavy");
  EXPECT_GT(light.gpu_ms, 0);
  EXPECT_GT(heavy.gpu_ms, 0);
  EXPECT_GT(light.cpu_ms, 0);
  EXPECT_GT(heavy.start_ns, light.start_ns);
  EXPECT_GT(heavy.gpu_start_ns, light.gpu_start_ns);
  std::printf("light %.3f ms, heavy %.3f ms\n", light.gpu_ms, heavy.gpu_ms);
}

}  // namespace
}  // namespace scree
