// What meshes write into the G-buffer, at every pixel, against rays cast in double precision.
#include <map>
#include <set>

#include "engine/core/random.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/octahedral.h"
#include "shaders/shared/tonemap.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

using glm::dvec2;

class Gbuffer : public GlTest {};

// The G-buffer as read back, one entry a pixel.
struct Pixels {
  std::vector<uint8_t> albedo, normal;  // 4 a pixel, as stored
  std::vector<float> emissive;          // 3
  std::vector<float> motion;            // 2
  std::vector<float> depth;
  std::vector<uint32_t> id;

  explicit Pixels(Studio& s)
      : albedo(gpu::readBytes(s.app.frame().texture(kGbufferAlbedo), 4)),
        normal(gpu::readBytes(s.app.frame().texture(kGbufferNormal), 4)),
        emissive(s.floats(kGbufferEmissive, 3)),
        motion(s.floats(kGbufferMotion, 2)),
        depth(s.floats(kGbufferDepth, 1)),
        id(s.ids()) {}
  vec3 normalAt(size_t i) const {
    return rules::octDecode(rules::octUnpack24(vec3(normal[4 * i], normal[4 * i + 1], normal[4 * i + 2]) / 255.0f));
  }
  float roughnessAt(size_t i) const { return static_cast<float>(normal[4 * i + 3]) / 255; }
  float metallicAt(size_t i) const { return rules::metallicFromCode(static_cast<float>(albedo[4 * i + 3]) / 255); }
};

double angle(dvec3 a, dvec3 b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

uint32_t idOf(Entity e) { return e.index + 1; }

TEST_F(Gbuffer, SheetIsExactAtEveryPixel) {
  Studio s({131, 77});  // odd sizes
  MaterialData m = plainMaterial(vec3(0.8f, 0.25f, 0.02f), 0.6f, 0.37f);
  m.emissive = vec3(2, 0.5f, 0);
  const Entity sheet = s.put(s.mesh(sheetMesh(4)), s.material(m), {1, 0.5, -2}, vec3(3));
  s.look({0, 4, 5}, {1, 0, -1});
  s.render();
  const Pixels p(s);
  int covered = 0;
  for (int y = 0; y < s.size.y; ++y)
    for (int x = 0; x < s.size.x; ++x) {
      const size_t i = s.at(x, y);
      const Ray ray = rayThrough(s, dvec2(x + 0.5, y + 0.5));
      const double t = (0.5 - ray.origin.y) / ray.direction.y;
      const dvec3 hit = ray.origin + t * ray.direction;
      const double edge = 3 - std::max(std::abs(hit.x - 1), std::abs(hit.z + 2));
      if (t < 0 || std::abs(edge) < 0.02) continue;  // on the border, rasterisation rules decide
      if (edge < 0) {
        EXPECT_EQ(p.id[i], 0u);
        EXPECT_EQ(p.depth[i], 0.0f);
        continue;
      }
      ++covered;
      ASSERT_EQ(p.id[i], idOf(sheet)) << x << " " << y;
      EXPECT_NEAR(p.depth[i] / (0.1 / (t * ray.along_axis)), 1, 2e-6);
      EXPECT_EQ(p.normalAt(i), vec3(0, 1, 0));
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(p.albedo[4 * i + static_cast<size_t>(k)], 255 * std::sqrt(m.base_color[k]), 0.51);
      EXPECT_NEAR(p.metallicAt(i), 0.6, 0.51 / 127);
      EXPECT_NEAR(p.roughnessAt(i), 0.37, 0.51 / 255);
      EXPECT_NEAR(p.emissive[3 * i], 2, 2.0 / 64);
      EXPECT_NEAR(p.emissive[3 * i + 1], 0.5, 0.5 / 64);
      EXPECT_EQ(p.emissive[3 * i + 2], 0);
      EXPECT_NEAR(p.motion[2 * i], 0, 1e-3);
      EXPECT_NEAR(p.motion[2 * i + 1], 0, 1e-3);
    }
  EXPECT_GT(covered, 2000);
}

// Non-uniform, negative scales and rotations: normals of an ellipsoid are known in closed form.
TEST_F(Gbuffer, NormalsSurviveScaleRotationAndMirroring) {
  for (const vec3 scale : {vec3(1, 0.3f, 2), vec3(-1, 0.3f, 2), vec3(1, -0.5f, -2), vec3(-0.7f, -0.5f, -1.5f)}) {
    Studio s({120, 90});
    const quat rotation = glm::normalize(quat(0.7f, 0.3f, -0.4f, 0.5f));
    const dvec3 center(0.2, 0.1, 0);
    s.put(s.mesh(sphereMesh(128, 256)), 0, center, scale, rotation);
    s.look({0, 0, 7}, {0, 0, 0});
    s.render();
    const Pixels p(s);
    const glm::dmat3 local_from_world =
        glm::transpose(glm::dmat3(glm::mat3_cast(glm::dquat(rotation))));
    const dvec3 inverse = 1.0 / dvec3(scale);
    int covered = 0;
    for (int y = 0; y < s.size.y; ++y)
      for (int x = 0; x < s.size.x; ++x) {
        const size_t i = s.at(x, y);
        const Ray ray = rayThrough(s, dvec2(x + 0.5, y + 0.5));
        const dvec3 o = (local_from_world * (ray.origin - center)) * inverse;
        const dvec3 d = (local_from_world * ray.direction) * inverse;
        const double b = glm::dot(o, d) / glm::dot(d, d), c = (glm::dot(o, o) - 1) / glm::dot(d, d);
        const double h = b * b - c;
        if (h < 0.02) continue;  // outside, or so near the silhouette that facets show
        const dvec3 local = o + (-b - std::sqrt(h)) * d;
        const dvec3 expected = glm::transpose(local_from_world) * (local * inverse);
        ++covered;
        ASSERT_NE(p.id[i], 0u) << "front faces of a mirrored mesh were culled";
        EXPECT_LT(angle(expected, p.normalAt(i)), 0.04) << x << " " << y;
      }
    EXPECT_GT(covered, 300);
  }
}

TEST_F(Gbuffer, SidesAreCulledOrTurned) {
  Studio s({64, 64});
  const uint32_t sheet = s.mesh(sheetMesh());
  MaterialData m = plainMaterial(vec3(0.5f), 0, 0.5f);
  const uint32_t single = s.material(m);
  m.double_sided = true;
  const uint32_t doubled = s.material(m);
  const auto center = [&](double eye_y, uint32_t material, vec3 scale) {
    const Entity e = s.put(sheet, material, {0, 0, 0}, scale);
    s.look({0, eye_y, 0.01}, {0, 0, 0});
    s.render();
    // A pass that drew nothing leaves no targets to look at.
    const bool seen = s.ids()[s.at(32, 32)] == idOf(e);
    const vec3 normal = seen ? Pixels(s).normalAt(s.at(32, 32)) : vec3(0);
    s.world.destroy(e);
    return normal;
  };
  const vec3 up(0, 1, 0);
  EXPECT_EQ(center(3, single, vec3(1)), up);
  EXPECT_EQ(center(-3, single, vec3(1)), vec3(0));
  EXPECT_EQ(center(3, doubled, vec3(1)), up);
  EXPECT_EQ(center(-3, doubled, vec3(1)), -up);
  // Mirrored in the plane: the outside stays the outside.
  EXPECT_EQ(center(3, single, vec3(-1, 1, 1)), up);
  EXPECT_EQ(center(-3, single, vec3(-1, 1, 1)), vec3(0));
  EXPECT_EQ(center(-3, doubled, vec3(-1, 1, 1)), -up);
  // Mirrored across the plane: it faces down.
  EXPECT_EQ(center(3, single, vec3(1, -1, 1)), vec3(0));
  EXPECT_EQ(center(-3, single, vec3(1, -1, 1)), -up);
  EXPECT_EQ(center(3, doubled, vec3(1, -1, 1)), up);
}

TEST_F(Gbuffer, MapsMultiplyFactorsInTheirChannels) {
  Studio s({64, 64});
  MaterialData m = plainMaterial(vec3(1, 0.5f, 1), 0.8f, 0.9f);
  m.emissive = vec3(4);
  m.base_color_map.image = s.image(1, 1, 4, {188, 255, 55, 255}, ColorEncoding::Srgb);
  m.metallic_roughness_map.image = s.image(1, 1, 4, {7, 128, 64, 9}, ColorEncoding::Linear);
  m.emissive_map.image = s.image(1, 1, 4, {255, 0, 188, 255}, ColorEncoding::Srgb);
  // Leaning by 30 degrees towards +u, which is +x here.
  m.normal_map.image = s.image(1, 1, 4, {191, 128, 238, 255}, ColorEncoding::Linear);
  s.put(s.mesh(sheetMesh()), s.material(m), {0, 0, 0}, vec3(2));
  s.look({0, 3, 0.01}, {0, 0, 0});
  s.render();
  const Pixels p(s);
  const size_t i = s.at(30, 30);
  const auto code = [](int srgb) { return 255 * std::sqrt(rules::linearFromSrgb(static_cast<float>(srgb) / 255)); };
  EXPECT_NEAR(p.albedo[4 * i], code(188), 1);
  EXPECT_NEAR(p.albedo[4 * i + 1], 255 * std::sqrt(0.5), 1);
  EXPECT_NEAR(p.albedo[4 * i + 2], code(55), 1);
  EXPECT_NEAR(p.roughnessAt(i), 0.9 * 128 / 255, 0.004);
  EXPECT_NEAR(p.metallicAt(i), 0.8 * 64 / 255, 0.51 / 127);
  EXPECT_NEAR(p.emissive[3 * i], 4, 0.07);
  EXPECT_EQ(p.emissive[3 * i + 1], 0);
  EXPECT_NEAR(p.emissive[3 * i + 2], 4 * rules::linearFromSrgb(188 / 255.0f), 0.07);
  EXPECT_LT(angle(p.normalAt(i), dvec3(0.5, std::sqrt(0.75), 0)), 0.012);
}

TEST_F(Gbuffer, NormalMapAxesFollowTheTexture) {
  Studio s({64, 64});
  const uint32_t sheet = s.mesh(sheetMesh());
  const auto normal = [&](std::vector<uint8_t> texel, vec3 scale) {
    MaterialData m = plainMaterial(vec3(1), 0, 1);
    m.normal_map.image = s.image(1, 1, 4, std::move(texel), ColorEncoding::Linear);
    const Entity e = s.put(sheet, s.material(m), {0, 0, 0}, scale);
    s.look({0, 3, 0.01}, {0, 0, 0});
    s.render();
    const vec3 n = Pixels(s).normalAt(s.at(31, 31));
    s.world.destroy(e);
    return dvec3(n);
  };
  // Of the sheet, +u is +x and +v is +z; green points along -v in the picture, so along -z.
  EXPECT_GT(normal({191, 128, 238, 255}, vec3(1)).x, 0.45);
  EXPECT_LT(normal({191, 128, 238, 255}, vec3(-1, 1, 1)).x, -0.45);
  EXPECT_LT(normal({128, 191, 238, 255}, vec3(1)).z, -0.45);
  EXPECT_LT(normal({128, 191, 238, 255}, vec3(-1, 1, 1)).z, -0.45);
  EXPECT_GT(normal({128, 191, 238, 255}, vec3(1, 1, -1)).z, 0.45);
  EXPECT_LT(angle(normal({128, 128, 255, 255}, vec3(1)), dvec3(0, 1, 0)), 0.006);
}

TEST_F(Gbuffer, AlphaMaskLeavesHoles) {
  Studio s({64, 64});
  MaterialData m = plainMaterial(vec3(1), 0, 1);
  m.alpha_mode = AlphaMode::Mask;
  m.base_color_map.image = s.image(2, 1, 4, {255, 255, 255, 255, 255, 255, 255, 0}, ColorEncoding::Srgb);
  m.base_color_map.nearest = true;
  const Entity e = s.put(s.mesh(sheetMesh()), s.material(m), {0, 0, 0}, vec3(1));
  s.look({0, 2, 0.001}, {0, 0, 0});
  s.render();
  const auto ids = s.ids();
  EXPECT_EQ(ids[s.at(20, 32)], idOf(e));  // u < 0.5
  EXPECT_EQ(ids[s.at(44, 32)], 0u);
}

// ---- motion

// Moves, turns and scales the sheet and the camera, and follows every pixel back.
TEST_F(Gbuffer, MotionIsWhereThePointWas) {
  struct Case {
    float alpha, motion_scale;
    int samples;
  };
  for (const Case c : {Case{1, 1, 1}, Case{0.4f, 1, 1}, Case{0.7f, 0.25f, 1}}) {
    Studio s({150, 100});
    const Entity sheet = s.put(s.mesh(sheetMesh(8)), 0, {0, 0, 0}, vec3(2));
    s.look({0.5, 4, 5}, {0, 0, 0});
    const Transform placed = *s.world.peek<Transform>(sheet), eye = *s.world.peek<Transform>(s.camera);
    const PreviousTransform placed_before{{-0.1, 0.05, 0.2}, glm::angleAxis(0.1f, vec3(0, 1, 0)), vec3(2.1f, 2, 1.9f)};
    const PreviousTransform eye_before{{0.3, 4.1, 5.2}, eye.rotation * glm::angleAxis(0.02f, vec3(1, 0, 0)), vec3(1)};
    *s.world.find<PreviousTransform>(sheet) = placed_before;
    *s.world.find<PreviousTransform>(s.camera) = eye_before;
    s.render(c.samples, c.alpha, c.motion_scale);
    const Pixels p(s);
    const double then = static_cast<double>(c.alpha) - c.motion_scale;
    const Transform now_t = interpolate(placed_before, placed, c.alpha), then_t = interpolate(placed_before, placed, then);
    const Transform now_eye = interpolate(eye_before, eye, c.alpha), then_eye = interpolate(eye_before, eye, then);
    int covered = 0;
    double largest = 0;
    for (int y = 0; y < s.size.y; ++y)
      for (int x = 0; x < s.size.x; ++x) {
        const size_t i = s.at(x, y);
        if (p.id[i] == 0) continue;
        const dvec2 pixel(x + 0.5, y + 0.5);
        const Ray ray = rayThrough(s, now_eye, pixel);
        const dvec3 normal = glm::dquat(now_t.rotation) * dvec3(0, 1, 0);
        const double t = glm::dot(now_t.position - ray.origin, normal) / glm::dot(ray.direction, normal);
        const dvec3 local = (glm::conjugate(glm::dquat(now_t.rotation)) *
                             (ray.origin + t * ray.direction - now_t.position)) / dvec3(now_t.scale);
        const dvec3 before = then_t.position + glm::dquat(then_t.rotation) * (dvec3(then_t.scale) * local);
        const dvec2 expected = pixel - pixelOf(s, then_eye, before);
        ++covered;
        largest = std::max(largest, glm::length(expected));
        EXPECT_NEAR(p.motion[2 * i], expected.x, 0.02 + 2e-3 * std::abs(expected.x)) << x << " " << y;
        EXPECT_NEAR(p.motion[2 * i + 1], expected.y, 0.02 + 2e-3 * std::abs(expected.y)) << x << " " << y;
      }
    EXPECT_GT(covered, 2000);
    EXPECT_GT(largest, 1);
  }
}

TEST_F(Gbuffer, MotionOfStillThingsIgnoresJitter) {
  Studio s({64, 64});
  s.put(s.mesh(sheetMesh()), 0, {0, 0, 0}, vec3(5));
  s.look({0, 3, 3}, {0, 0, 0});
  s.render(7);
  const Pixels p(s);
  for (const float m : p.motion) EXPECT_NEAR(m, 0, 1e-2);
}

TEST_F(Gbuffer, MotionFromBehindTheCameraIsFinite) {
  Studio s({64, 64});
  const Entity e = s.put(s.mesh(sphereMesh(16, 32)), 0, {0, 0, -3}, vec3(1));
  s.look({0, 0, 0}, {0, 0, -1});
  for (const dvec3 from : {dvec3(0, 0, 3), dvec3(1, 0, 0), dvec3(0, 0, 0), dvec3(0, 1e5, 1), dvec3(0, 0, -0.9)}) {
    s.world.find<PreviousTransform>(e)->position = from;
    s.render();
    const Pixels p(s);
    ASSERT_NE(p.id[s.at(32, 32)], 0u);
    for (const float m : p.motion) ASSERT_TRUE(std::abs(m) <= rules::kMaxMotionPx * 1.01f) << m;
  }
}

// Two sheets across each other, one of which glows: each pixel emits what the nearer one does, also
// where something glowed one frame ago.
TEST_F(Gbuffer, EmissionIsOfTheNearestSurface) {
  MaterialData m = plainMaterial(vec3(0.5f), 0, 0.5f);
  const uint32_t plain = 0;
  for (const bool glowing_first : {true, false}) {
    Studio s({64, 64});
    m.emissive = vec3(2, 0.5f, 0);
    const uint32_t sheet = s.mesh(sheetMesh()), glowing = s.material(m);
    const auto put = [&](uint32_t material, float turn) {
      return s.put(sheet, material, {0, 0, 0}, vec3(2), glm::angleAxis(turn, vec3(0, 0, 1)));
    };
    const Entity first = put(glowing_first ? glowing : plain, 0.4f);
    const Entity second = put(glowing_first ? plain : glowing, -0.4f);
    s.look({0, 3, 0.01}, {0, 0, 0});
    for (const double eye_x : {0.0, 0.4}) {
      s.look({eye_x, 3, 0.01}, {eye_x, 0, 0});
      s.render();
      const Pixels p(s);
      int counts[2] = {};
      for (size_t i = 0; i < p.id.size(); ++i) {
        const bool glows = p.id[i] == idOf(glowing_first ? first : second);
        ++counts[glows];
        ASSERT_EQ(vec3(p.emissive[3 * i], p.emissive[3 * i + 1], p.emissive[3 * i + 2]),
                  glows ? m.emissive : vec3(0)) << i;
      }
      EXPECT_GT(std::min(counts[0], counts[1]), 500);
    }
  }
}

// ---- precision, culling, placement

TEST_F(Gbuffer, TwoPlanesAMillimetreApartAtHundredMetres) {
  for (const bool near_first : {true, false}) {
    Studio s({97, 61});
    const uint32_t sheet = s.mesh(sheetMesh());
    const dvec3 near_place(0, 0, -100), far_place(0, 0, -100.001);
    const quat facing = glm::angleAxis(std::numbers::pi_v<float> / 2, vec3(1, 0, 0));
    const Entity a = s.put(sheet, 0, near_first ? near_place : far_place, vec3(90), facing);
    const Entity b = s.put(sheet, 0, near_first ? far_place : near_place, vec3(90), facing);
    s.look({0, 0, 0}, {0.02, 0.01, -1});
    s.render();
    const auto ids = s.ids();
    for (const uint32_t id : ids) ASSERT_EQ(id, idOf(near_first ? a : b));
  }
}

// Spheres everywhere around the camera, many across the frustum's planes: whatever a ray hits well
// inside is in the picture.
TEST_F(Gbuffer, CullingLosesNothing) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    Studio s({96, 64});
    const uint32_t ball = s.mesh(sphereMesh(24, 48));
    std::vector<std::pair<dvec3, double>> spheres;
    std::vector<Entity> entities;
    for (uint64_t i = 0; i < 400; ++i) {
      const auto r = [&](uint64_t d) { return 2.0 * randomUnit(seed, i, 0, d) - 1; };
      const dvec3 p(6 * r(0), 4 * r(1), 6 * r(2));
      const double radius = 0.05 + 0.6 * (r(3) + 1) * (r(3) + 1) / 4;
      if (glm::length(p) < radius + 0.2) continue;
      spheres.push_back({p, radius});
      entities.push_back(s.put(ball, 0, p, vec3(static_cast<float>(radius))));
    }
    const auto axis = [&](uint64_t d) { return 2.0 * randomUnit(seed, 999, 0, d) - 1; };
    s.look({0, 0, 0}, {axis(0), 0.3 * axis(1), axis(2)}, 1.2f);
    s.render();
    const auto ids = s.ids();
    int checked = 0;
    for (int y = 0; y < s.size.y; ++y)
      for (int x = 0; x < s.size.x; ++x) {
        const Ray ray = rayThrough(s, dvec2(x + 0.5, y + 0.5));
        double nearest = 1e30, second = 1e30;
        size_t hit = 0;
        bool clear = true;
        for (size_t k = 0; k < spheres.size(); ++k) {
          const dvec3 o = ray.origin - spheres[k].first;
          const double b = glm::dot(o, ray.direction), c = glm::dot(o, o) - spheres[k].second * spheres[k].second;
          const double h = b * b - c;
          // Near a silhouette, facets decide.
          if (std::abs(h) < 0.05 * spheres[k].second * spheres[k].second && b < 0) clear = false;
          if (h <= 0 || -b - std::sqrt(h) < 0.1) continue;
          const double t = -b - std::sqrt(h);
          if (t < nearest) {
            second = nearest;
            nearest = t;
            hit = k;
          } else {
            second = std::min(second, t);
          }
        }
        if (!clear || nearest > 1e29 || second - nearest < 0.02) continue;
        ++checked;
        EXPECT_EQ(ids[s.at(x, y)], idOf(entities[hit])) << "seed " << seed << " pixel " << x << " " << y;
      }
    EXPECT_GT(checked, 1500);
  }
}

TEST_F(Gbuffer, RegroupsWhenInstancesChange) {
  Studio s({64, 64});
  const uint32_t ball = s.mesh(sphereMesh(12, 24)), box = s.mesh(boxMesh());
  const uint32_t red = s.material(plainMaterial(vec3(1, 0, 0), 0, 1)), blue = s.material(plainMaterial(vec3(0, 0, 1), 0, 1));
  std::vector<Entity> all;
  for (int i = 0; i < 6; ++i) all.push_back(s.put(i % 2 ? ball : box, i % 3 ? red : blue, {i - 2.5, 0, 0}, vec3(0.3f)));
  s.look({0, 0, 6}, {0, 0, 0});
  const auto seen = [&] {
    s.render();
    std::map<uint32_t, int> colors;  // id -> red of the albedo
    const Pixels p(s);
    for (size_t i = 0; i < p.id.size(); ++i)
      if (p.id[i]) colors[p.id[i]] = p.albedo[4 * i];
    return colors;
  };
  auto colors = seen();
  ASSERT_EQ(colors.size(), 6u);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(colors[idOf(all[static_cast<size_t>(i)])], i % 3 ? 255 : 0) << i;
  s.world.find<MeshInstance>(all[1])->material = blue;
  s.world.destroy(all[2]);
  all[2] = s.put(ball, blue, {0, 1.2, 0}, vec3(0.3f));
  colors = seen();
  ASSERT_EQ(colors.size(), 6u);
  EXPECT_EQ(colors[idOf(all[1])], 0);
  EXPECT_EQ(colors[idOf(all[2])], 0);
  EXPECT_EQ(colors[idOf(all[4])], 255);
  // What names a mesh or material that does not exist is left out; the rest stays.
  s.world.find<MeshInstance>(all[0])->mesh = 77;
  s.world.find<MeshInstance>(all[4])->material = 1234;
  EXPECT_EQ(seen().size(), 4u);
}

TEST_F(Gbuffer, SteadyStateAllocatesNothingOnTheGpu) {
  Studio s({64, 64});
  const uint32_t ball = s.mesh(sphereMesh(8, 16));
  for (int i = 0; i < 50; ++i) s.put(ball, 0, {i % 10 - 5.0, i / 10 - 2.0, 0}, vec3(0.3f));
  s.sun({1, 2, 3});
  s.look({0, 0, 9}, {0, 0, 0});
  for (int i = 0; i < 4; ++i) s.render();
  const gpu::Counters before = gpu::counters();
  for (int i = 0; i < 10; ++i) s.render();
  const gpu::Counters used = gpu::counters() - before;
  EXPECT_EQ(used.programs + used.textures + used.buffers + used.framebuffers, 0u);
  EXPECT_EQ(used.draws, 10u * (1 + 3));  // one batch, light, sky, present; the still casters are kept
}

}  // namespace
}  // namespace scree::test
