// Coverage as it is packed for drawing: places that do not overlap, and the values that bilinear reading gives.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include "engine/core/random.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "modules/impostors/impostors.h"
#include "shaders/shared/coverage.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree {
namespace {

TEST(ImpostorCoverage, PlacesAreInTheTextureAndApart) {
  for (int p = kImpostorMinTexels; p <= kImpostorMaxTexels; p *= 2)
    for (const int edge : {2, 6, 13, kImpostorMaxBakedEdge}) {
      const ImpostorAtlas atlas{.edge = edge, .texels = p};
      const ivec2 size = rules::coverageSize(p, atlas.views());
      if (impostorBytes(edge, p) > kImpostorMaxBytes) continue;  // there is no such atlas
      ASSERT_LE(std::max(size.x, size.y), 16384) << "larger than GL promises";
      std::vector<bool> taken(static_cast<size_t>(size.x) * static_cast<size_t>(size.y));
      for (int view = 0; view < atlas.views(); ++view)
        for (int level = 0; level < atlas.levels(); ++level) {
          const ivec2 base = rules::coverageBase(p, view, level);
          const int side = atlas.side(level);
          ASSERT_TRUE(base.x >= 0 && base.y >= 0 && base.x + side <= size.x && base.y + side <= size.y) << p << " " << edge;
          // What is added to a number of steps leaves whole numbers exact.
          ASSERT_LT(rules::coverageFrom(p, view, level).x + rules::coverageSteps(p, level), 16777216.0f);
          ASSERT_LT(rules::coverageFrom(p, view, level).y + rules::coverageSteps(p, level), 16777216.0f);
          for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
              auto bit = taken[static_cast<size_t>(base.y + y) * static_cast<size_t>(size.x) + static_cast<size_t>(base.x + x)];
              ASSERT_FALSE(bit) << "two places overlap: " << p << " " << edge << " " << view << " " << level;
              bit = true;
            }
        }
    }
}

TEST(ImpostorCoverage, BetweenIsBilinear) {
  double worst = 0;
  for (uint64_t k = 0; k < 200'000; ++k) {
    const auto below = [&](uint32_t at, uint32_t end) { return static_cast<uint32_t>(randomUnit(7, k, 0, at) * static_cast<float>(end)); };
    uint32_t v[4];
    // Every fourth time the ends of the range, which are what is read most.
    for (uint32_t c = 0; c < 4; ++c) v[c] = k % 4 == 0 ? 255 * below(c, 2) : below(c, 256);
    const uvec2 part(below(4, 256), below(5, 256));
    const double x = part.x / 256.0, y = part.y / 256.0;
    const double low = v[0] + (static_cast<double>(v[1]) - v[0]) * x, high = v[2] + (static_cast<double>(v[3]) - v[2]) * x;
    const uint32_t read = rules::coverageBetween(v[0] | v[1] << 8 | v[2] << 16 | v[3] << 24, part);
    ASSERT_LE(read, 255u);
    worst = std::max(worst, std::abs(read - (low + (high - low) * y)));
  }
  EXPECT_LE(worst, 1.0) << "half a step for each of two roundings";
  EXPECT_GT(worst, 0.5);
}

class ImpostorCoverageGpu : public test::GlTest {};

TEST_F(ImpostorCoverageGpu, TakesTheMemoryThatIsSaid) {
  for (const auto& [edge, texels] : {std::pair(2, 16), std::pair(6, 64), std::pair(12, 64), std::pair(10, 128)}) {
    ImpostorAtlas atlas{.edge = edge, .texels = texels};
    atlas.shape.resize(2 * atlas.texelCount());
    atlas.color.resize(4 * atlas.texelCount());
    atlas.normal.resize(4 * atlas.texelCount());
    ImpostorStore store;
    store.set(0, std::move(atlas));
    const uint64_t before = gpu::counters().live_texture_bytes;
    store.bind(0);
    EXPECT_EQ(gpu::counters().live_texture_bytes - before, impostorBytes(edge, texels)) << edge << ", " << texels;
    // 24 bytes a texel of the finest level, but where the views' last column is not full.
    const auto finest = static_cast<double>(rules::impostorViewCount(edge) * texels * texels);
    EXPECT_GE(static_cast<double>(impostorBytes(edge, texels)), 24 * finest);
    if (rules::impostorViewCount(edge) <= rules::coverageRows(texels)) {
      EXPECT_EQ(static_cast<double>(impostorBytes(edge, texels)), 24 * finest);
    }
  }
}

constexpr const char* kProgram = "#include \"impostors/atlas.glsl\"\n" R"(#include "impostors/surface.glsl"
layout(binding = kImpostorColorUnit) uniform sampler2DArray atlas_color;
layout(binding = kImpostorNormalUnit) uniform sampler2DArray atlas_normal;
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { vec4 cases[]; };
layout(std430, binding = 1) buffer Out { vec4 values[]; };  // two a case
float most(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }
void main() {
  uint k = gl_GlobalInvocationID.x;
  if (k >= uint(cases.length())) return;
  vec4 c = cases[k];
  float steps = coverageSteps(atlas.texels, int(c.w));
  vec2 from = coverageFrom(atlas.texels, int(c.z), int(c.w)), shape = textureLod(atlas_shape, c.xyz, c.w).rg;
  AtlasSurface surface = surfaceAt(c.xy * steps, steps, from);
  vec4 off_color = abs(surface.color - textureLod(atlas_color, c.xyz, c.w));
  vec4 off_normal = abs(surface.normal - textureLod(atlas_normal, c.xyz, c.w));
  values[2u * k] = vec4(shapeAt(c.xy * steps, steps, from), shape);
  values[2u * k + 1u] = vec4(coverageAt(c.xy * steps, steps, from), most(off_color), most(off_normal), 0.0);
}
)";

TEST_F(ImpostorCoverageGpu, IsWhatTextureUnitsRead) {
  ImpostorAtlas atlas{.edge = 4, .texels = 32};
  const uint64_t texels = atlas.texelCount();
  // Neighbours as unlike as can be.
  for (uint64_t k = 0; k < 4 * texels; ++k) {
    atlas.color.push_back(static_cast<uint8_t>(randomUnit(8, k, 1, 0) * 256));
    atlas.normal.push_back(static_cast<uint8_t>(randomUnit(8, k, 2, 0) * 256));
  }
  for (uint64_t k = 0; k < 2 * texels; ++k) atlas.shape.push_back(static_cast<uint8_t>(randomUnit(8, k, 0, 0) * 256));
  std::vector<vec4> cases;
  for (uint64_t k = 0; k < 100'000; ++k) {
    const auto unit = [&](uint32_t at) { return randomUnit(9, k, 0, at); };
    // Beyond the edges too.
    cases.emplace_back(unit(0) * 1.2f - 0.1f, unit(1) * 1.2f - 0.1f, std::floor(unit(2) * static_cast<float>(atlas.views())),
                       std::floor(unit(3) * static_cast<float>(atlas.levels())));
  }
  ImpostorStore store;
  store.set(0, atlas);
  store.bindTextures(0);
  test::ShaderFolder root;
  std::filesystem::copy(std::string(SCREE_SOURCE_DIR) + "/shaders", root.path(),
                        std::filesystem::copy_options::recursive | std::filesystem::copy_options::overwrite_existing);
  root.write("probe.comp", kProgram);
  gpu::Program program({.name = "test.impostor_coverage", .compute = "probe.comp", .root = root.path()});
  const Status compiled = program.compile();
  ASSERT_TRUE(compiled.ok()) << compiled.error();
  ASSERT_TRUE(program.use());
  gpu::Buffer in("test.cases", std::span<const vec4>(cases)), out("test.values", 2 * cases.size() * sizeof(vec4));
  out.fill(0);
  in.bindStorage(0);
  out.bindStorage(1);
  gpu::dispatchItems(cases.size(), 64);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  struct Read {
    vec2 shape, of_texture;
    float coverage, off_color, off_normal, unused;
  };
  const auto read = gpu::readBuffer<Read>(out, cases.size());
  size_t same_coverage = 0, same_height = 0, same_color = 0, same_normal = 0;
  float off_shape = 0, off_color = 0, off_normal = 0;
  for (size_t k = 0; k < cases.size(); ++k) {
    const vec4 c = cases[k];
    const vec2 expected = sampleShape(atlas, static_cast<int>(c.w), static_cast<int>(c.z), vec2(c));
    const Read& r = read[k];
    // The place is rounded to 1/256 of a texel along both axes, and each of two steps to 1/255.
    for (int channel = 0; channel < 2; ++channel) {
      ASSERT_NEAR(r.shape[channel], expected[channel], 2.1f / 255) << c.x << " " << c.y << " view " << c.z << " level " << c.w;
      ASSERT_NEAR(r.of_texture[channel], expected[channel], 2.1f / 255) << "texture unit";
      off_shape = std::max(off_shape, std::abs(r.shape[channel] - r.of_texture[channel]));
    }
    ASSERT_EQ(r.coverage, r.shape.x);
    same_coverage += r.shape.x == r.of_texture.x;
    same_height += r.shape.y == r.of_texture.y;
    same_color += r.off_color == 0;
    same_normal += r.off_normal == 0;
    off_color = std::max(off_color, r.off_color);
    off_normal = std::max(off_normal, r.off_normal);
  }
  std::printf("of %zu to the bit as the texture unit reads them: coverage %zu, height %zu, color %zu, normal %zu; off by at most "
              "%.3f, %.3f, %.3f codes\n", cases.size(), same_coverage, same_height, same_color, same_normal,
              static_cast<double>(off_shape * 255), static_cast<double>(off_color * 255), static_cast<double>(off_normal * 255));
  // GL leaves open how a texture unit rounds: here it is known.
  if (std::string_view(reinterpret_cast<const char*>(glGetString(GL_RENDERER))).starts_with("llvmpipe")) {
    for (const size_t same : {same_coverage, same_height, same_color, same_normal}) EXPECT_EQ(same, cases.size());
  }
  EXPECT_LE(std::max({off_shape, off_color, off_normal}), 2.05f / 255);
}

}  // namespace
}  // namespace scree
