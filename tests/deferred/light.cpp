// Shading at every pixel against the rules on the CPU, and shadows against rays in double precision.
#include <algorithm>
#include <limits>

#include "engine/core/random.h"
#include "modules/deferred/lobe_table.h"
#include "modules/deferred/material_block.h"
#include "shaders/shared/brdf.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/octahedral.h"
#include "shaders/shared/tonemap.h"
#include "tests/deferred/studio.h"
#include "tests/support/image_expect.h"

namespace scree::test {
namespace {

using glm::dvec2;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

class Light_ : public GlTest {};
using DeferredLight = Light_;
using DeferredShadow = Light_;
using DeferredHostile = Light_;

void castNothing(Studio& s) {
  std::vector<Entity> all;
  s.world.query<const MeshInstance>().each([&](Entity e, const MeshInstance&) { all.push_back(e); });
  for (const Entity e : all) s.world.remove<CastsShadow>(e);
}

// ---- shading

TEST_F(DeferredLight, FollowsTheRulesAtEveryPixel) {
  Studio s({161, 101});
  const uint32_t ball = s.mesh(sphereMesh());
  for (int i = 0; i < 12; ++i) {
    MaterialData m = plainMaterial(vec3(0.9f, 0.5f, 0.1f * static_cast<float>(i % 4)), 0.5f * static_cast<float>(i % 3),
                                   static_cast<float>(i) / 11);
    if (i == 5) m.emissive = vec3(0.3f, 0, 7);
    s.put(ball, s.material(m), {i % 4 * 2.2 - 3.3, i / 4 * 2.2 - 2.2, 0});
  }
  s.put(s.mesh(sheetMesh()), s.material(plainMaterial(vec3(0.4f), 0, 0.8f)), {0, -3.4, 0}, vec3(9));
  castNothing(s);
  s.sun({0.5, 0.7, 0.6}, vec3(1, 0.9f, 0.7f), 4);
  s.look({1, 1.5, 11}, {0, -0.5, 0});
  s.render();

  const auto albedo = gpu::readBytes(s.app.frame().texture(kGbufferAlbedo), 4);
  const auto normal = gpu::readBytes(s.app.frame().texture(kGbufferNormal), 4);
  const auto emissive = s.floats(kGbufferEmissive, 3), depth = s.floats(kGbufferDepth, 1);
  const auto radiance = s.radiance();
  const auto table = makeLobeTable();
  const Sky& sky = s.world.singleton<const Sky>();
  const auto polynomial = rules::skyPolynomial(sky.zenith, sky.horizon, sky.ground);
  const Sun sun = s.world.singleton<const Sun>();
  double worst = 0;
  int lit = 0;
  for (int y = 0; y < s.size.y; ++y)
    for (int x = 0; x < s.size.x; ++x) {
      const size_t i = s.at(x, y);
      const Ray ray = rayThrough(s, dvec2(x + 0.5, y + 0.5));
      vec3 expected = rules::skyRadiance(polynomial, static_cast<float>(ray.direction.y));
      if (depth[i] > 0) {
        const auto byte = [&](const std::vector<uint8_t>& v, size_t k) { return static_cast<float>(v[4 * i + k]) / 255; };
        const vec3 base = rules::albedoFromCode({byte(albedo, 0), byte(albedo, 1), byte(albedo, 2)});
        const vec3 n = rules::octDecode(rules::octUnpack24({byte(normal, 0), byte(normal, 1), byte(normal, 2)}));
        const vec3 v(-ray.direction);
        const float n_v = glm::clamp(glm::dot(n, v), 1e-4f, 1.0f), roughness = std::max(byte(normal, 3), rules::kMinRoughness);
        const auto lobe = sampleLobeTable(table, n_v, roughness);
        const auto r = rules::reflectance(base, rules::metallicFromCode(byte(albedo, 3)), lobe.a, lobe.b);
        expected = vec3(emissive[3 * i], emissive[3 * i + 1], emissive[3 * i + 2]) +
                   rules::reflectSky(polynomial, r, lobe, n, v, n_v, roughness, vec2(n.y, n.y * n.y)) +
                   rules::reflectBeam(r, n, v, sun.to_sun, glm::dot(n, sun.to_sun), n_v, rules::alphaFromRoughness(roughness)) * sun.irradiance;
        expected = glm::min(expected, vec3(rules::kMaxRadiance));
        ++lit;
      }
      for (int k = 0; k < 3; ++k) {
        const double error = std::abs(radiance[i][k] - expected[k]) / (0.05 + expected[k]);
        worst = std::max(worst, error);
        // Half floats keep 11 bits; the core of a narrow highlight loses more (see brdf.h).
        EXPECT_LT(error, expected[k] > 10 ? 0.01 : 0.0015) << x << " " << y << " channel " << k << ": " << radiance[i][k] << " " << expected[k];
      }
    }
  std::printf("worst relative difference of %d lit pixels: %.2e\n", lit, worst);
  EXPECT_GT(lit, 5000);
}

// The display is the tone-mapped radiance, at every pixel, for any exposure.
TEST_F(DeferredLight, PresentsTheToneMappedRadiance) {
  Studio s({80, 60});
  s.put(s.mesh(sphereMesh()), s.material(plainMaterial(vec3(0.9f, 0.4f, 0.1f), 1, 0.2f)), {0, 0, 0});
  s.sun({1, 1, 1}, vec3(1), 20);
  s.look({0, 0, 4}, {0, 0, 0});
  for (const float exposure : {1.0f, 0.1f, 5.0f}) {
    s.world.singleton<Exposure>().scale = exposure;
    s.render();
    const auto radiance = s.radiance();
    const auto shown = gpu::readBytes(s.app.frame().texture(Frame::kOutput), 4);
    for (size_t i = 0; i < radiance.size(); ++i) {
      const vec3 expected = rules::srgbFromLinear(rules::toneMap(radiance[i] * exposure)) * 255.0f;
      for (size_t k = 0; k < 3; ++k) ASSERT_NEAR(shown[4 * i + k], expected[static_cast<int>(k)], 0.52) << i;
      ASSERT_EQ(shown[4 * i + 3], 255);
    }
  }
}

// Without the detour over the radiance target, which rounds to half floats, the picture is the same.
TEST_F(DeferredLight, ShowsTheSameAtOnce) {
  Studio s({80, 60});
  s.put(s.mesh(sphereMesh()), s.material(plainMaterial(vec3(0.9f, 0.4f, 0.1f), 1, 0.2f)), {0, 0, 0});
  s.put(s.mesh(boxMesh()), 0, {0, -2, 0}, vec3(3, 1, 3));
  s.sun({1, 1, 1}, vec3(1), 20);
  s.look({0, 1, 4}, {0, 0, 0});
  s.world.singleton<Exposure>().scale = 0.7f;
  const auto picture = [&s](bool keeping) {
    s.app.frame().keep(kRadiance, keeping);
    s.render();
    return gpu::readBytes(s.app.frame().texture(Frame::kOutput), 4);
  };
  const auto over_radiance = picture(true), at_once = picture(false);
  EXPECT_EQ(s.app.frame().runCount("deferred.display_light"), 1u);
  EXPECT_EQ(s.app.frame().runCount("deferred.present"), 1u);
  ASSERT_EQ(over_radiance.size(), at_once.size());
  EXPECT_GT(*std::max_element(at_once.begin(), at_once.end() - 1), 200);
  size_t different = 0, dark = 0;
  for (size_t i = 0; i < at_once.size(); ++i) {
    dark += at_once[i] < 128;
    ASSERT_NEAR(at_once[i], over_radiance[i], 1) << i;
    different += at_once[i] != over_radiance[i];
  }
  // Half floats move a value by up to 1/4096 of itself, 1/16 of a step of 8 bits.
  EXPECT_LT(different, at_once.size() / 16);
  EXPECT_GT(dark, at_once.size() / 16);
}

TEST_F(DeferredLight, TheFirstDirectionalLightIsTheSun) {
  Studio s({16, 16});
  s.look({0, 0, 4}, {0, 0, 0});
  s.render();
  EXPECT_FALSE(s.world.singleton<const Sun>().present);
  const Entity a = s.sun({0, 1, 0}, vec3(1, 0.5f, 0.25f), 2);
  const Entity b = s.sun({1, 0, 0}, vec3(1), 9);
  s.render();
  EXPECT_EQ(s.world.singleton<const Sun>().irradiance, vec3(2, 1, 0.5f));
  EXPECT_NEAR(s.world.singleton<const Sun>().to_sun.y, 1, 1e-6);
  s.world.find<Light>(a)->intensity = 0;
  s.render();
  EXPECT_NEAR(s.world.singleton<const Sun>().to_sun.x, 1, 1e-6);
  s.world.find<Light>(b)->kind = LightKind::Point;
  s.render();
  EXPECT_FALSE(s.world.singleton<const Sun>().present);
}

// ---- shadows

struct Box {
  dvec3 center, half;
};
bool hits(const Box& box, dvec3 origin, dvec3 direction) {
  double near = 1e-6, far = 1e30;
  for (int k = 0; k < 3; ++k) {
    const double a = (box.center[k] - box.half[k] - origin[k]) / direction[k];
    const double b = (box.center[k] + box.half[k] - origin[k]) / direction[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

// How much of the sun arrives at every pixel, from three renderings: shadowed, unshadowed, dark.
std::vector<double> visibility(Studio& s, Entity sun) {
  s.render();
  const auto with = s.radiance();
  const float lux = s.world.peek<Light>(sun)->intensity;
  s.world.find<Light>(sun)->intensity = 0;
  s.render();
  const auto dark = s.radiance();
  s.world.find<Light>(sun)->intensity = lux;
  std::vector<Entity> casters;
  s.world.query<With<CastsShadow>, const MeshInstance>().each([&](Entity e, const MeshInstance&) { casters.push_back(e); });
  for (const Entity e : casters) s.world.remove<CastsShadow>(e);
  s.render();
  const auto unshadowed = s.radiance();
  for (const Entity e : casters) s.world.add<CastsShadow>(e);
  std::vector<double> result(with.size());
  for (size_t i = 0; i < with.size(); ++i) {
    const double beam = unshadowed[i].x - dark[i].x;
    result[i] = beam < 0.02 ? -1 : (with[i].x - dark[i].x) / beam;
  }
  return result;
}

// Two boxes on and over a floor: away from shadow edges every floor pixel is as the ray says, for
// high and low suns. The width of the zone around edges that is left out is the claim.
TEST_F(DeferredShadow, AgreeWithRaysAwayFromEdges) {
  const Box boxes[] = {{{-0.8, 0.5, 0.2}, {0.4, 0.5, 0.3}}, {{0.9, 1.4, -0.3}, {0.3, 0.1, 0.5}}};
  int index = 0;
  for (const dvec3 to_sun : {dvec3(0.1, 1, 0.05), dvec3(1, 1, 0.5), dvec3(-1, 0.7, 0.3), dvec3(0.3, 0.25, -1)}) {
    Studio s({240, 160});
    const uint32_t box = s.mesh(boxMesh()), matte = s.material(plainMaterial(vec3(0.8f), 0, 1));
    const Entity floor = s.put(s.mesh(sheetMesh()), matte, {0, 0, 0}, vec3(6));
    s.world.remove<CastsShadow>(floor);
    for (const Box& b : boxes) s.put(box, matte, b.center, vec3(b.half));
    const Entity sun = s.sun(to_sun);
    s.look({0, 4, 4.5}, {0, 0.2, -0.3});
    const auto seen = visibility(s, sun);
    s.render();
    const auto ids = s.ids();
    const auto& view = s.world.singleton<const ShadowView>().block;
    const dvec3 l = glm::normalize(to_sun);
    // Filter and normal offset, stretched over the floor by the sun's height.
    const double zone = view.texel_m * (3 + 3) / l.y;
    int lit = 0, dark = 0, left_out = 0;
    for (int y = 0; y < s.size.y; ++y)
      for (int x = 0; x < s.size.x; ++x) {
        const size_t i = s.at(x, y);
        if (ids[i] != floor.index + 1 || seen[i] < -0.5) continue;
        const Ray ray = rayThrough(s, dvec2(x + 0.5, y + 0.5));
        const dvec3 hit = ray.origin - ray.direction * (ray.origin.y / ray.direction.y);
        int blocked = 0;
        for (int k = 0; k < 16; ++k) {
          const double a = k * 0.39269908169872414;
          const dvec3 p = hit + zone * dvec3(std::cos(a), 0, std::sin(a));
          blocked += hits(boxes[0], p, l) || hits(boxes[1], p, l) ? 1 : 0;
        }
        if (blocked != 0 && blocked != 16) {
          ++left_out;
          continue;
        }
        (blocked == 0 ? lit : dark) += 1;
        EXPECT_NEAR(seen[i], blocked == 0 ? 1 : 0, 0.01) << "sun " << index << " pixel " << x << " " << y;
      }
    std::printf("sun %d: texel %.4f m, %d lit, %d dark, %d left out\n", index++, view.texel_m, lit, dark, left_out);
    EXPECT_GT(lit, 5000);
    EXPECT_GT(dark, 200);
    EXPECT_LT(left_out, 5000);
  }
}

// No surface that faces the sun shadows itself: planes at many angles, and balls away from the
// terminator, where facets end.
TEST_F(DeferredShadow, NoAcne) {
  double darkest = 2;
  for (uint64_t k = 0; k < 12; ++k) {
    Studio s({160, 120});
    const uint32_t matte = s.material(plainMaterial(vec3(0.8f), 0, 1));
    const auto r = [&](uint64_t d) { return 2.0 * randomUnit(21, k, 0, d) - 1; };
    const dvec3 to_sun(1.5 * r(0), 0.3 + 0.7 * std::abs(r(1)), 1.5 * r(2));
    if (k % 2 == 0)
      s.put(s.mesh(sheetMesh()), matte, {0, 0, 0}, vec3(4), glm::angleAxis(static_cast<float>(0.6 * r(3)), glm::normalize(vec3(1, 0, 0.3f))));
    else
      s.put(s.mesh(sphereMesh(96, 192)), matte, {0, 0, 0}, vec3(1.5f));
    const Entity sun = s.sun(to_sun);
    s.look({0, 4, 4}, {0, 0, 0});
    const auto seen = visibility(s, sun);
    const auto normal = gpu::readBytes(s.app.frame().texture(kGbufferNormal), 4);
    const auto ids = s.ids();
    const vec3 l = s.world.singleton<const Sun>().to_sun;
    for (size_t i = 0; i < seen.size(); ++i) {
      if (ids[i] == 0 || seen[i] < -0.5) continue;
      const vec3 n = rules::octDecode(rules::octUnpack24(vec3(normal[4 * i], normal[4 * i + 1], normal[4 * i + 2]) / 255.0f));
      if (glm::dot(n, l) < (k % 2 == 0 ? 0.02f : 0.12f)) continue;
      darkest = std::min(darkest, seen[i]);
      EXPECT_GT(seen[i], 0.99) << k << " pixel " << i;
    }
  }
  std::printf("darkest lit pixel: %.4f of the sun\n", darkest);
}

TEST_F(DeferredShadow, FallOnWhatLiesFarBelowAndOutsideTheMap) {
  Studio s({120, 90});
  const uint32_t matte = s.material(plainMaterial(vec3(0.8f), 0, 1));
  const Entity floor = s.put(s.mesh(sheetMesh()), matte, {0, -40, 0}, vec3(200));
  s.world.remove<CastsShadow>(floor);
  s.put(s.mesh(boxMesh()), matte, {0, 0, 0}, vec3(3, 0.1f, 3));
  const Entity sun = s.sun({0.4, 1, 0});
  s.look({-16, -10, 0}, {-16, -40, 0.1});
  const auto seen = visibility(s, sun);
  // The box's shadow is centred 16 m along -x on the floor, 3 m to each side.
  const auto at = [&](double x, double z) {
    const dvec2 p = pixelOf(s, *s.world.peek<Transform>(s.camera), {x, -40, z});
    return seen[s.at(static_cast<int>(p.x), static_cast<int>(p.y))];
  };
  EXPECT_NEAR(at(-16, 0), 0, 0.01);
  EXPECT_NEAR(at(-13.2, 2.8), 0, 0.01);
  EXPECT_NEAR(at(-18.8, -2.8), 0, 0.01);
  EXPECT_NEAR(at(-12.3, 0), 1, 0.01);
  EXPECT_NEAR(at(-16, 3.7), 1, 0.01);
  EXPECT_NEAR(at(-22, 0), 1, 0.01);  // outside the map
}

// A caster that the map's reach cuts: the map's border then lies on it, and what is beyond is lit
// instead of repeating the border.
TEST_F(DeferredShadow, BeyondTheMapsReachEverythingIsLit) {
  Studio s({120, 90});
  s.world.singleton<ShadowSettings>().max_distance_m = 5;
  const uint32_t matte = s.material(plainMaterial(vec3(0.8f), 0, 1));
  const Entity floor = s.put(s.mesh(sheetMesh()), matte, {0, 0, 0}, vec3(40));
  s.world.remove<CastsShadow>(floor);
  s.put(s.mesh(boxMesh()), matte, {0, 30, 0}, vec3(40, 0.1f, 40));
  const Entity sun = s.sun({0, 1, 0});
  s.look({0, 20, 0.01}, {0, 0, 0});
  const auto seen = visibility(s, sun);
  const auto at = [&](double x, double z) {
    const dvec2 p = pixelOf(s, *s.world.peek<Transform>(s.camera), {x, 0, z});
    return seen[s.at(static_cast<int>(p.x), static_cast<int>(p.y))];
  };
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(at(4 * side, 0), 0, 0.01);
    EXPECT_NEAR(at(0, 4 * side), 0, 0.01);
    EXPECT_NEAR(at(7 * side, 0), 1, 0.01);
    EXPECT_NEAR(at(0, 7 * side), 1, 0.01);
    EXPECT_NEAR(at(7 * side, 7), 1, 0.01);
  }
}

TEST_F(DeferredShadow, CastersOutOfViewCast) {
  Studio s({64, 64});
  const uint32_t matte = s.material(plainMaterial(vec3(0.8f), 0, 1));
  const Entity floor = s.put(s.mesh(sheetMesh()), matte, {0, 0, 0}, vec3(20));
  s.world.remove<CastsShadow>(floor);
  s.put(s.mesh(boxMesh()), matte, {8, 8, 0}, vec3(1));
  const Entity sun = s.sun({1, 1, 0});
  s.look({0, 3, 0.01}, {0, 0, 0});
  EXPECT_NEAR(visibility(s, sun)[s.at(32, 32)], 0, 0.01);
}

TEST_F(DeferredShadow, HolesOfMaskedCastersLetTheSunThrough) {
  Studio s({64, 64});
  MaterialData m = plainMaterial(vec3(1), 0, 1);
  m.alpha_mode = AlphaMode::Mask;
  m.double_sided = true;
  m.base_color_map.image = s.image(2, 1, 4, {255, 255, 255, 255, 255, 255, 255, 0}, ColorEncoding::Srgb);
  m.base_color_map.nearest = true;
  const uint32_t sheet = s.mesh(sheetMesh());
  const Entity floor = s.put(sheet, s.material(plainMaterial(vec3(0.8f), 0, 1)), {0, 0, 0}, vec3(20));
  s.world.remove<CastsShadow>(floor);
  s.put(sheet, s.material(m), {0, 5, 0}, vec3(2));
  const Entity sun = s.sun({0.001, 1, 0});
  s.look({0, 4, 0.01}, {0, 0, 0});
  const auto seen = visibility(s, sun);
  EXPECT_NEAR(seen[s.at(16, 32)], 0, 0.01);
  EXPECT_NEAR(seen[s.at(48, 32)], 1, 0.01);
}

// ---- places, order, hostile input

// Balls and boxes on a floor; returns the sun.
Entity buildScene(Studio& s, dvec3 origin, uint64_t order) {
  const uint32_t ball = s.mesh(sphereMesh()), box = s.mesh(boxMesh()), sheet = s.mesh(sheetMesh());
  std::vector<uint32_t> materials;
  for (int i = 0; i < 4; ++i)
    materials.push_back(s.material(plainMaterial(vec3(0.2f + 0.2f * static_cast<float>(i), 0.5f, 0.3f), i == 1 ? 1.0f : 0.0f, 0.3f + 0.2f * static_cast<float>(i))));
  std::vector<int> items(17);
  for (size_t i = 0; i < items.size(); ++i) items[i] = static_cast<int>(i);
  for (size_t i = items.size(); i-- > 1;) std::swap(items[i], items[randomBits(order, i, 0, 0) % (i + 1)]);
  if (order == 0) std::sort(items.begin(), items.end());
  for (const int i : items) {
    if (i == 16) {
      s.put(sheet, materials[0], origin, vec3(6));
      continue;
    }
    s.put(i % 2 ? ball : box, materials[static_cast<size_t>(i % 4)], origin + dvec3(i % 4 * 1.5 - 2.25, 0.4, i / 4 * 1.5 - 2.25), vec3(0.4f));
  }
  s.look(origin + dvec3(0.3, 4, 7), origin + dvec3(0, 0.3, 0));
  return s.sun({1, 2, 0.5});
}

TEST_F(DeferredHostile, AMillionMetresFromTheOriginLooksTheSame) {
  Studio home({160, 100}), away({160, 100});
  const Entity home_sun = buildScene(home, dvec3(0), 0);
  const Entity away_sun = buildScene(away, dvec3(1e6, 0, -1e6), 0);
  const auto a = visibility(home, home_sun), b = visibility(away, away_sun);
  EXPECT_EQ(home.ids(), away.ids());
  // The shadow map's texels lie on a grid fixed in the world, which meets the scene at another phase
  // there: pixels within the filter's reach of a shadow's edge may differ, and only these.
  int edges = 0;
  double mean = 0;
  for (int y = 3; y < home.size.y - 3; ++y)
    for (int x = 3; x < home.size.x - 3; ++x) {
      if (a[home.at(x, y)] < -0.5 || b[home.at(x, y)] < -0.5) continue;  // turned from the sun
      const double difference = std::abs(a[home.at(x, y)] - b[home.at(x, y)]);
      mean += (b[home.at(x, y)] - a[home.at(x, y)]) / static_cast<double>(a.size());
      if (difference < 0.02) continue;
      ++edges;
      double low = 2, high = -2;
      for (int v = -3; v <= 3; ++v)
        for (int u = -3; u <= 3; ++u) {
          const double seen = a[home.at(x + u, y + v)];
          low = std::min(low, seen);
          high = std::max(high, seen);
        }
      EXPECT_GT(high - low, 0.05) << "no shadow edge near pixel " << x << " " << y << ": " << a[home.at(x, y)] << " " << b[home.at(x, y)];
    }
  std::printf("%d of %zu pixels differ, at shadow edges; mean difference %.1e of the sun\n", edges, a.size(), mean);
  EXPECT_LT(edges, static_cast<int>(a.size() / 16));
  EXPECT_LT(std::abs(mean), 1e-3);
  castNothing(home);
  castNothing(away);
  home.render();
  away.render();
  const auto c = home.radiance(), d = away.radiance();
  double worst = 0;
  for (size_t i = 0; i < c.size(); ++i)
    for (int k = 0; k < 3; ++k) worst = std::max<double>(worst, std::abs(c[i][k] - d[i][k]) / (0.05 + c[i][k]));
  std::printf("without shadows: largest relative difference %.2e\n", worst);
  EXPECT_LT(worst, 2e-3);
}

TEST_F(DeferredHostile, OrderOfEntitiesDoesNotShow) {
  Studio a({160, 100});
  buildScene(a, dvec3(0), 0);
  a.render();
  const auto expected = a.radiance();
  const auto again = [&] {
    a.render();
    return a.radiance();
  };
  EXPECT_EQ(again(), expected);
  for (const uint64_t order : {1u, 2u, 3u}) {
    Studio b({160, 100});
    buildScene(b, dvec3(0), order);
    b.render();
    EXPECT_EQ(b.radiance(), expected) << "order " << order;
  }
}

TEST_F(DeferredHostile, MaterialsOutOfRangeAreClampedAndNamed) {
  MaterialData m = plainMaterial(vec3(kNan, -1, 2), kNan, -kInf);
  m.emissive = vec3(kInf, kNan, -3);
  m.normal_scale = kNan;
  testing::internal::CaptureStderr();
  const auto c = checkedConstants(m, "material 3 \"broken\"");
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(c.base_color, vec4(0, 0, 1, 1));
  EXPECT_EQ(c.metallic, 0);
  EXPECT_EQ(c.roughness, 0);
  EXPECT_EQ(c.emissive, vec4(rules::kMaxEmissive, 0, 0, 0));
  EXPECT_TRUE(std::isfinite(c.normal_scale));
  for (const char* word : {"material 3 \"broken\"", "base colour", "metallic", "roughness", "emissive", "normal scale"})
    EXPECT_NE(log.find(word), std::string::npos) << word << " in\n" << log;
}

TEST_F(DeferredHostile, EveryPixelStaysFinite) {
  Studio s({160, 120});
  MeshData broken = sphereMesh(12, 24);
  for (size_t i = 0; i < broken.vertices.size(); ++i) {
    if (i % 5 == 0) broken.vertices[i].normal = vec3(0);
    if (i % 7 == 0) broken.vertices[i].tangent = vec4(0);
    if (i % 11 == 0) broken.vertices[i].normal = vec3(kNan);
    if (i % 13 == 0) broken.vertices[i].uv = vec2(kInf, kNan);
  }
  const uint32_t ball = s.mesh(sphereMesh()), bad_ball = s.mesh(broken);
  std::vector<MaterialData> materials;
  for (const float roughness : {0.0f, 1e-20f, 1.0f, kNan, kInf, -1.0f})
    for (const float metallic : {0.0f, 1.0f, kNan}) materials.push_back(plainMaterial(vec3(1), metallic, roughness));
  materials.push_back(plainMaterial(vec3(kNan, kInf, -kInf), 1, 0));
  materials.back().emissive = vec3(kInf, 1e30f, kNan);
  materials.push_back(plainMaterial(vec3(1), 0, 0.5f));
  materials.back().normal_map.image = s.image(1, 1, 4, {128, 128, 128, 255}, ColorEncoding::Linear);
  materials.back().normal_scale = kInf;
  materials.push_back(plainMaterial(vec3(1), 0, 0.5f));
  materials.back().normal_map.image = s.image(1, 1, 4, {0, 0, 0, 0}, ColorEncoding::Linear);
  ImageData bad;
  bad.width = bad.height = 1;
  bad.channels = 4;
  bad.floats = {kNan, kInf, 1e38f, 1};
  materials.push_back(plainMaterial(vec3(1), 0, 0.5f));
  materials.back().emissive = vec3(1);
  materials.back().emissive_map.image = s.world.singleton<MaterialStore>().addImage(bad);
  int i = 0;
  for (const MaterialData& m : materials) {
    s.put(i % 2 ? bad_ball : ball, s.material(m), {i % 6 * 2.1 - 5.2, i / 6 * 2.1 - 3, 0});
    ++i;
  }
  const quat turn(kNan, 0, 0, 0);
  s.put(ball, 0, {0, 0, 1}, vec3(0));
  s.put(ball, 0, {0, 0, 1}, vec3(kNan, 1, 1));
  s.put(ball, 0, {kNan, 0, 1}, vec3(1));
  s.put(ball, 0, {1e300, 0, 1}, vec3(1));
  s.put(ball, 0, {0, 0, 1}, vec3(1), turn);
  s.put(ball, 0, {0, 0, 1}, vec3(1), quat(0, 0, 0, 0));
  s.look({0, 0, 12}, {0, 0, 0});
  const auto allFinite = [&](const char* what) {
    s.render();
    for (const vec3& c : s.radiance())
      ASSERT_TRUE(std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z) && glm::min(c.x, glm::min(c.y, c.z)) >= 0) << what;
    for (const float m : s.floats(kGbufferMotion, 2)) ASSERT_TRUE(std::isfinite(m)) << what;
    for (const float e : s.floats(kGbufferEmissive, 3)) ASSERT_TRUE(std::isfinite(e)) << what;
    const std::vector<float> depths = s.floats(kGbufferDepth, 1);
    for (const float d : depths) ASSERT_TRUE(d >= 0 && d <= 1) << what;
    EXPECT_GT(std::count_if(depths.begin(), depths.end(), [](float d) { return d > 0 && d < 1; }), 0) << what;
  };
  allFinite("no sun");
  const Entity sun = s.sun({0.2, 0.3, 1}, vec3(1), 1e6f);
  allFinite("blinding sun");
  for (const float lux : {kNan, kInf, -1.0f}) {
    s.world.find<Light>(sun)->intensity = lux;
    allFinite("broken sun");
    EXPECT_FALSE(s.world.singleton<const Sun>().present);
  }
  s.world.singleton<Sky>() = {vec3(kNan), vec3(kInf), vec3(-1)};
  allFinite("broken sky");
  s.world.find<Light>(sun)->intensity = 3;
  s.world.find<Transform>(sun)->rotation = turn;
  allFinite("broken direction");
}

}  // namespace
}  // namespace scree::test
