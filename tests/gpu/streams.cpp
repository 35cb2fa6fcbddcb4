// Stream buffers and GPU timers over many frames.
#include <cstring>
#include <numeric>
#include <vector>

#include "engine/gpu/counters.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "engine/gpu/state.h"
#include "engine/gpu/stream.h"
#include "engine/gpu/timers.h"
#include "tests/support/gl_allocations.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree::gpu {
namespace {

class StreamTest : public test::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    folder_.write("sum.comp",
                  "layout(local_size_x = 1) in;\n"
                  "layout(std430, binding = 0) readonly buffer In { uint x[]; };\n"
                  "layout(std430, binding = 1) buffer Out { uint sums[]; };\n"
                  "layout(location = 0) uniform uint slot;\n"
                  "void main() { uint sum = 0u; for (int i = 0; i < x.length(); ++i) sum += x[i]; "
                  "sums[slot] = sum; }");
    sum_ = Program({.name = "sum", .compute = "sum.comp", .root = folder_.path()});
  }
  test::ShaderFolder folder_;
  Program sum_;
};

// Every frame writes several slices and the GPU sums each; nothing is read back before the end, so
// a region that is overwritten too early gives a wrong sum.
TEST_F(StreamTest, SlicesHoldWhatTheirFrameWrote) {
  constexpr uint32_t kFrames = 300, kSlices = 4;
  Buffer sums("sums", kFrames * kSlices * 4);
  StreamBuffer stream("stream", 4096);
  std::vector<uint32_t> expected;
  Counters before;
  for (uint32_t frame = 0; frame < kFrames; ++frame) {
    if (frame == 1) before = counters();
    stream.beginFrame();
    for (uint32_t slice = 0; slice < kSlices; ++slice) {
      std::vector<uint32_t> values(1 + (frame * 7 + slice * 13) % 60);
      std::iota(values.begin(), values.end(), frame * 1000 + slice);
      expected.push_back(std::accumulate(values.begin(), values.end(), 0u));
      stream.write(std::span<const uint32_t>(values)).bindStorage(0);
      sums.bindStorage(1);
      sum_.use();
      sum_.set(0, frame * kSlices + slice);
      dispatch(1);
    }
  }
  EXPECT_EQ(readBuffer<uint32_t>(sums, kFrames * kSlices), expected);
  EXPECT_EQ((counters() - before).buffers, 0u);
  EXPECT_EQ(stream.regionBytes(), 4096u);
}

// Draws are slow to finish, and the CPU runs ahead of them: only the fences keep it from writing
// over what the rasteriser still reads.
TEST_F(StreamTest, FencesHoldBackTheCpu) {
  folder_.write("row.vert",
                "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0,"
                " gl_VertexID == 2 ? 3.0 : -1.0, 0.5, 1.0); }");
  folder_.write("row.frag",
                "layout(std430, binding = 0) readonly buffer In { uint x[]; };\n"
                "layout(location = 0) out uint o;\n"
                "void main() { uint sum = 0u; for (int i = 0; i < 20000; ++i) sum += x[i % 64];\n"
                "  o = sum; }");
  Program row(
      {.name = "row", .vertex = "row.vert", .fragment = "row.frag", .root = folder_.path()});
  constexpr int kFrames = 60, kWidth = 64;
  Texture rows("rows", {.format = GL_R32UI, .size = {kWidth, kFrames}});
  Framebuffer target("rows");
  target.attachColor(rows);
  ASSERT_TRUE(target.finish().ok());
  target.bind();
  setScissor(std::nullopt);
  apply(DrawState{});
  StreamBuffer stream("fenced", 256);
  std::vector<uint32_t> expected;
  for (int frame = 0; frame < kFrames; ++frame) {
    stream.beginFrame();
    const std::vector<uint32_t> values(64, static_cast<uint32_t>(frame) + 1);
    stream.write(std::span<const uint32_t>(values)).bindStorage(0);
    setViewport({{0, frame}, {kWidth, 1}});
    row.use();
    drawFullScreen();
    expected.insert(expected.end(), kWidth, 20'000u * (static_cast<uint32_t>(frame) + 1));
  }
  EXPECT_EQ(stream.regionBytes(), 256u);
  EXPECT_EQ(readUints(rows, 1), expected);
}

TEST_F(StreamTest, GrowsByDoublingAndKeepsTheFramesSlices) {
  Buffer sums("sums", 64 * 4);
  StreamBuffer stream("grows", 256);
  stream.beginFrame();
  std::vector<StreamSlice> slices;
  std::vector<uint32_t> expected;
  const uint64_t buffers_before = counters().buffers;
  for (uint32_t i = 0; i < 40; ++i) {
    const std::vector<uint32_t> values(50, i + 1);
    expected.push_back(50 * (i + 1));
    slices.push_back(stream.write(std::span<const uint32_t>(values)));
  }
  EXPECT_EQ(stream.regionBytes() & (stream.regionBytes() - 1), 0u);
  EXPECT_LE(counters().buffers - buffers_before, 8u);
  // Written before the ring grew, bound after: still what this frame wrote.
  for (uint32_t i = 0; i < slices.size(); ++i) {
    slices[i].bindStorage(0);
    sums.bindStorage(1);
    sum_.use();
    sum_.set(0, i);
    dispatch(1);
  }
  EXPECT_EQ(readBuffer<uint32_t>(sums, 40), expected);

  // One slice larger than everything so far. (llvmpipe leaves any loop after 65,535 rounds.)
  const std::vector<uint32_t> large(60'000, 1);
  const StreamSlice slice = stream.write(std::span<const uint32_t>(large));
  slice.bindStorage(0);
  sums.bindStorage(1);
  sum_.set(0, 0u);
  dispatch(1);
  EXPECT_EQ(readBuffer<uint32_t>(sums, 1)[0], 60'000u);
  // Old rings go after three frames.
  const size_t ring = StreamBuffer::kRegions * stream.regionBytes();
  for (int frame = 0; frame < 4; ++frame) stream.beginFrame();
  const uint64_t live_with = counters().live_buffer_bytes;
  stream = StreamBuffer();
  EXPECT_EQ(live_with - counters().live_buffer_bytes, ring);
}

TEST_F(StreamTest, AlignmentIsKept) {
  StreamBuffer stream("aligned", 1024);
  for (int frame = 0; frame < 7; ++frame) {
    stream.beginFrame();
    for (size_t bytes : {1u, 3u, 17u}) {
      const StreamSlice bindable = stream.allocate(bytes);
      EXPECT_EQ(bindable.offset % limits().uniform_alignment, 0u);
      EXPECT_EQ(bindable.offset % limits().storage_alignment, 0u);
      EXPECT_EQ(stream.allocate(bytes, 48).offset % 48, 0u);
      EXPECT_EQ(bindable.bytes, bytes);
    }
  }
}

TEST_F(StreamTest, SteadyStateAllocatesNothing) {
  StreamBuffer stream("steady", 1024);
  Timers timers;
  const int timer = timers.find("steady");
  auto frame = [&] {
    timers.poll();
    stream.beginFrame();
    timers.begin(timer);
    stream.write(vec4(1)).bindUniform(2);
    timers.end(timer);
  };
  for (int i = 0; i < 10; ++i) frame();
  const test::AllocationCount allocations;
  for (int i = 0; i < 100; ++i) frame();
  EXPECT_EQ(allocations.count(), 0);
}

TEST_F(StreamTest, NothingExistsBeforeUse) {
  const Counters before = counters();
  {
    StreamBuffer stream("never", 1 << 20);
    StreamBuffer moved = std::move(stream);
  }
  EXPECT_EQ((counters() - before).buffers, 0u);
}

TEST_F(StreamTest, UniformSlices) {
  folder_.write("u.comp",
                "layout(local_size_x = 1) in; layout(std140, binding = 2) uniform U { vec4 v; };\n"
                "layout(std430, binding = 1) buffer Out { uint sums[]; }; void main() { sums[0] = "
                "uint(v.z); }");
  Program program({.name = "u", .compute = "u.comp", .root = folder_.path()});
  Buffer out("out", 16);
  StreamBuffer stream("u");
  for (int frame = 0; frame < 5; ++frame) {
    stream.beginFrame();
    stream.write(vec4(0, 0, static_cast<float>(frame * 3), 0)).bindUniform(2);
    out.bindStorage(1);
    program.use();
    dispatch(1);
    EXPECT_EQ(readBuffer<uint32_t>(out, 1)[0], static_cast<uint32_t>(frame * 3));
  }
}

TEST_F(StreamTest, TimersReportLateAndNeverGrow) {
  Timers timers;
  const int outer = timers.find("outer"), inner = timers.find("inner"), idle = timers.find("idle");
  EXPECT_EQ(timers.find("outer"), outer);
  EXPECT_EQ(timers.count(), 3u);
  const std::vector<uint32_t> values(20'000, 1);
  Buffer in("in", std::span<const uint32_t>(values)), sums("sums", 16);
  const Counters before = counters();
  EXPECT_LT(timers.lastMs(outer), 0);
  constexpr uint64_t kFrames = 40;
  for (uint64_t frame = 0; frame < kFrames; ++frame) {
    timers.poll();
    timers.begin(outer);
    timers.begin(inner);
    in.bindStorage(0);
    sums.bindStorage(1);
    sum_.use();
    sum_.set(0, 0u);
    dispatch(1);
    timers.end(inner);
    timers.end(outer);
  }
  timers.finish();
  EXPECT_GT(timers.measurements(outer), 0u);
  EXPECT_LE(timers.measurements(outer), kFrames);
  EXPECT_GT(timers.lastMs(inner), 0);
  EXPECT_GE(timers.lastMs(outer), timers.lastMs(inner));
  EXPECT_LT(timers.lastMs(outer), 10'000);
  EXPECT_GT(timers.lastStartNs(outer), 0);
  EXPECT_LT(timers.lastMs(idle), 0);
  // A ring for each timer that ran, whatever the number of frames.
  EXPECT_EQ((counters() - before).queries, 20u);
}

// Many measurements without a poll between: the ring is full, and further ones are skipped or
// taken in, but never waited for and never mixed up.
TEST_F(StreamTest, TimersSurviveWithoutPolling) {
  Timers timers;
  const int timer = timers.find("t");
  for (int i = 0; i < 100; ++i) {
    timers.begin(timer);
    timers.end(timer);
  }
  timers.end(timer);  // never begun
  timers.finish();
  EXPECT_GE(timers.measurements(timer), 1u);
  EXPECT_LE(timers.measurements(timer), 100u);
  EXPECT_GE(timers.lastMs(timer), 0);
  EXPECT_LT(timers.lastMs(timer), 1000);
  timers.release();
  timers.begin(timer);
  timers.end(timer);
  timers.finish();
}

}  // namespace
}  // namespace scree::gpu
