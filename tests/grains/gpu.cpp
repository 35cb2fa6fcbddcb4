// Drawn spheres: each pixel against double precision; motion, shadows, counters.
#include <algorithm>
#include <cstdio>
#include <map>

#include "engine/core/random.h"
#include "engine/gpu/counters.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/grain.h"
#include "shaders/shared/octahedral.h"
#include "shaders/shared/sphere.h"
#include "tests/grains/stage.h"

namespace scree::test {
namespace {

class GrainsDrawn : public GlTest {};

void expectExact(Stage& stage, const char* what, double off_surface = 2e-6) {
  stage.render();
  const Difference d = compare(stage);
  std::printf("%s: %d pixels, %d wrong, %d ambiguous, off the surface %.2g, normal %.2g\n", what,
              d.covered, d.wrong_id, d.ambiguous, d.off_surface, d.normal);
  EXPECT_EQ(d.wrong_id, 0) << what;
  EXPECT_LE(d.ambiguous, 3 + d.covered / 1000) << what;
  EXPECT_LT(d.off_surface, off_surface) << what;
  EXPECT_LT(d.normal, 1) << what;
}

TEST_F(GrainsDrawn, CloudIsExact) {
  Stage stage({280, 200});
  stage.look({0, 0, 4}, {0, 0, 0});
  // A jittered lattice: grains of many sizes that do not overlap.
  for (uint64_t k = 0; k < 12 * 12 * 12; ++k) {
    const vec3 cell(static_cast<float>(k % 12) - 5.5f, static_cast<float>(k / 12 % 12) - 5.5f,
                    static_cast<float>(k / 144) - 5.5f);
    const float radius = 0.05f + 0.07f * randomUnit(1, k, 0, 0);
    const vec3 shake(randomUnit(1, k, 0, 1), randomUnit(1, k, 0, 2), randomUnit(1, k, 0, 3));
    stage.add(cell * 0.25f + (shake - 0.5f) * (0.25f - 2 * radius), radius);
  }
  stage.show();
  expectExact(stage, "cloud");
  stage.look({0.3, 0.2, 0.1}, {1, 0.4, -0.2}, 1.9f);  // from its middle, wide
  expectExact(stage, "inside the cloud");
  stage.look({40, 20, 30}, {0, 0, 0}, 0.06f);  // from afar, narrow
  expectExact(stage, "from afar");
}

TEST_F(GrainsDrawn, HugeSpheresGrazingAndOffScreen) {
  {  // far more than 255 px
    Stage stage;
    stage.look({0, 0, 3}, {0, 0, 0});
    stage.add({0, 0, 0}, 2.5f);
    stage.show();
    expectExact(stage, "fills the screen");
  }
  {  // skimming over a planet
    Stage stage;
    stage.look({0, 0.02, 0}, {0, 0, -1}, 1.2f, 0.001f);
    stage.add({0, -100, 0}, 100);
    stage.show();
    expectExact(stage, "grazing", 2e-4);  // a hundred metres of radius, centimetres away
  }
  // The centre just outside of each edge of the screen.
  for (const vec2 side : {vec2(-1, 0), vec2(1, 0), vec2(0, -1), vec2(0, 1), vec2(1, 1)}) {
    Stage stage;
    stage.look({0, 0, 5}, {0, 0, 0});
    const float half = 5 * std::tan(0.4f);
    stage.add({side.x * half * 4 / 3 * 1.05f, side.y * half * 1.05f, 0}, 0.9f);
    stage.show();
    expectExact(stage, "centre off screen");
    EXPECT_GT(compare(stage).covered, 100);
  }
}

TEST_F(GrainsDrawn, NearPlaneAndEyeInside) {
  Stage stage;
  stage.look({0, 0, 0}, {0, 0, -1}, 0.9f, 0.5f);
  stage.add({0.1f, 0, -0.62f}, 0.2f);   // crosses the near plane
  stage.add({0.5f, 0.3f, -1.2f}, 0.3f);
  stage.add({-0.5f, -0.2f, -0.75f}, 0.251f);  // just touches it
  stage.show();
  expectExact(stage, "near plane");

  // With the eye inside a grain nothing of it is seen, and what is behind it is.
  Stage inside;
  inside.look({0, 0, 0}, {0, 0, -1});
  inside.add({0.1f, 0.1f, 0}, 1);
  inside.add({0, 0, -5}, 1);
  inside.show();
  expectExact(inside, "eye inside");
  EXPECT_GT(compare(inside).covered, 1000);

  // The eye within one rounding step of the surface.
  for (const float distance : {0.99999994f, 1.0f, 1.0000001f}) {
    Stage touching;
    touching.look({0, 0, 0}, {0, 0, -1}, 0.9f, 0.01f);
    touching.add({0, 0, -distance}, 1);
    touching.add({0, 0, -9}, 1.5f);
    touching.show();
    touching.render();
    for (const float d : touching.floats(kGbufferDepth, 1)) EXPECT_TRUE(std::isfinite(d) && d >= 0 && d <= 1);
  }
}

TEST_F(GrainsDrawn, FarFromTheOriginIsTheSamePicture) {
  std::vector<uint32_t> want_id;
  std::vector<float> want_depth;
  for (const dvec3 origin : {dvec3(0), dvec3(1e6, 0, -1e6), dvec3(-3e8, 1e8, 5e8)}) {
    Stage stage;
    grainField(stage.world).origin = origin;
    stage.look(origin + dvec3(0.5, 1, 3), origin);
    for (uint64_t k = 0; k < 200; ++k)
      stage.add(vec3(randomUnit(2, k, 0, 0), randomUnit(2, k, 0, 1), randomUnit(2, k, 0, 2)) * 2.0f - 1.0f,
                0.05f);
    stage.show();
    stage.render();
    const auto id = gpu::readUints(stage.app.frame().texture(kGbufferId), 1);
    const auto depth = stage.floats(kGbufferDepth, 1);
    if (want_id.empty()) {
      want_id = id;
      want_depth = depth;
    }
    // The camera's offset is rounded only where doubles are: at 5e8 m to 6e-8 m.
    size_t different = 0;
    for (size_t k = 0; k < id.size(); ++k) different += id[k] != want_id[k];
    EXPECT_LE(different, origin.x == 0 || origin.x == 1e6 ? 0u : 4u);
  }
}

TEST_F(GrainsDrawn, MeshesHideGrainsAndGrainsHideMeshes) {
  // Grains on a table: every pixel shows what is nearer. Against the oracle with the table as a plane.
  Stage stage({320, 200});
  stage.look({0, 1.2, 2.5}, {0, 0, 0});
  const Entity table = stage.put(stage.mesh(sheetMesh()), 0, {0, 0, 0}, vec3(1.5f, 1, 1.5f));
  for (int x = -5; x <= 5; ++x)
    for (int z = -5; z <= 5; ++z)
      stage.add({0.2f * static_cast<float>(x), 0.08f, 0.2f * static_cast<float>(z)}, 0.08f);
  stage.add({0, -0.4f, 0}, 0.3f);  // under the table: not seen
  stage.show();
  stage.render();
  const ExactCamera camera(stage);
  const auto id = gpu::readUints(stage.app.frame().texture(kGbufferId), 1);
  int wrong = 0, grains = 0, tables = 0;
  for (int y = 0; y < stage.size.y; ++y)
    for (int x = 0; x < stage.size.x; ++x) {
      const auto shown = [&](double px, double py) {
        const ExactRay ray = camera.through(px, py);
        double best = 1e9;
        uint32_t found = 0;
        const double t = -ray.origin.y / ray.direction.y;
        const dvec3 p = ray.origin + t * ray.direction;
        if (t > 0 && std::abs(p.x) < 1.5 && std::abs(p.z) < 1.5) {
          best = t;
          found = table.index + 1;
        }
        for (size_t k = 0; k < stage.specs.size(); ++k) {
          const auto h = exactHit(ray, dvec3(stage.specs[k].grain.position),
                                  stage.specs[k].grain.radius, camera.near_m);
          if (h && h->t < best) {
            best = h->t;
            found = stage.entities[k].index + 1;
          }
        }
        return found;
      };
      const uint32_t want = shown(x + 0.5, y + 0.5);
      const uint32_t got = id[static_cast<size_t>(y * stage.size.x + x)];
      grains += got > table.index + 1;
      tables += got == table.index + 1;
      if (got == want) continue;
      bool edge = false;
      for (const dvec3 d : {dvec3(0.02, 0, 0), dvec3(-0.02, 0, 0), dvec3(0, 0.02, 0), dvec3(0, -0.02, 0)})
        edge = edge || shown(x + 0.5 + d.x, y + 0.5 + d.y) != want;
      wrong += !edge;
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(grains, 3000);
  EXPECT_GT(tables, 10000);
}

TEST_F(GrainsDrawn, MotionIsThatOfTheSurface) {
  // A grain that moves and turns, from a camera that moves: motion of surface points in double.
  Stage stage({320, 240});
  stage.look({0, 0, 2}, {0, 0, 0});
  *stage.world.find<PreviousTransform>(stage.camera) = {dvec3(0.03, -0.02, 2.01), stage.world.peek<Transform>(stage.camera)->rotation, vec3(1)};
  stage.add({0.1f, 0.05f, 0}, 0.4f);
  stage.specs[0].spin.angular = {3, -5, 2};
  stage.show();
  const Entity e = stage.entities[0];
  const vec3 before(0.07f, 0.02f, -0.05f);
  stage.world.find<GrainPrevious>(e)->position = before;
  stage.world.singleton<Tick>().dt_s = 1.0 / 60;
  for (const float alpha : {1.0f, 0.4f})
    for (const float scale : {1.0f, 2.0f}) {
      stage.render(1, alpha, scale);
      const auto id = gpu::readUints(stage.app.frame().texture(kGbufferId), 1);
      const auto depth = stage.floats(kGbufferDepth, 1);
      const auto motion = stage.floats(kGbufferMotion, 2);
      const double a = static_cast<double>(alpha), b = a - static_cast<double>(scale);
      const Transform now_camera = *stage.world.peek<Transform>(stage.camera);
      const PreviousTransform old_camera = *stage.world.peek<PreviousTransform>(stage.camera);
      const auto cameraAt = [&](double t) {
        ExactCamera c(stage);
        c.position = old_camera.position + (now_camera.position - old_camera.position) * t;
        return c;
      };
      const ExactCamera now = cameraAt(a), then = cameraAt(b);
      const auto centerAt = [&](double t) {
        return dvec3(before) + (dvec3(stage.specs[0].grain.position) - dvec3(before)) * t;
      };
      // The solver's rule: the quaternion (1, spin dt / 2), made a unit.
      const auto turn = [&](double t) {
        const dvec3 h = dvec3(stage.specs[0].spin.angular) * (0.5 * (t - 1) / 60);
        return glm::normalize(glm::dquat(1, h.x, h.y, h.z));
      };
      double worst = 0;
      int covered = 0;
      for (int y = 0; y < stage.size.y; ++y)
        for (int x = 0; x < stage.size.x; ++x) {
          const size_t at = static_cast<size_t>(y * stage.size.x + x);
          if (id[at] != e.index + 1) continue;
          ++covered;
          const ExactRay ray = now.through(x + 0.5, y + 0.5);
          const dvec3 p = ray.origin + ray.direction * (now.near_m / static_cast<double>(depth[at]));
          const dvec3 local = glm::conjugate(turn(a)) * (p - centerAt(a));
          const dvec3 was = then.project(centerAt(b) + turn(b) * local);
          const dvec3 is = now.project(p);
          const dvec3 got(motion[2 * at], motion[2 * at + 1], 0);
          worst = std::max(worst, glm::length(dvec3(is.x - was.x, is.y - was.y, 0) - got));
        }
      EXPECT_GT(covered, 1000);
      // RG16F: 2^-11 of the value.
      EXPECT_LT(worst, 0.02) << "alpha " << alpha << " scale " << scale;
    }
}

TEST_F(GrainsDrawn, ThePatternTurnsWithTheGrain) {
  Stage stage({200, 200});
  stage.look({0, 0, 2}, {0, 0, 0}, 0.6f);
  stage.add({0, 0, 0}, 0.4f, vec3(0.6f, 0.5f, 0.4f));
  stage.show();
  for (const float angle : {0.0f, 0.7f, 2.0f}) {
    stage.world.find<GrainOrientation>(stage.entities[0])->rotation = glm::angleAxis(angle, glm::normalize(vec3(1, 2, -1)));
    stage.render();
    const auto id = gpu::readUints(stage.app.frame().texture(kGbufferId), 1);
    const auto albedo = stage.floats(kGbufferAlbedo, 4);
    const ExactCamera camera(stage);
    const glm::dquat q(stage.world.peek<GrainOrientation>(stage.entities[0])->rotation);
    double worst = 0;
    for (int y = 0; y < 200; y += 3)
      for (int x = 0; x < 200; x += 3) {
        const size_t at = static_cast<size_t>(y * 200 + x);
        if (id[at] == 0) continue;
        const auto hit = exactHit(camera.through(x + 0.5, y + 0.5), dvec3(0), 0.4, camera.near_m);
        if (!hit) continue;
        const vec3 local(glm::conjugate(q) * hit->normal);
        const double want = 0.6 * static_cast<double>(rules::grainPattern(local, 1));
        const double got = rules::albedoFromCode(vec3(albedo[4 * at])).x;
        worst = std::max(worst, std::abs(got - want));
      }
    EXPECT_LT(worst, 0.02) << angle;  // 8 bits, twice
  }
}

TEST_F(GrainsDrawn, ShadowIsACylindersEnd) {
  Stage stage;
  stage.look({0, 2, 5}, {0, 0, 0});
  stage.add({0.1f, 0.5f, 0}, 0.3f);
  stage.add({-1.0f, 0.2f, 0.4f}, 0.1f);
  stage.show();
  stage.sun({1, 2, 0.5});
  stage.put(stage.mesh(sheetMesh()), 0, {0, -0.1, 0}, vec3(2));
  stage.render();
  EXPECT_EQ(stage.runs("grains.shadow"), 1u);
  const rules::ShadowViewBlock& view = stage.world.singleton<const ShadowView>().block;
  ASSERT_EQ(view.enabled, 1.0f);
  const auto map = stage.floats(kShadowMap, 1);
  const dvec3 eye = stage.world.singleton<const View>().position;
  int inside = 0, wrong = 0;
  double worst = 0;
  for (int y = 0; y < rules::kShadowMapSize; ++y)
    for (int x = 0; x < rules::kShadowMapSize; ++x) {
      for (const GrainSpec& s : stage.specs) {
        // Texels of the map, and depth.
        const vec4 at = view.shadow_from_relative * vec4(vec3(dvec3(s.grain.position) - eye), 1);
        const double texel = view.texel_m;
        const double dx = (x + 0.5 - static_cast<double>(at.x)) * texel,
                     dy = (y + 0.5 - static_cast<double>(at.y)) * texel;
        const double r = s.grain.radius, d = std::sqrt(dx * dx + dy * dy);
        if (d < r - 0.05 * texel) {
          ++inside;
          const double got = map[static_cast<size_t>(y) * rules::kShadowMapSize + static_cast<size_t>(x)];
          wrong += got == 0;
          worst = std::max(worst, std::abs(got - static_cast<double>(at.z)));
        }
      }
    }
  EXPECT_GT(inside, 1000);
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(worst, 1e-5);
}

TEST_F(GrainsDrawn, LitAndShadowedPictureIsFinite) {
  Stage stage;
  stage.look({0, 1, 3}, {0, 0, 0});
  for (uint64_t k = 0; k < 300; ++k)
    stage.add(vec3(randomUnit(3, k, 0, 0), randomUnit(3, k, 0, 1), randomUnit(3, k, 0, 2)) * 2.0f - 1.0f, 0.06f);
  stage.show();
  stage.sun({1, 1, 1});
  stage.render();
  for (const vec3& c : stage.radiance())
    ASSERT_TRUE(std::isfinite(c.x + c.y + c.z) && c.x >= 0 && c.y >= 0 && c.z >= 0);
}

TEST_F(GrainsDrawn, CostsWhatItMust) {
  Stage stage;
  stage.look({0, 0, 3}, {0, 0, 0});
  stage.sun({0, 1, 0});
  for (int k = 0; k < 100; ++k)
    stage.add({0.1f * static_cast<float>(k % 10) - 0.5f, 0.1f * static_cast<float>(k / 10) - 0.5f, 0}, 0.04f);
  // Before there are grains: nothing.
  gpu::Counters start = gpu::counters();
  stage.render();
  const gpu::Counters empty = gpu::counters() - start;
  EXPECT_EQ(stage.runs("grains.visible") + stage.runs("grains.draw") + stage.runs("grains.shadow"), 0u);
  EXPECT_FALSE(stage.app.frame().hasTexture("grains.visible"));
  EXPECT_EQ(empty.draws, 2u);  // sky, present
  stage.show();
  stage.render();
  stage.render();
  // Grains at rest: two draws more, and neither a record nor a shadow again.
  start = gpu::counters();
  stage.render();
  gpu::Counters rest = gpu::counters() - start;
  EXPECT_EQ(rest.draws, 2u + 3);  // visible, draw; light, sky, present
  EXPECT_EQ(rest.programs + rest.textures + rest.buffers + rest.framebuffers, 0u);
  EXPECT_LT(rest.bytes_uploaded, 100 * 4 + 2048u);
  // A grain that moved sends all records.
  stage.world.find<Grain>(stage.entities[5])->position.z += 0.01f;
  start = gpu::counters();
  stage.render();
  const gpu::Counters moved = gpu::counters() - start;
  EXPECT_EQ(moved.bytes_uploaded, rest.bytes_uploaded + 100 * sizeof(rules::GrainRecord));
  // Out of view: only the shadow.
  const uint64_t drawn = stage.runs("grains.draw");
  stage.look({0, 0, 3}, {0, 0, 6});
  stage.render();
  EXPECT_EQ(stage.runs("grains.draw"), drawn);
  // Gone: nothing again.
  stage.world.destroyMany(stage.entities);
  start = gpu::counters();
  stage.render();
  EXPECT_EQ((gpu::counters() - start).draws, 2u);
}

// A wall that glows, with a grain before it, one in it and one behind it.
TEST_F(GrainsDrawn, HideEmission) {
  Stage stage;
  MaterialData glowing;
  glowing.emissive = vec3(2, 0.5f, 0);
  const Entity wall = stage.put(stage.mesh(boxMesh()), stage.material(glowing), {0, 0, -1});
  stage.look({0, 0, 4}, {0, 0, 0});
  stage.add({0.5f, 0, 0.4f}, 0.3f);
  stage.add({-0.5f, 0, 0}, 0.3f);
  stage.add({0, 0, -3}, 0.3f);
  stage.show();
  stage.render();
  const std::vector<uint32_t> ids = stage.ids();
  const std::vector<float> emissive = stage.floats(kGbufferEmissive, 3);
  std::map<uint32_t, int> counts;
  for (size_t i = 0; i < ids.size(); ++i) {
    ++counts[ids[i]];
    ASSERT_EQ(vec3(emissive[3 * i], emissive[3 * i + 1], emissive[3 * i + 2]),
              ids[i] == wall.index + 1 ? glowing.emissive : vec3(0)) << i;
  }
  EXPECT_GT(counts[wall.index + 1], 1000);
  EXPECT_GT(counts[stage.entities[0].index + 1], 500);
  EXPECT_GT(counts[stage.entities[1].index + 1], 500);
  EXPECT_EQ(counts[stage.entities[2].index + 1], 0);
}

TEST_F(GrainsDrawn, ManyComeAndGo) {
  // The record buffer grows while frames are in flight.
  Stage stage({160, 120});
  stage.look({0, 0, 30}, {0, 0, 0});
  for (uint64_t k = 0; k < 27 * 27 * 27; ++k) {
    const vec3 cell(static_cast<float>(k % 27), static_cast<float>(k / 27 % 27), static_cast<float>(k / 729));
    const vec3 shake(randomUnit(4, k, 0, 0), randomUnit(4, k, 0, 1), randomUnit(4, k, 0, 2));
    stage.add((cell + 0.8f * shake) * 0.6f - 8.0f, 0.03f);
  }
  spawnGrains(stage.world, std::span(stage.specs).first(10));
  stage.render();
  spawnGrains(stage.world, std::span(stage.specs).subspan(10));
  stage.render();
  stage.entities.clear();
  stage.world.query<With<Grain>>().each([&](Entity e) { stage.entities.push_back(e); });
  const Difference d = compare(stage);
  EXPECT_EQ(d.wrong_id, 0);
  EXPECT_GT(d.covered, 1000);
}

}  // namespace
}  // namespace scree::test
