// A glowing sheet among grains of every representation: each pixel shows, and glows as, what is nearer there.
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/swarms/bean_bed.h"

namespace scree::test {
namespace {

class SwarmEmission : public GlTest {};

struct Shown {
  std::vector<float> depth, emissive;
  std::vector<uint32_t> ids;

  // What one frame shows.
  explicit Shown(BeanScene& scene) {
    scene.render();
    depth = scene.floats(kGbufferDepth, 1);
    emissive = scene.floats(kGbufferEmissive, 3);
    ids = scene.ids();
  }
  vec3 emission(size_t p) const { return {emissive[3 * p], emissive[3 * p + 1], emissive[3 * p + 2]}; }
};

// How many pixels show a grain that was drawn after the depth pyramid.
size_t latePixels(BeanScene& scene) {
  const std::vector<uint32_t> routes = scene.routes();
  size_t late = 0;
  for (const uint32_t number : gpu::readUints(scene.app.frame().texture(kSwarmVisible), 1))
    late += number != 0 && routes[number - 1] < rules::kFirst;
  return late;
}

// The sheet cuts through the bed, or stands behind it. What both show is told by what each shows alone.
TEST_F(SwarmEmission, IsOfTheNearestSurface) {
  struct Case {
    const char* name;
    uint32_t only;
    double distance;
  };
  for (const Case& c : {Case{"meshes", rules::kMesh, 40}, Case{"impostors", rules::kImpostor, 40},
                        Case{"small impostors", rules::kSmallImpostor, 60}, Case{"points", rules::kPoint, 180}})
    for (const bool behind : {false, true}) {
      BeanScene scene({160, 100});
      scene.settings().only = c.only;
      scene.lookFrom(c.distance, 0.9f);
      MaterialData lamp = plainMaterial(vec3(0.5f), 0, 0.5f);
      lamp.emissive = vec3(2, 1, 0.5f);
      const Entity sheet = behind ? scene.put(scene.mesh(sheetMesh()), scene.material(lamp), {0, -4, -4}, vec3(60))
                                  : scene.put(scene.mesh(sheetMesh()), scene.material(lamp), {0, -0.5, 0}, vec3(15),
                                              glm::angleAxis(0.2f, glm::normalize(vec3(1, 0, 0.6f))));
      const Shown lamp_alone(scene);
      scene.show(scene.bean, beanBed(40, 3, 0.3f));
      const Shown both(scene);
      const size_t late = c.only == rules::kPoint ? 0 : latePixels(scene);
      scene.world.destroy(sheet);
      const Shown bed_alone(scene);
      EXPECT_EQ(scene.app.frame().runCount("deferred.emissive"), 2u);
      size_t of_lamp = 0, of_bed = 0, before_lamp = 0, wrong = 0;
      for (size_t p = 0; p < both.ids.size(); ++p) {
        const bool shows_lamp = lamp_alone.depth[p] > bed_alone.depth[p];
        const bool shows_bed = !shows_lamp && bed_alone.depth[p] > 0;
        of_lamp += shows_lamp;
        of_bed += shows_bed;
        before_lamp += shows_bed && lamp_alone.depth[p] > 0;
        wrong += both.ids[p] != (shows_lamp ? lamp_alone.ids[p] : bed_alone.ids[p]);
        wrong += both.emission(p) != (shows_lamp ? lamp.emissive : vec3(0));
      }
      std::printf("%s, lamp %s: %zu pixels of it, %zu of the bed, %zu of them before it, %zu drawn late\n", c.name,
                  behind ? "behind" : "across", of_lamp, of_bed, before_lamp, late);
      EXPECT_EQ(wrong, 0u) << c.name << (behind ? ", behind" : ", across");
      EXPECT_GT(of_lamp, 80u);
      EXPECT_GT(before_lamp, 100u);
      EXPECT_TRUE(c.only == rules::kPoint || late > 100) << late;
    }
}

}  // namespace
}  // namespace scree::test
