// Culling never changes a pixel, over thousands of random and hostile views; and how much it culls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/occlusion/stage.h"

namespace scree::test {
namespace {

class OcclusionStress : public GlTest {};

// A cloud of spheres with radii 1 : `spread`; they may overlap, and the eye may be inside.
std::vector<vec4> cloud(Random& random, int count, float spread, float extent) {
  std::vector<vec4> all;
  const float least = 0.6f * extent / std::cbrt(static_cast<float>(count)) / std::sqrt(spread);
  for (int k = 0; k < count; ++k)
    all.push_back(vec4(vec3(random.direction()) * extent * std::cbrt(random.unit()),
                       least * std::exp(random.between(0, std::log(spread)))));
  return all;
}

struct Tally {
  int views = 0;
  uint64_t hidden = 0, tested = 0;
};

// Draws the view with and without culling: the same order of draws, so ties fall the same way.
void expectSamePicture(Discs& discs, ivec2 size, Tally& tally) {
  discs.cull = false;
  const std::vector<uint32_t> all = discs.ids(size);
  discs.cull = true;
  for (const Discs::Test test : {Discs::Test::Disc, Discs::Test::Sphere}) {
    discs.test = test;
    const std::vector<uint32_t> culled = discs.ids(size);
    if (culled != all) {
      const size_t at = static_cast<size_t>(std::mismatch(all.begin(), all.end(), culled.begin()).first - all.begin());
      const Transform& t = *discs.world.peek<Transform>(discs.camera);
      ADD_FAILURE() << "view " << tally.views << ", pixel " << at << " of " << size.x << " x " << size.y << ": sphere "
                    << all[at] << " became " << culled[at] << "; camera at " << t.position.x << ", " << t.position.y
                    << ", " << t.position.z;
      return;
    }
  }
  for (const uint32_t hidden : discs.hidden()) tally.hidden += hidden;
  tally.tested += static_cast<uint64_t>(discs.count);
  ++tally.views;
}

TEST_F(OcclusionStress, IdsAreTheSameInThousandsOfViews) {
  Random random(21);
  Discs discs;
  Tally tally;
  // Sizes change seldom: each change makes all targets anew.
  for (const ivec2 size : {ivec2(96, 64), ivec2(61, 107), ivec2(160, 33), ivec2(17, 31)}) {
    for (int scene = 0; scene < 20; ++scene) {
      const float extent = std::exp(random.between(-2, 4));
      const float spread = scene % 3 == 0 ? 1.01f : scene % 3 == 1 ? 5.0f : 20.0f;
      const std::vector<vec4> all = cloud(random, 2000, spread, extent);
      discs.setSpheres(all, 200 + 300 * (scene % 4));
      for (int k = 0; k < 30; ++k) {
        const vec4 some = all[static_cast<size_t>(random.between(0, 1999.9f))];
        const dvec3 at = dvec3(vec3(some));
        const double radius = some.w;
        const float fov = random.between(0.3f, 1.6f), near = extent * std::exp(random.between(-9, -2));
        const dvec3 way = random.direction();
        switch (k % 6) {
          case 0:  // from outside, towards the middle
            discs.look(way * (double)extent * (double)random.between(1.2f, 4), -way, fov, near, random.between(-3, 3));
            break;
          case 1:  // from anywhere in it
            discs.look(random.direction() * (double)extent * (double)random.unit(), way, fov, near);
            break;
          case 2:  // from inside a sphere, or from its surface
            discs.look(at - way * radius * (k % 4 ? (double)random.unit() : 1.0), way, fov, near);
            break;
          case 3:  // a sphere touches the near plane, give or take rounding
            discs.look(at - way * (radius + (double)near * (1 + 1e-7 * (double)random.between(-2, 2))), way, fov, near);
            break;
          case 4:  // from afar, through a narrow lens: positions are rounded to pixels and to radii
            discs.look(-way * (double)extent * std::exp((double)random.between(2, 14)), way, 0, near);
            discs.world.find<Camera>(discs.camera)->fov_y_rad =
                2 * extent / static_cast<float>(glm::length(discs.world.peek<Transform>(discs.camera)->position));
            break;
          default:  // very wide
            discs.look(way * (double)extent * (double)random.unit(), random.direction(), random.between(2.2f, 3.0f), near,
                       random.between(-3, 3));
        }
        expectSamePicture(discs, size, tally);
        if (HasFailure()) return;
      }
    }
  }
  std::printf("%d views, %.1f %% of the spheres hidden\n", tally.views, 100.0 * (double)tally.hidden / (double)tally.tested);
  EXPECT_EQ(tally.views, 4 * 20 * 30);
  EXPECT_GT(tally.hidden, tally.tested / 5);
}

// No view knows anything of the one before.
TEST_F(OcclusionStress, TeleportsShowTheFirstFrameWhole) {
  Random random(22);
  const ivec2 size(96, 64);
  const std::vector<vec4> all = cloud(random, 3000, 4, 10);
  Discs discs, fresh;
  discs.setSpheres(all, 400);
  for (int k = 0; k < 200; ++k) {
    const dvec3 way = random.direction(), from = random.direction() * (double)random.between(0, 25);
    discs.look(from, way, 0.9f, 0.01f);
    const std::vector<uint32_t> moved = discs.ids(size);
    fresh.setSpheres(all, 3000);  // all drawn before the pyramid: nothing can be missing
    fresh.cull = false;
    fresh.look(from, way, 0.9f, 0.01f);
    ASSERT_EQ(moved, fresh.ids(size)) << k;
  }
}

// ---- How much is culled --------------------------------------------------------------------------

// A cone of grains, packed like shaken face-centred cubes (58 % full), 163,000 of 7.6 mm.
std::vector<vec4> heap() {
  Random random(3);
  const float radius = 0.0076f, step = radius * 2.34f * 0.7071f;
  std::vector<vec4> all;
  const int side = static_cast<int>(1 / step) + 1, height = static_cast<int>(0.6f / step);
  for (int z = 0; z <= height; ++z)
    for (int y = -side; y <= side; ++y)
      for (int x = -side; x <= side; ++x) {
        if ((x + y + z) & 1) continue;
        const vec3 shake(random.unit() - 0.5f, random.unit() - 0.5f, random.unit() - 0.5f);
        const vec3 p = vec3(x, z, y) * step + shake * (0.25f * radius);
        if (std::hypot(p.x, p.z) < 1 - p.y / 0.6f) all.push_back(vec4(p, radius));
      }
  return all;
}

// Those first that win their cell of a map of cells `cell_px` wide: the nearest centre of each.
int candidatesFirst(std::vector<vec4>& all, const ExactView& view, dvec3 eye, ivec2 size, double cell_px) {
  const ivec2 cells(static_cast<int>(size.x / cell_px) + 1, static_cast<int>(size.y / cell_px) + 1);
  std::vector<int> winner(static_cast<size_t>(cells.x * cells.y), -1);
  std::vector<double> distance(all.size());
  for (size_t k = 0; k < all.size(); ++k) {
    const dvec3 c = dvec3(vec3(all[k])) - eye;
    const double w = glm::dot(view.forward, c);
    distance[k] = glm::length(c);
    const dvec2 px = view.center + view.scale * dvec2(glm::dot(view.right, c), glm::dot(view.up, c)) / w;
    if (w <= 0 || px.x < 0 || px.y < 0 || px.x >= size.x || px.y >= size.y) continue;
    int& won = winner[static_cast<size_t>(static_cast<int>(px.y / cell_px) * cells.x + static_cast<int>(px.x / cell_px))];
    if (won < 0 || distance[k] < distance[static_cast<size_t>(won)]) won = static_cast<int>(k);
  }
  std::vector<char> first(all.size(), 0);
  for (const int k : winner)
    if (k >= 0) first[static_cast<size_t>(k)] = 1;
  std::vector<vec4> sorted;
  for (const bool wanted : {true, false})
    for (size_t k = 0; k < all.size(); ++k)
      if (static_cast<bool>(first[k]) == wanted) sorted.push_back(all[k]);
  all = std::move(sorted);
  return static_cast<int>(std::count(first.begin(), first.end(), 1));
}

TEST_F(OcclusionStress, MostOfAHeapsHiddenGrainsAreCulled) {
  const ivec2 size(1280, 720);
  const std::vector<vec4> grains = heap();
  EXPECT_NEAR(static_cast<double>(grains.size()), 163000, 2000);
  Discs discs;
  struct Seen {
    const char* name;
    dvec3 eye, at;
    double radius_px;  // of a typical grain
  };
  for (const Seen& seen : {Seen{"farther", {0, 2.6, -5.3}, {0, 0.2, 0}, 1.1}, Seen{"far", {0, 1.1, -2.2}, {0, 0.2, 0}, 2.7},
                           Seen{"near", {0, 0.6, -0.95}, {0, 0.25, 0}, 5.9},
                           Seen{"grazing", {0, 0.12, -1.05}, {0, 0.15, 0}, 6.3}})
    for (const double cell : {0.35, 0.7, 1.0}) {
      std::vector<vec4> all = grains;
      discs.look(seen.eye, seen.at - seen.eye, 0.785398f, 0.01f);
      discs.setSpheres(all, 1);
      discs.ids(size);
      const View view = discs.world.singleton<const View>();
      const int first = candidatesFirst(all, ExactView(view), view.position, size, std::max(1.0, cell * seen.radius_px));
      discs.setSpheres(all, first);
      discs.cull = false;
      const std::vector<uint32_t> ids = discs.ids(size);
      std::vector<char> visible(all.size(), 0);
      for (const uint32_t id : ids)
        if (id) visible[id - 1] = 1;
      discs.cull = true;
      discs.test = Discs::Test::Disc;
      EXPECT_EQ(discs.ids(size), ids);
      const std::vector<uint32_t> flags = discs.hidden();
      size_t in_view = 0, shown = 0, hidden = 0, rest_hidden = 0, culled = 0;
      for (size_t k = 0; k < all.size(); ++k) {
        if (!sphereInView(view, discs.origin() + vec3(all[k]), all[k].w)) continue;
        ++in_view;
        shown += static_cast<size_t>(visible[k]);
        hidden += !visible[k];
        if (k < static_cast<size_t>(first)) continue;
        rest_hidden += !visible[k];
        culled += flags[k];
        EXPECT_FALSE(flags[k] && visible[k]);
      }
      std::printf("%-8s cells of %.2f r: %zu in view, %zu visible, %d drawn first; of %zu hidden among the rest "
                  "%.1f %% culled (%.1f %% of all hidden)\n",
                  seen.name, cell, in_view, shown, first, rest_hidden, 100.0 * (double)culled / (double)rest_hidden,
                  100.0 * (double)culled / (double)hidden);
      EXPECT_GT((double)culled, 0.95 * (double)rest_hidden) << seen.name;
      // Small cells win many hidden grains, which are then drawn in vain.
      EXPECT_GT((double)culled, (cell > 0.9 ? 0.85 : cell > 0.5 ? 0.75 : 0.4) * (double)hidden) << seen.name;
    }
}

}  // namespace
}  // namespace scree::test
