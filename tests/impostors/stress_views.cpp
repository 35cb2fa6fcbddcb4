// No bean that a pixel shows without culling is missing with it, over thousands of random and hostile views, whatever
// the frame before knew.
#include <algorithm>
#include <array>
#include <cmath>

#include "modules/impostors/impostors.h"
#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"
#include "tests/support/exact_sphere.h"

namespace scree::test {
namespace {

class ImpostorsStress : public GlTest {};

struct Tally {
  size_t views = 0, pictures = 0, pixels = 0, ties = 0;
  size_t in_view = 0, hidden = 0;  // grains
  size_t falsely_hidden = 0, falsely_outside = 0, odd = 0;
};

struct BeanViews : SwarmScene {
  std::vector<SwarmGrain> grains;
  double fov_y = 1;

  explicit BeanViews(ivec2 output) : SwarmScene(output) {
    addImpostors(app);
    for (const std::string_view unused : {kGbufferMotion, kGbufferId, kRadiance}) app.frame().keep(unused, false);
  }
  uint32_t addBean() {
    Result<uint32_t> shape = loadGrainShape(world, std::string(SCREE_SOURCE_DIR) + "/content/models/coffee_bean.glb",
                                            {.edge = 5, .texels = 32, .directions = 2},
                                            std::string(SCREE_BINARY_DIR) + "/bean_stress.impostor");
    EXPECT_TRUE(shape.ok());
    return shape.ok() ? *shape : 0;
  }
  LodSettings& settings() { return world.singleton<LodSettings>(); }
  void aim(dvec3 from, dvec3 way, double fov, double near_m, double roll = 0) {
    look(from, from + way, static_cast<float>(fov), static_cast<float>(near_m));
    world.find<Transform>(camera)->rotation = lookingAlong(way, roll);
    *world.find<PreviousTransform>(camera) = previousOf(*world.find<Transform>(camera));
    fov_y = static_cast<double>(static_cast<float>(fov));
  }
  // Which grain each pixel shows, + 1.
  std::vector<uint32_t> shown(bool cull) {
    settings().cull = cull;
    render();
    return gpu::readUints(app.frame().texture(kSwarmVisible), 1);
  }
  // The grains as they are stored: in an order of their own, radii rounded.
  void takeStored() {
    const SwarmStore::Stored& stored = world.singleton<const SwarmStore>().swarm(0);
    for (size_t k = 0; k < grains.size(); ++k) {
      const rules::SwarmRecord& record = stored.chunks[0][k];
      grains[k].position = vec3(record.x, record.y, record.z);
      grains[k].radius = rules::radiusOf(record.size, stored.largest_radius);
    }
  }
  // Whether the outer sphere reaches into the view, by more than rounding; in double precision.
  bool isInView(const SwarmGrain& grain) {
    const Transform& eye = *world.peek<Transform>(camera);
    const dvec3 v = glm::conjugate(glm::normalize(glm::dquat(eye.rotation))) * (dvec3(grain.position) - eye.position);
    const double tan_y = std::tan(0.5 * fov_y), tan_x = tan_y * size.x / size.y, radius = static_cast<double>(grain.radius);
    const double inside = 1e-5 * glm::length(v) - radius;
    for (const auto& [across, tan] : {std::pair(v.x, tan_x), std::pair(v.y, tan_y)})
      for (const double side : {1.0, -1.0})
        if ((side * across - tan * v.z) / std::sqrt(1 + tan * tan) < inside) return false;
    return -v.z - static_cast<double>(world.peek<Camera>(camera)->near_m) >= inside;
  }
};

// A picture, and how each grain was drawn for it.
struct Seen {
  std::vector<uint32_t> shown, routes;
};

// Of the same view with and without culling.
void compare(const Seen& with, const Seen& without, Tally& tally) {
  const std::vector<uint32_t>&culled = with.shown, &all = without.shown;
  ++tally.pictures;
  tally.pixels += all.size();
  for (size_t p = 0; p < all.size(); ++p) {
    if (culled[p] == all[p]) continue;
    if (all[p] == 0) ++tally.odd;
    else if (with.routes[all[p] - 1] == rules::kNotDrawn) ++tally.falsely_hidden;
    // Both were drawn, at the same depth as far as it is rounded: which was first is another matter.
    else ++tally.ties;
  }
  for (size_t g = 0; g < with.routes.size(); ++g) {
    const bool in_view = without.routes[g] != rules::kNotDrawn, drawn = with.routes[g] != rules::kNotDrawn;
    tally.in_view += in_view;
    tally.hidden += in_view && !drawn;
    tally.odd += drawn && !in_view;
  }
}

// View number k of the scene: nothing that it shares with the one before but the grains.
void jump(BeanViews& scene, Random& random, int k, double extent) {
  const SwarmGrain& some = scene.grains[static_cast<size_t>(random.unit() * static_cast<float>(scene.grains.size() - 1))];
  const dvec3 at(some.position), way = random.direction();
  const double radius = static_cast<double>(some.radius), unit = static_cast<double>(random.unit());
  const double near_m = extent * std::exp(-2 - 7 * static_cast<double>(random.unit()));
  const double fov = 0.3 + 1.3 * static_cast<double>(random.unit()), roll = 6 * static_cast<double>(random.unit());
  switch (k % 7) {
    case 0:  // from outside, towards the middle
      return scene.aim(-way * extent * (1.2 + 3 * unit), way, fov, near_m, roll);
    case 1:  // from anywhere between them
      return scene.aim(random.direction() * extent * unit, way, fov, near_m, roll);
    case 2:  // from within a grain, or its surface
      return scene.aim(at - way * radius * (k % 2 == 0 ? unit : 1.0), way, fov, near_m);
    case 3:  // a grain touches the near plane, give or take rounding
      return scene.aim(at - way * (radius + near_m * (1 + 2e-7 * (unit - 0.5))), way, fov, near_m);
    case 4: {  // from up to 1e5 of the largest radii away, through a narrow lens
      const double away = extent * std::pow(10, 1 + 3 * unit);
      return scene.aim(-way * away, way, 2 * extent / away, near_m);
    }
    case 5: {  // along the surface
      const dvec3 out = random.direction(), along = glm::normalize(glm::cross(out, way));
      return scene.aim(out * extent * 1.02 - along * extent * 1.5 * unit, along - 0.05 * out, fov, near_m, roll);
    }
    default:  // very wide
      return scene.aim(way * extent * unit, random.direction(), 2.2 + 0.8 * unit, near_m, roll);
  }
}

void runView(BeanViews& scene, Random& random, int k, double extent, Tally& tally) {
  jump(scene, random, k, extent);
  ++tally.views;
  const auto draw = [&](bool cull) {
    std::vector<uint32_t> shown = scene.shown(cull);
    return Seen{std::move(shown), scene.routes()};
  };
  const Seen first = draw(true);
  // A frame that knows what the last one showed: of the same view, or of one nearby.
  if (k % 3 == 0) {
    compare(first, draw(false), tally);
    Transform& eye = *scene.world.find<Transform>(scene.camera);
    eye.position += random.direction() * extent * 0.04;
    *scene.world.find<PreviousTransform>(scene.camera) = previousOf(eye);
  }
  const Seen second = draw(true), all = draw(false);
  if (k % 3 != 0) compare(first, all, tally);
  compare(second, all, tally);
  for (size_t g = 0; g < all.routes.size(); ++g)
    tally.falsely_outside += all.routes[g] == rules::kNotDrawn && scene.isInView(scene.grains[g]);
}

TEST_F(ImpostorsStress, NoBeanIsHiddenFalselyInThousandsOfViews) {
  Random random(31);
  Tally tally;
  // Sizes change seldom: each change makes all targets anew.
  for (const ivec2 size : {ivec2(1, 1), ivec2(2, 3), ivec2(17, 31), ivec2(33, 7), ivec2(64, 48), ivec2(61, 45), ivec2(1, 40), ivec2(80, 50)}) {
    BeanViews scene(size);
    const uint32_t bean = scene.addBean();
    for (int cloud_number = 0; cloud_number < 16; ++cloud_number) {
      const float extent = std::exp(random.between(-2, 4)), spread = cloud_number % 3 == 0 ? 1.01f : cloud_number % 3 == 1 ? 5.0f : 20.0f;
      const float least = 0.2f / std::sqrt(spread) * extent;
      scene.grains = cloud(1500, 0.7f * extent, least, least * spread, random.drawn);
      if (cloud_number == 0) scene.show(bean, scene.grains);
      else scene.world.singleton<SwarmStore>().replace(0, scene.grains);
      scene.takeStored();
      // As impostors, by size, and as meshes. Without hysteresis, or the picture depends on what was culled before.
      scene.settings().only = cloud_number % 4 != 3 ? rules::kImpostor : cloud_number == 7 ? rules::kMesh + 1 : rules::kNotDrawn;
      scene.settings().band = 0;
      for (int k = 0; k < 42; ++k) {
        runView(scene, random, k, static_cast<double>(extent), tally);
        ASSERT_EQ(tally.falsely_hidden + tally.falsely_outside + tally.odd, 0u)
            << "size " << size.x << " x " << size.y << ", cloud " << cloud_number << ", view " << k;
      }
    }
  }
  std::printf("%zu views, %zu pictures of %zu pixels in all; of %zu grains in view %.1f %% culled, 0 of them falsely; %zu pixels with ties\n",
              tally.views, tally.pictures, tally.pixels, tally.in_view,
              100 * static_cast<double>(tally.hidden) / static_cast<double>(tally.in_view), tally.ties);
  EXPECT_GE(tally.views, 5000u);
  EXPECT_GT(tally.hidden, tally.in_view / 4);
  EXPECT_LT(tally.ties, tally.pixels / 50'000);
}

}  // namespace
}  // namespace scree::test
