// A bed of coffee beans with all that draws swarms: the scene of the tests of several representations at once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "modules/impostors/impostors.h"
#include "modules/lod/state.h"
#include "modules/points/points.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {

// `across` x `across` x `deep` beans of radius 1 or a little less, at shaken places, turned and tinted at random; the upper
// side's middle is the origin, Y is up.
inline std::vector<SwarmGrain> beanBed(int across, int deep, float least_radius, uint64_t seed = 3) {
  std::vector<SwarmGrain> beans;
  uint64_t number = 0;
  for (int y = 0; y < deep; ++y)
    for (int z = 0; z < across; ++z)
      for (int x = 0; x < across; ++x, ++number) {
        SwarmGrain bean = cloud(1, 1, least_radius, 1, seed + number).front();
        const vec3 place(static_cast<float>(x) - 0.5f * static_cast<float>(across), -static_cast<float>(y), static_cast<float>(z) - 0.5f * static_cast<float>(across));
        bean.position = vec3(1.4f, 1, 1.4f) * place + 0.4f * bean.position;
        bean.tint = vec3(0.5f) + 0.5f * bean.tint;
        bean.seed = static_cast<uint16_t>(mix64(number));
        beans.push_back(bean);
      }
  return beans;
}

struct BeanScene : SwarmScene {
  uint32_t bean = 0;

  explicit BeanScene(ivec2 output) : SwarmScene(output) {
    addImpostors(app);
    addPoints(app);
    Result<uint32_t> shape = loadGrainShape(world, std::string(SCREE_SOURCE_DIR) + "/content/models/coffee_bean.glb", {},
                                            std::string(SCREE_BINARY_DIR) + "/bean_swarms.impostor");
    EXPECT_TRUE(shape.ok());
    if (shape.ok()) bean = *shape;
    sun({0.4, 1, 0.6});
  }
  LodSettings& settings() { return world.singleton<LodSettings>(); }
  // From 40 degrees above the horizon, at a distance from the origin.
  void lookFrom(double distance, float fov_y_rad) {
    look(dvec3(0, 0.643, 0.766) * distance, {0, 0, 0}, fov_y_rad, 0.05f);
  }
  float pixelsAt1m() { return world.singleton<const View>().block.pixels_at_1m; }
  // How many grains of the last frame were drawn as each representation, drawn first or not.
  std::array<uint64_t, rules::kFirst> drawnAs() {
    std::array<uint64_t, rules::kFirst> counts{};
    for (size_t k = 0; k < drawn().size(); ++k) {
      const SwarmPart& part = drawn().part(k);
      const lod::Routes& routes = *static_cast<const lod::Part&>(part).routes;
      const std::vector<uint32_t> words = gpu::readBuffer<uint32_t>(routes.representations, (part.count + 7) / 8);
      for (uint32_t grain = 0; grain < part.count; ++grain) ++counts[words[grain / 8] >> 4 * (grain % 8) & 7];
    }
    return counts;
  }
};

}  // namespace scree::test
