// The tiles that spheres may cover, against rays through all pixels.
#include "modules/grains/cover.h"

#include <gtest/gtest.h>

#include <set>

#include "engine/core/random.h"
#include "engine/frame/frame.h"
#include "shaders/shared/cover.h"
#include "shaders/shared/sphere.h"

namespace scree::grains {
namespace {

using Tiles = std::set<std::pair<int, int>>;

Tiles marked(const Cover& cover) {
  std::vector<uint32_t> spans;
  cover.spans(spans);
  Tiles tiles;
  for (const uint32_t span : spans) {
    const vec2 low = rules::coverCorner(span, 0), high = rules::coverCorner(span, 2);
    const int side = rules::kCoverTilePx;
    for (int x = static_cast<int>(low.x); x < static_cast<int>(high.x); x += side)
      EXPECT_TRUE(tiles.emplace(x / side, static_cast<int>(low.y) / side).second) << "twice";
    EXPECT_EQ(high.y - low.y, static_cast<float>(side));
  }
  return tiles;
}

View viewOf(ivec2 size, const quat& rotation, float fov) {
  Transform eye;
  eye.rotation = rotation;
  Camera camera;
  camera.fov_y_rad = fov;
  FrameInput input;
  input.size = size;
  input.jitter_px = {0.3f, -0.4f};
  return computeView(previousOf(eye), eye, camera, input);
}

TEST(GrainCover, HoldsEveryPixelOfEverySphere) {
  size_t all = 0, needed_tiles = 0;
  for (uint64_t k = 0; k < 3000; ++k) {
    const auto unit = [&](uint64_t draw) { return randomUnit(7, k, 0, draw); };
    const ivec2 size(50 + static_cast<int>(100 * unit(0)), 40 + static_cast<int>(60 * unit(1)));
    const quat rotation = glm::normalize(
        quat(unit(2) - 0.5f, unit(3) - 0.5f, unit(4) - 0.5f, unit(5) - 0.49f));
    const View view = viewOf(size, rotation, 0.2f + 2 * unit(6));
    const vec3 center(8 * unit(7) - 4, 8 * unit(8) - 4, 8 * unit(9) - 4);
    const float radius = 2 * unit(10) * unit(11) * unit(12);
    Cover cover;
    cover.reset(view);
    EXPECT_TRUE(marked(cover).empty());
    cover.add(center, radius);
    const Tiles tiles = marked(cover);
    Tiles needed;
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const vec2 ndc = rules::ndcFromPixel(vec2(size), vec2(ivec2(x, y)) + 0.5f);
        const vec3 ray = rules::rayFromNdc(view.block.relative_from_clip, ndc);
        if (rules::hitSphere(ray, center, radius, false).t > 0)
          needed.emplace(x / rules::kCoverTilePx, y / rules::kCoverTilePx);
      }
    for (const auto& tile : needed)
      EXPECT_TRUE(tiles.count(tile)) << k << ": " << tile.first << " " << tile.second;
    if (needed.empty()) continue;
    all += tiles.size();
    needed_tiles += needed.size();
  }
  EXPECT_GT(needed_tiles, 500u);
  EXPECT_LT(all, 2 * needed_tiles);  // not much in vain
}

}  // namespace
}  // namespace scree::grains
