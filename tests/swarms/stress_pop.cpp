// The same from near to far and back, through all thresholds, in a wide and a narrow view.
#include "tests/swarms/dolly.h"

namespace scree::test {
namespace {

class StressPop : public GlTest {};

TEST_F(StressPop, NoStepIsSmallerThanItsSwitches) {
  for (const float fov : {0.8f, kNarrow}) {
    BeanScene scene({320, 200});
    scene.show(scene.bean, beanBed(40, 3, 0.7f));
    const std::string name = fov == kNarrow ? "pop_narrow" : "pop_wide";
    expectNoPop(dolly(scene, 48, 0.45, fov, kStep, true), name + "_away");
    expectNoPop(dolly(scene, 0.45, 48, fov, kStep, true), name + "_near");
  }
}

}  // namespace
}  // namespace scree::test
