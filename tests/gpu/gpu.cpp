// Objects and readback of engine/gpu against a real context.
#include <numeric>
#include <vector>

#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/readback.h"
#include "engine/gpu/state.h"
#include "tests/support/gl_fixture.h"

namespace scree::gpu {
namespace {

class GpuTest : public test::GlTest {};

TEST_F(GpuTest, ContextIsGood) {
  EXPECT_GE(limits().texture_size, 4096);
  EXPECT_GE(limits().color_attachments, 8);
  EXPECT_GE(limits().storage_block_bytes, size_t{1} << 27);
  GLint origin = 0, depth = 0;
  glGetIntegerv(GL_CLIP_ORIGIN, &origin);
  glGetIntegerv(GL_CLIP_DEPTH_MODE, &depth);
  EXPECT_EQ(origin, GL_LOWER_LEFT);
  EXPECT_EQ(depth, GL_ZERO_TO_ONE);
}

// The fixture itself must notice misuse of GL.
TEST_F(GpuTest, MisuseOfGlIsCounted) {
  glBindTextureUnit(0, 12345);
  EXPECT_EQ(messages(), 1u);
  EXPECT_FALSE(lastDebugMessage().empty());
  EXPECT_EQ(drainErrors(), 1);
  expectMessages(1);
}

TEST_F(GpuTest, BufferKeepsBytesAndCounts) {
  const Counters before = counters();
  std::vector<uint32_t> words(1000);
  std::iota(words.begin(), words.end(), 7u);
  Buffer buffer("words", std::span<const uint32_t>(words));
  EXPECT_EQ(readBuffer<uint32_t>(buffer, 1000), words);
  buffer.upload(std::span<const uint32_t>(words).first(2), 8);
  EXPECT_EQ(readBuffer<uint32_t>(buffer, 4), (std::vector<uint32_t>{7, 8, 7, 8}));
  buffer.fill(0xabcdu);
  EXPECT_EQ(readBuffer<uint32_t>(buffer, 1, 3996), (std::vector<uint32_t>{0xabcd}));

  char label[32] = {};
  glGetObjectLabel(GL_BUFFER, buffer.id(), sizeof label, nullptr, label);
  EXPECT_STREQ(label, "words");
  Counters used = counters() - before;
  EXPECT_EQ(used.buffers, 1u);
  EXPECT_EQ(used.buffer_bytes, 4000u);
  EXPECT_EQ(used.bytes_uploaded, 4008u);
  EXPECT_EQ(used.readbacks, 3u);
  EXPECT_EQ(used.live_buffer_bytes, before.live_buffer_bytes + 4000u);
}

TEST_F(GpuTest, ObjectsMoveAndAreFreedOnce) {
  const uint64_t live = counters().live_buffer_bytes;
  Buffer a("a", 64);
  const unsigned id = a.id();
  Buffer b = std::move(a);
  EXPECT_FALSE(a);
  EXPECT_EQ(a.bytes(), 0u);
  EXPECT_EQ(b.id(), id);
  b = Buffer("c", 128);
  EXPECT_EQ(counters().live_buffer_bytes, live + 128);
  EXPECT_FALSE(glIsBuffer(id) && b.id() != id);
  b = Buffer();
  EXPECT_EQ(counters().live_buffer_bytes, live);

  const uint64_t live_textures = counters().live_texture_bytes;
  {
    Texture t("t", {.format = GL_RGBA8, .size = {8, 4}, .levels = 0});
    EXPECT_EQ(t.desc().levels, 4);
    EXPECT_EQ(t.bytes(), 4u * (32 + 8 + 2 + 1));
    Texture u = std::move(t);
    EXPECT_EQ(counters().live_texture_bytes, live_textures + 4u * 43);
  }
  EXPECT_EQ(counters().live_texture_bytes, live_textures);
}

TEST_F(GpuTest, ReserveGrowsByDoubling) {
  Buffer buffer;
  EXPECT_TRUE(reserve(buffer, "grown", 100));
  EXPECT_EQ(buffer.bytes(), 100u);
  EXPECT_FALSE(reserve(buffer, "grown", 100));
  EXPECT_TRUE(reserve(buffer, "grown", 101));
  EXPECT_EQ(buffer.bytes(), 200u);
  EXPECT_TRUE(reserve(buffer, "grown", 1000));
  EXPECT_EQ(buffer.bytes(), 1000u);
}

TEST_F(GpuTest, BadRangesEndTheProgram) {
  // The driver has threads: a plain fork could deadlock.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  Buffer buffer("small", 64);
  uint32_t word = 0;
  EXPECT_DEATH(buffer.upload(&word, 4, 61), "upload of 4 bytes at 61");
  EXPECT_DEATH(buffer.bindStorage(0, 0, 65), "65 bytes at 0 of a buffer of 64");
  EXPECT_DEATH(buffer.bindUniform(0, 1), "no multiple of");
  EXPECT_DEATH(Buffer("none", 0), "'none': 0 bytes");
  EXPECT_DEATH(Texture("wide", {.format = GL_RGBA8, .size = {0, 4}}), "'wide': size 0x4");
  Texture texture("t", {.format = GL_RGBA8, .size = {2, 2}});
  EXPECT_DEATH(texture.upload(std::vector<uint8_t>(15), 4), "15 values for 2x2 texels");
  EXPECT_DEATH((void)readUints(texture, 1), "RGBA8 texels cannot be read");
}

TEST_F(GpuTest, TexelsComeBackBottomUp) {
  Texture bytes("bytes", {.format = GL_RGBA8, .size = {3, 2}});
  std::vector<uint8_t> rgba(24);
  std::iota(rgba.begin(), rgba.end(), uint8_t{1});
  bytes.upload(rgba, 4);
  EXPECT_EQ(readBytes(bytes, 4), rgba);
  EXPECT_EQ(readBytes(bytes, 1), (std::vector<uint8_t>{1, 5, 9, 13, 17, 21}));

  // Encoded values of an sRGB texture are not touched.
  Texture srgb("srgb", {.format = GL_SRGB8_ALPHA8, .size = {3, 2}});
  srgb.upload(rgba, 4);
  EXPECT_EQ(readBytes(srgb, 4), rgba);

  Texture ids("ids", {.format = GL_R32UI, .size = {2, 2}, .layers = 3, .kind = TextureKind::Array});
  const std::vector<uint32_t> values = {1, 0xffffffffu, 3, 0x80000000u};
  ids.clear(vec4(9));
  ids.upload(values, 1, 0, 2);
  EXPECT_EQ(readUints(ids, 1, 0, 2), values);
  EXPECT_EQ(readUints(ids, 1, 0, 1), std::vector<uint32_t>(4, 9u));

  Texture depth("depth", {.format = GL_DEPTH_COMPONENT32F, .size = {2, 1}});
  depth.upload(std::vector<float>{0.25f, 1e-6f}, 1);
  EXPECT_EQ(readFloats(depth, 1), (std::vector<float>{0.25f, 1e-6f}));
}

TEST_F(GpuTest, MipsAverage) {
  Texture texture("mips", {.format = GL_R32F, .size = {4, 4}, .levels = 0});
  std::vector<float> values(16);
  std::iota(values.begin(), values.end(), 0.0f);
  texture.upload(values, 1);
  texture.generateMips();
  EXPECT_EQ(readFloats(texture, 1, 1), (std::vector<float>{2.5f, 4.5f, 10.5f, 12.5f}));
  EXPECT_EQ(readFloats(texture, 1, 2), (std::vector<float>{7.5f}));
}

TEST_F(GpuTest, WindowGetsTheTexelsUnchanged) {
  if (glCheckNamedFramebufferStatus(0, GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    GTEST_SKIP() << "an EGL surfaceless context has no window framebuffer; run with "
                    "SCREE_TEST_CONTEXT=osmesa or window";
  Texture texture("t", {.format = GL_RGBA8, .size = {2, 2}});
  const std::vector<uint8_t> texels = {10, 20, 30, 255, 40,  50,  60,  255,
                                       70, 80, 90, 255, 100, 110, 120, 255};
  texture.upload(texels, 4);
  setScissor(Rect{{0, 0}, {1, 1}});
  for (int repeat = 0; repeat < 2; ++repeat) {
    copyToWindow(texture, {2, 2});
    std::vector<uint8_t> window(16);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    glReadPixels(0, 0, 2, 2, GL_RGBA, GL_UNSIGNED_BYTE, window.data());
    for (size_t i = 3; i < 16; i += 4) window[i] = 255;  // a window may have no alpha
    EXPECT_EQ(window, texels);
  }
}

TEST_F(GpuTest, IncompleteFramebufferSaysWhy) {
  Framebuffer empty("empty");
  const Status status = empty.finish();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("no attachment"), std::string::npos) << status.error();
  expectMessages(messages());  // drivers may say so, too
}

}  // namespace
}  // namespace scree::gpu
