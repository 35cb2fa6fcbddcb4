// What near and far grains share with other meshes: the shadow of swarms on the ground, against rays on the CPU through
// the discs that they are said to cast, and open shells seen from both sides.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "modules/lod/state.h"
#include "shaders/shared/octahedral.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class SwarmShadow : public GlTest {};
class SwarmShell : public GlTest {};

const dvec3 kToSun = glm::normalize(dvec3(0.4, 1, 0.25));
constexpr double kHeight = 8;  // of the swarms' middle over the ground, m

// Grains on a square grid across the light, at random places along it, m from the middle.
std::vector<SwarmGrain> acrossLight(int across, double spacing, float radius, double low, double high) {
  const dvec3 u = glm::normalize(glm::cross(dvec3(0, 0, 1), kToSun)), v = glm::cross(kToSun, u);
  std::vector<SwarmGrain> grains;
  for (int k = 0; k < across * across; ++k) {
    const double along = low + (high - low) * randomUnit(7, static_cast<uint64_t>(k), 0, 0), middle = 0.5 * (across - 1);
    SwarmGrain& grain = grains.emplace_back();
    grain.position = vec3(spacing * (k % across - middle) * u + spacing * (k / across - middle) * v + along * kToSun);
    grain.radius = radius;
  }
  return grains;
}
std::vector<SwarmGrain> joined(std::vector<SwarmGrain> a, const std::vector<SwarmGrain>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// A ground that shows shadows, seen from between it and the swarms.
struct Ground : SwarmScene {
  struct Disc {
    dvec3 center;
    double radius;
  };
  struct Seen {
    size_t dark = 0, lit = 0;  // pixels that the filter's reach leaves no doubt of
    size_t leaked = 0;         // dark ones that the sun reaches
    size_t darkened = 0;       // lit ones that it does not
    double sun = 0;            // mean share of it that dark ones get
  };
  Entity light;
  std::vector<Disc> discs;

  Ground() : SwarmScene({320, 240}) {
    uniformSky(vec3(0.2f));
    world.singleton<ShadowSettings>().side_texels = 1024;
    const Entity floor = put(mesh(sheetMesh()), material(plainMaterial(vec3(0.8f), 0, 1)), {0, 0, 0}, vec3(40));
    world.remove<CastsShadow>(floor);
    light = sun(kToSun);
    const dvec3 shadow = dvec3(0, kHeight, 0) - kHeight / kToSun.y * kToSun;
    look(shadow + dvec3(0, 5, 0.01), shadow, 1.0f);
  }
  uint32_t ball(float cast_share) {
    GrainShape shape = ballShape();
    shape.cast_share = cast_share;
    return world.singleton<SwarmStore>().addShape(std::move(shape));
  }
  void expectRadii(uint32_t shape, std::span<const SwarmGrain> grains) {
    const float share = world.singleton<const SwarmStore>().shape(shape).cast_share;
    for (const SwarmGrain& grain : grains)
      discs.push_back({dvec3(0, kHeight, 0) + dvec3(grain.position), double{grain.radius} * share});
  }
  void hang(uint32_t shape, std::span<const SwarmGrain> grains) {
    world.add(show(shape, grains, dvec3(0, kHeight, 0)), CastsShadow{});
    expectRadii(shape, grains);
  }
  // How far within a disc the sun is from a point of the ground, m; below 0: without.
  double within(dvec3 point) const {
    double most = -1e9;
    for (const Disc& disc : discs) {
      const dvec3 to = disc.center - point;
      most = std::max(most, disc.radius - glm::length(to - glm::dot(to, kToSun) * kToSun));
    }
    return most;
  }
  std::vector<vec3> lit(bool sunny) {
    world.find<Light>(light)->intensity = sunny ? 3 : 0;
    render();
    return radiance();
  }
  // Looks at every `step`th pixel along both axes.
  Seen seen(int step = 1) {
    const std::vector<vec3> shadowed = lit(true);
    const rules::ShadowViewBlock map = world.singleton<const ShadowView>().block;
    std::vector<Entity> casters;
    world.query<With<CastsShadow>, const Swarm>().each([&](Entity e, const Swarm&) { casters.push_back(e); });
    for (const Entity e : casters) world.remove<CastsShadow>(e);
    const std::vector<vec3> unshadowed = lit(true), unlit = lit(false);
    for (const Entity e : casters) world.add(e, CastsShadow{});
    // The filter's square, from its middle to its corners; and the way of the point that is looked up.
    const double reach = std::sqrt(2.0) * double{rules::kShadowFilterTexels * map.texel_m} +
                         double{rules::shadowNormalOffset(vec3(0, 1, 0), map)};
    Seen s;
    for (int y = 0; y < size.y; y += step)
      for (int x = 0; x < size.x; x += step) {
        const Ray ray = rayThrough(*this, {x + 0.5, y + 0.5});
        const double depth = within(ray.origin - ray.origin.y / ray.direction.y * ray.direction);
        if (std::abs(depth) < reach) continue;
        const size_t i = at(x, y);
        const float beam = unshadowed[i].x - unlit[i].x;
        EXPECT_GT(beam, 0.1f);
        const double share = static_cast<double>((shadowed[i].x - unlit[i].x) / beam);
        (depth > 0 ? s.dark : s.lit) += 1;
        s.leaked += depth > 0 && share > 0.01;
        s.darkened += depth < 0 && share < 0.99;
        s.sun += depth > 0 ? share : 0;
      }
    s.sun /= static_cast<double>(std::max<size_t>(s.dark, 1));
    std::printf("%zu dark, %zu lit pixels; leaked %zu, darkened %zu; sun where it is dark %.4f; texel %.4f m\n", s.dark, s.lit,
                s.leaked, s.darkened, s.sun, static_cast<double>(map.texel_m));
    return s;
  }
  // Nothing but what the discs say; `least`: pixels of each kind.
  void expectDiscs(const char* what, size_t least) {
    const Seen s = seen();
    EXPECT_GT(s.dark, least) << what;
    EXPECT_GT(s.lit, least) << what;
    EXPECT_EQ(s.leaked, 0u) << what;
    EXPECT_EQ(s.darkened, 0u) << what;
  }
};

TEST_F(SwarmShadow, OfOneRadiusIsThatOfTheDiscs) {
  for (const float share : {1.0f, 0.6f}) {
    Ground ground;
    ground.world.singleton<ShadowSettings>().side_texels = share < 1 ? 1000 : 1024;  // whole tiles or not
    ground.hang(ground.ball(share), acrossLight(9, 0.45, 0.2f, -1, 1));
    ground.expectDiscs("one radius", 4000);
  }
}

TEST_F(SwarmShadow, LargeGrainsKeepTheirsAmongSmallOnes) {
  Ground ground;
  // Crumbs between the sun and the boulders.
  const std::vector<SwarmGrain> boulders = acrossLight(2, 2.2, 1, -0.2, 0.2), crumbs = acrossLight(28, 0.15, 0.05f, 1.2, 1.8);
  const uint32_t ball = ground.ball(1);
  ground.hang(ball, crumbs);
  ground.expectDiscs("crumbs", 500);
  // The map follows the grains.
  const std::vector<SwarmGrain> mixed = joined(boulders, crumbs);
  ground.discs.clear();
  ground.expectRadii(ball, mixed);
  ground.world.singleton<SwarmStore>().replace(0, mixed);
  ground.expectDiscs("mixed", 4000);
}

TEST_F(SwarmShadow, SwarmsOfOtherSizeAboveLeaveItAsItIs) {
  for (const float crumbs_share : {1.0f, 0.5f}) {
    Ground ground;
    ground.hang(ground.ball(0.7f), acrossLight(5, 0.8, 0.5f, -0.3, 0.3));
    ground.hang(ground.ball(crumbs_share), acrossLight(28, 0.15, 0.06f / crumbs_share, 1.2, 1.8));
    ground.expectDiscs("two swarms", 4000);
  }
}

// Of grains in one cell only one casts: little sun may come through where a heap is dense.
TEST_F(SwarmShadow, DenseHeapsLetHardlyAnySunThrough) {
  for (const float share : {1.0f, 0.62f})
    for (const float least : {0.1f, 0.07f, 0.005f}) {
      Ground ground;
      ground.hang(ground.ball(share), cloud(8000, 1.5f, least, 0.1f));
      std::printf("share %.2f, radii %.3f to 0.1: ", static_cast<double>(share), static_cast<double>(least));
      const Ground::Seen s = ground.seen(4);
      EXPECT_GT(s.dark, 300u);
      EXPECT_GT(s.lit, 300u);
      EXPECT_EQ(s.darkened, 0u);
      EXPECT_LT(s.sun, 0.02);
    }
}

// The upper half of a sphere: from above its outside, from below its inside, against rays.
TEST_F(SwarmShell, OfTwoSidesIsDrawnFromBoth) {
  for (const bool double_sided : {false, true})
    for (const double eye_y : {4.0, -4.0}) {
      SwarmScene scene;
      MaterialData material = plainMaterial(vec3(0.5f), 0, 0.5f);
      material.double_sided = double_sided;
      MeshData dome = sphereMesh(40, 80);
      dome.indices.resize(dome.indices.size() / 2);
      computeBounds(dome);
      dome.material = static_cast<int>(scene.material(material));
      GrainShape shape;
      shape.name = "dome";
      ASSERT_TRUE(addLevels(scene.world.singleton<MeshStore>(), shape, std::span(&dome, 1)).ok());
      // Grains are turned: this one about the line of sight.
      SwarmGrain grain;
      grain.rotation = glm::angleAxis(1.0f, vec3(0, 1, 0));
      const Entity entity = scene.show(scene.world.singleton<SwarmStore>().addShape(shape), std::span(&grain, 1));
      scene.look({0, eye_y, 0.01}, {0, 0, 0});
      scene.render();
      const std::vector<uint32_t> ids = scene.ids();
      const auto drawn = static_cast<size_t>(std::count(ids.begin(), ids.end(), entity.index + 1));
      if (eye_y < 0 && !double_sided) {
        EXPECT_EQ(drawn, 0u);
        continue;
      }
      EXPECT_GT(drawn, 3000u);
      const std::vector<uint8_t> normals = gpu::readBytes(scene.app.frame().texture(kGbufferNormal), 4);
      for (int y = 0; y < scene.size.y; ++y)
        for (int x = 0; x < scene.size.x; ++x) {
          const size_t i = scene.at(x, y);
          if (ids[i] == 0) continue;
          const Ray ray = rayThrough(scene, {x + 0.5, y + 0.5});
          const double along = -glm::dot(ray.origin, ray.direction);
          const double half = std::sqrt(std::max(1 - glm::dot(ray.origin, ray.origin) + along * along, 0.0));
          // From below what is nearer has been cut off.
          const dvec3 p = ray.origin + (eye_y > 0 ? along - half : along + half) * ray.direction;
          if (half < 0.3) continue;  // near the silhouette facets show
          const vec3 code(normals[4 * i], normals[4 * i + 1], normals[4 * i + 2]);
          const dvec3 normal(rules::octDecode(rules::octUnpack24(code / 255.0f)));
          ASSERT_GT(glm::dot(normal, eye_y > 0 ? p : -p), 0.995) << eye_y << ": " << x << ", " << y;
        }
    }
}

}  // namespace
}  // namespace scree::test
