// Barriers: derived from the uses of passes, no more than needed, and enough for right results.
#include <numeric>
#include <string>
#include <vector>

#include "engine/frame/frame.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree {
namespace {

const std::string kOut(Frame::kOutput);

class BarrierTest : public test::GlTest {
 protected:
  void run(Frame& frame) {
    FrameInput input;
    input.size = {8, 8};
    frame.run(input);
  }
  // Barriers of the last run of a pass.
  static uint64_t barriers(const Frame& frame, std::string_view pass) {
    for (const PassReport& report : frame.report())
      if (report.name == pass) return report.counters.barriers;
    ADD_FAILURE() << "no pass " << pass;
    return 0;
  }
  static void nothing(PassContext&) {}
  test::ShaderFolder folder_;
};

TEST_F(BarrierTest, OneBeforeEachKindOfReadAfterAWrite) {
  Frame frame;
  for (const char* name : {"list", "commands", "other"}) frame.addExternal(name);
  frame.addTarget("image", {.format = GL_R32UI});
  auto add = [&](std::string name, std::vector<Use> uses) {
    frame.addPass(
        {.name = std::move(name), .stage = Stage::Route, .uses = std::move(uses), .run = nothing});
  };
  add("write", {{"list", Access::StorageWrite}, {"commands", Access::StorageWrite}});
  add("other", {{"other", Access::StorageWrite}});
  add("read", {{"list", Access::StorageRead}, {"image", Access::StorageWrite}});
  add("read_again", {{"list", Access::StorageRead}, {"image", Access::StorageWrite}});
  add("draw", {{"commands", Access::Indirect},
               {"list", Access::Vertex},
               {"image", Access::Sampled},
               {kOut, Access::Color}});
  add("draw_again", {{"commands", Access::Indirect},
                     {"list", Access::Vertex},
                     {"image", Access::Sampled},
                     {kOut, Access::Color}});
  for (const char* name : {"other"}) frame.keep(name, true);
  run(frame);
  EXPECT_EQ(barriers(frame, "write"), 0u);
  EXPECT_EQ(barriers(frame, "other"), 0u);
  EXPECT_EQ(barriers(frame, "read"), 1u);
  EXPECT_EQ(barriers(frame, "read_again"), 1u);  // writes the image after it was written
  EXPECT_EQ(barriers(frame, "draw"), 1u);        // indirect, vertex and texture bits at once
  EXPECT_EQ(barriers(frame, "draw_again"), 0u);
  // Next frame, the list is written while earlier reads may still be on their way.
  run(frame);
  EXPECT_EQ(barriers(frame, "write"), 1u);
  EXPECT_EQ(barriers(frame, "draw"), 1u);
}

TEST_F(BarrierTest, NoneWithoutStorageWrites) {
  Frame frame;
  frame.addExternal("vertices");
  frame.addTarget("color", {.format = GL_RGBA8});
  frame.addPass({.name = "draw",
                 .stage = Stage::Geometry,
                 .uses = {{"vertices", Access::Vertex},
                          {"vertices", Access::StorageRead},
                          {"color", Access::Color}},
                 .run = nothing});
  frame.addPass({.name = "present",
                 .stage = Stage::Present,
                 .uses = {{"color", Access::Sampled}, {kOut, Access::Color}},
                 .run = nothing});
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 4; ++i) run(frame);
  EXPECT_EQ((gpu::counters() - before).barriers, 0u);
}

// A chain of compute passes over one buffer and one image, then a draw that reads both.
TEST_F(BarrierTest, ChainOfPassesComputesTheRightResult) {
  folder_.write(
      "step.comp",
      "layout(local_size_x = 64) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
      "layout(r32ui, binding = 0) uniform uimage2D image;\n"
      "layout(location = 0) uniform uint round_;\n"
      "void main() {\n"
      "  uint i = gl_GlobalInvocationID.x;\n"
      "  uint left = b[(i + 63u) % 64u + 64u * (round_ % 2u)];\n"
      "  uint value = left * 3u + b[i + 64u * (round_ % 2u)] + round_;\n"
      "  b[i + 64u * ((round_ + 1u) % 2u)] = value;\n"
      "  imageStore(image, ivec2(i % 8u, i / 8u), uvec4(value));\n}\n");
  folder_.write("full.vert",
                "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,"
                " gl_VertexID == 2 ? 3.0 : -1.0, 0.5, 1.0); }");
  folder_.write("sum.frag",
                "layout(std430, binding = 0) readonly buffer B { uint b[]; };\n"
                "layout(binding = 1) uniform usampler2D image; layout(location = 0) out uint o;\n"
                "void main() { ivec2 p = ivec2(gl_FragCoord.xy);\n"
                "  o = texelFetch(image, p, 0).x + b[p.x + 8 * p.y]; }");
  gpu::Program step({.name = "step", .compute = "step.comp", .root = folder_.path()});
  gpu::Program sum(
      {.name = "sum", .vertex = "full.vert", .fragment = "sum.frag", .root = folder_.path()});
  gpu::Buffer buffer("b", 128 * 4);

  constexpr uint32_t kRounds = 10;
  Frame frame;
  frame.addExternal("b");
  frame.addTarget("image", {.format = GL_R32UI, .fixed_size = {8, 8}});
  frame.addTarget("sum", {.format = GL_R32UI});
  for (uint32_t round = 0; round < kRounds; ++round)
    frame.addPass({.name = "round" + std::to_string(round),
                   .stage = Stage::Route,
                   .uses = {{"b", Access::StorageWrite}, {"image", Access::StorageWrite}},
                   .run = [&, round](PassContext& c) {
                     buffer.bindStorage(0);
                     c.frame.texture("image").bindImage(0, GL_WRITE_ONLY);
                     step.use();
                     step.set(0, round);
                     gpu::dispatch(1);
                   }});
  frame.addPass(
      {.name = "sum",
       .stage = Stage::Shade,
       .uses = {{"b", Access::StorageRead}, {"image", Access::Sampled}, {"sum", Access::Color}},
       .run = [&](PassContext& c) {
         buffer.bindStorage(0);
         c.frame.texture("image").bind(1);
         sum.use();
         gpu::drawFullScreen();
       }});
  frame.keep("sum", true);

  for (int repeat = 0; repeat < 3; ++repeat) {
    std::vector<uint32_t> start(128, 0);
    std::iota(start.begin(), start.begin() + 64, 1u + static_cast<uint32_t>(repeat));
    buffer.upload(std::span<const uint32_t>(start));
    const gpu::Counters before = gpu::counters();
    run(frame);
    // One before every pass but the first of the first frame.
    EXPECT_EQ((gpu::counters() - before).barriers, kRounds + (repeat > 0 ? 1 : 0));

    std::vector<uint32_t> now(start.begin(), start.begin() + 64);
    std::vector<uint32_t> expected(64);
    for (uint32_t round = 0; round < kRounds; ++round) {
      for (uint32_t i = 0; i < 64; ++i) expected[i] = now[(i + 63) % 64] * 3 + now[i] + round;
      now = expected;
    }
    for (uint32_t& value : expected) value *= 2;
    EXPECT_EQ(gpu::readUints(frame.texture("sum"), 1), expected);
  }
}

}  // namespace
}  // namespace scree
