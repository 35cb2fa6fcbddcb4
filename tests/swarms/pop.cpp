// A camera that passes the thresholds of a bed: no switch changes the picture by more than the camera's own step.
#include "tests/swarms/dolly.h"

namespace scree::test {
namespace {

class Pop : public GlTest {};

TEST_F(Pop, ImpostorsPointsAndMeshes) {
  BeanScene scene({320, 200});
  scene.show(scene.bean, beanBed(32, 3, 1));
  expectNoPop(dolly(scene, 0.92, 0.64, kNarrow, kStep, true), "pop_to_points");
  expectNoPop(dolly(scene, 0.64, 0.92, kNarrow, kStep, true), "pop_from_points");
  expectNoPop(dolly(scene, 10.2, 8.2, kNarrow, kStep, true), "pop_to_small");
  expectNoPop(dolly(scene, 44, 31, kNarrow, kStep, true), "pop_to_impostors");
}

TEST_F(Pop, LevelsOfMeshes) {
  BeanScene scene({320, 200});
  Result<uint32_t> pebble = loadGrainShape(scene.world, std::string(SCREE_SOURCE_DIR) + "/content/models/pebble.glb", {.directions = 0},
                                           std::string(SCREE_BINARY_DIR) + "/pebble_unmeasured.impostor");
  ASSERT_TRUE(pebble.ok());
  ASSERT_GE(scene.world.singleton<SwarmStore>().shape(*pebble).levels.size(), 3u) << "meshes and points alone";
  scene.show(*pebble, beanBed(20, 2, 1));
  expectNoPop(dolly(scene, 4.6, 3.6, kNarrow, kStep, true), "pop_to_level_1");
  expectNoPop(dolly(scene, 2.3, 1.7, kNarrow, kStep, true), "pop_to_level_2");
  expectNoPop(dolly(scene, 0.85, 0.55, kNarrow, kStep, true), "pop_meshes_to_points");
}

}  // namespace
}  // namespace scree::test
