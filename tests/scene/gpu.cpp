// The scene on the GPU: what is uploaded, when, and that the GPU reads what the CPU wrote.
#include "modules/scene/scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engine/app/app.h"
#include "engine/frame/frame.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "tests/support/gl_fixture.h"

namespace scree::test {
namespace {

namespace fs = std::filesystem;

class SceneGpu : public GlTest {};

MeshData triangle(float size) {
  MeshData mesh;
  mesh.vertices.resize(3);
  for (size_t i = 0; i < 3; ++i) {
    mesh.vertices[i].position = vec3(i == 1 ? size : 0, i == 2 ? size : 0, size);
    mesh.vertices[i].uv = vec2(static_cast<float>(i), size);
  }
  mesh.indices = {0, 1, 2};
  return mesh;
}

TEST_F(SceneGpu, AnEmptySceneUploadsOneViewBlock) {
  AppOptions options;
  options.threads = 1;
  App app(options);
  addScene(app);
  World& world = app.world();
  world.singleton<FrameInput>().size = {64, 32};
  const gpu::Counters before = gpu::counters();
  app.schedule().run(Phase::Prepare, world);
  gpu::Counters used = gpu::counters() - before;
  EXPECT_EQ(used.buffers, 1u);
  EXPECT_EQ(used.textures, 0u);
  EXPECT_EQ(used.programs, 0u);
  EXPECT_EQ(used.draws, 0u);
  EXPECT_EQ(used.bytes_uploaded, sizeof(rules::ViewBlock));
  EXPECT_FALSE(world.singleton<MeshStore>().onGpu());
  EXPECT_EQ(world.singleton<View>().block.size_px, vec2(64, 32));
  const gpu::Counters again = gpu::counters();
  for (int i = 0; i < 10; ++i) app.schedule().run(Phase::Prepare, world);
  used = gpu::counters() - again;
  EXPECT_EQ(used.buffers, 0u);
  EXPECT_EQ(used.bytes_uploaded, 10 * sizeof(rules::ViewBlock));
}

// A shader copies the uniform block, field by field, into a storage buffer: the std140 layout of
// the C++ struct is what GLSL sees.
TEST_F(SceneGpu, TheShaderReadsTheViewThatWasComputed) {
  AppOptions options;
  options.threads = 1;
  App app(options);
  addScene(app);
  World& world = app.world();
  const Entity eye = world.spawn(
      Transform{dvec3(1e6, 2, 3), glm::angleAxis(0.5f, vec3(0, 1, 0)), vec3(1)},
      PreviousTransform{dvec3(1e6 - 1, 2, 3), quat(1, 0, 0, 0), vec3(1)}, Camera{0.7f, 0.25f});
  world.singleton<ActiveCamera>().entity = eye;
  FrameInput& input = world.singleton<FrameInput>();
  input.size = {320, 200};
  input.frame = 77;
  input.sample = 5;
  input.jitter_px = vec2(0.25f, -0.125f);
  input.alpha = 0.5f;
  app.schedule().run(Phase::Prepare, world);

  // A root that holds both the probe and the shared headers.
  const fs::path root = fs::path(SCREE_BINARY_DIR) / "scene_shaders";
  fs::create_directories(root);
  fs::copy(fs::path(SCREE_SOURCE_DIR) / "shaders" / "shared", root / "shared",
           fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  std::ofstream(root / "probe.comp") << R"(#include "shared/view.h"
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Out { float values[]; };
uint at = 0u;
void put(float x) { values[at++] = x; }
void put4(vec4 v) { for (int i = 0; i < 4; ++i) put(v[i]); }
void put16(mat4 m) { for (int i = 0; i < 4; ++i) put4(m[i]); }
void main() {
  put16(view.clip_from_relative);
  put16(view.relative_from_clip);
  put16(view.steady_clip_from_relative);
  put16(view.previous_clip_from_relative);
  put4(view.camera_delta);
  for (int i = 0; i < 5; ++i) put4(view.frustum_planes[i]);
  put4(view.rotation);
  put4(vec4(view.size_px, view.jitter_px));
  put4(vec4(view.near_m, view.pixels_at_1m, view.tan_half_fov_y, view.tan_half_fov_x));
  put4(vec4(uintBitsToFloat(view.frame), uintBitsToFloat(view.sample_index), 0, 0));
}
)";
  gpu::Program program({.name = "test.view", .compute = "probe.comp", .root = root});
  const Status compiled = program.compile();
  ASSERT_TRUE(compiled.ok()) << compiled.error();
  ASSERT_TRUE(program.use());
  gpu::Buffer out("test.view", sizeof(rules::ViewBlock));
  out.fill(0);
  out.bindStorage(0);
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  const auto read = gpu::readBuffer<uint32_t>(out, sizeof(rules::ViewBlock) / 4);
  const rules::ViewBlock& block = world.singleton<View>().block;
  std::vector<uint32_t> expected(read.size());
  std::memcpy(expected.data(), &block, sizeof(block));
  EXPECT_EQ(read, expected);
  EXPECT_EQ(block.near_m, 0.25f);
  EXPECT_EQ(block.frame, 77u);
}

TEST_F(SceneGpu, MeshesAreUploadedOnceAndWhenSomebodyDraws) {
  MeshStore store;
  const gpu::Counters start = gpu::counters();
  store.add(triangle(1));
  EXPECT_EQ((gpu::counters() - start).buffers, 0u) << "nothing before the first draw";
  store.vertexArray();
  gpu::Counters used = gpu::counters() - start;
  EXPECT_EQ(used.buffers, 2u);
  EXPECT_EQ(used.bytes_uploaded, 3 * sizeof(Vertex) + 3 * sizeof(uint32_t));
  EXPECT_TRUE(store.onGpu());
  const uint64_t version = store.poolVersion();
  const gpu::Counters second = gpu::counters();
  store.vertexArray();
  EXPECT_EQ((gpu::counters() - second).bytes_uploaded, 0u);
  EXPECT_EQ(store.poolVersion(), version);

  for (int i = 2; i <= 100; ++i) store.add(triangle(static_cast<float>(i)));
  store.vertexArray();
  EXPECT_GT(store.poolVersion(), version);
  const auto vertices = gpu::readBuffer<Vertex>(store.vertexBuffer(), 300);
  const auto indices = gpu::readBuffer<uint32_t>(store.indexBuffer(), 300);
  for (uint32_t handle = 0; handle < 100; ++handle) {
    const MeshPart& part = store.mesh(handle).parts[0];
    for (uint32_t i = 0; i < 3; ++i) {
      const Vertex& v =
          vertices[static_cast<size_t>(part.base_vertex) + indices[part.first_index + i]];
      ASSERT_EQ(v.position.z, static_cast<float>(handle + 1));
      ASSERT_EQ(v.uv.x, static_cast<float>(i));
    }
  }
  // Room is left after growth: the next mesh is a small upload.
  const gpu::Counters third = gpu::counters();
  const uint64_t grown = store.poolVersion();
  store.add(triangle(200));
  store.vertexArray();
  if (store.poolVersion() == grown) {
    EXPECT_EQ((gpu::counters() - third).bytes_uploaded, 3 * sizeof(Vertex) + 12);
  }
  const auto after = gpu::readBuffer<Vertex>(store.vertexBuffer(), 303);
  EXPECT_EQ(after[0].position.z, 1);
  EXPECT_EQ(after[302].position.z, 200);
}

TEST_F(SceneGpu, AnEmptyStoreHasNothingToDraw) {
  MeshStore store;
  EXPECT_DEATH(store.vertexArray(), "MeshStore: the store is empty");
}

ImageData image(int width, int height, int channels, ColorEncoding encoding,
                std::vector<uint8_t> bytes) {
  ImageData data;
  data.width = width;
  data.height = height;
  data.channels = channels;
  data.encoding = encoding;
  data.bytes = std::move(bytes);
  return data;
}

std::vector<float> readTexture(const gpu::Texture& texture, int level) {
  const ivec2 size = texture.size(level);
  std::vector<float> texels(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * 4);
  glGetTextureImage(texture.id(), level, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(texels.size() * 4),
                    texels.data());
  return texels;
}

TEST_F(SceneGpu, TexturesAreMadeOnFirstUseAndShared) {
  MaterialStore store;
  const int picture = store.addImage(
      image(2, 2, 3, ColorEncoding::Linear, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}));
  MaterialData material;
  material.base_color_map.image = picture;
  material.emissive_map.image = picture;
  const uint32_t a = store.add(material);
  material.base_color_map.wrap_v = TextureWrap::ClampToEdge;
  const uint32_t b = store.add(material);
  const gpu::Counters start = gpu::counters();
  const gpu::Texture& color = store.texture(a, MaterialMap::BaseColor);
  EXPECT_EQ((gpu::counters() - start).textures, 1u);
  EXPECT_EQ(&store.texture(a, MaterialMap::Emissive), &color);
  EXPECT_EQ(&store.texture(b, MaterialMap::Emissive), &color);
  EXPECT_NE(&store.texture(b, MaterialMap::BaseColor), &color) << "another way to wrap";
  EXPECT_EQ((gpu::counters() - start).textures, 2u);
  EXPECT_EQ(color.desc().levels, 2);
  // The top row comes first: v = 0 is the top.
  const std::vector<float> texels = readTexture(color, 0);
  EXPECT_EQ(texels[0], 1);
  EXPECT_EQ(texels[5], 1);
  EXPECT_EQ(texels[10], 1);
  EXPECT_EQ(texels[3], 1) << "missing alpha is 1";
  int wrap = 0;
  glGetTextureParameteriv(store.texture(b, MaterialMap::BaseColor).id(), GL_TEXTURE_WRAP_T, &wrap);
  EXPECT_EQ(wrap, GL_CLAMP_TO_EDGE);
  glGetTextureParameteriv(store.texture(b, MaterialMap::BaseColor).id(), GL_TEXTURE_WRAP_S, &wrap);
  EXPECT_EQ(wrap, GL_REPEAT);
}

TEST_F(SceneGpu, MipmapsOfColorsAreAveragedAsLight) {
  MaterialStore store;
  for (const ColorEncoding encoding : {ColorEncoding::Srgb, ColorEncoding::Linear}) {
    MaterialData material;
    material.base_color_map.image = store.addImage(image(2, 2, 1, encoding, {0, 255, 255, 0}));
    const gpu::Texture& texture = store.texture(store.add(material), MaterialMap::BaseColor);
    // GetTexImage returns the stored numbers: half the light of white is 188 in sRGB.
    const float half = readTexture(texture, 1)[0] * 255;
    EXPECT_NEAR(half, encoding == ColorEncoding::Srgb ? 187.5 : 127.5, 1.1);
  }
}

TEST_F(SceneGpu, MissingMapsAreNeutral) {
  MaterialStore store;
  EXPECT_EQ(readTexture(store.texture(0, MaterialMap::BaseColor), 0),
            (std::vector<float>{1, 1, 1, 1}));
  EXPECT_EQ(readTexture(store.texture(0, MaterialMap::Emissive), 0),
            (std::vector<float>{1, 1, 1, 1}));
  const std::vector<float> normal = readTexture(store.texture(0, MaterialMap::Normal), 0);
  EXPECT_NEAR(normal[0] * 2 - 1, 0, 0.005);
  EXPECT_NEAR(normal[1] * 2 - 1, 0, 0.005);
  EXPECT_EQ(normal[2], 1);
  store.bind(0);
  for (unsigned unit = 0; unit < kMaterialMaps; ++unit) {
    int bound = 0;
    glGetIntegeri_v(GL_TEXTURE_BINDING_2D, unit, &bound);
    EXPECT_NE(bound, 0);
  }
}

TEST_F(SceneGpu, FloatImagesKeepTheirRange) {
  MaterialStore store;
  ImageData bright;
  bright.width = 2;
  bright.height = 1;
  bright.channels = 3;
  bright.floats = {1e6f, 0.5f, 0, 2, 3, 4};
  MaterialData material;
  material.emissive_map.image = store.addImage(bright);
  const gpu::Texture& texture = store.texture(store.add(material), MaterialMap::Emissive);
  const std::vector<float> texels = readTexture(texture, 0);
  EXPECT_EQ(texels[0], 1e6f);
  EXPECT_EQ(texels[6], 4);
}

}  // namespace
}  // namespace scree::test
