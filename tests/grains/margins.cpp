// What a grain can come to within its margin is listed, wherever in it the grain is.
#include <gtest/gtest.h>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

// A grain rattles between two walls, within one margin. When it is at one, a thin blade is put down
// near the other and stays: the grain bounces off it. Margins follow speeds and searches, so that the
// walls' distance is swept.
TEST(Margins, ABladeThatCameDownOnTheOtherSideIsMet) {
  constexpr GrainMaterial kHard{1000, 0, 0, 1};
  constexpr float kRadius = 0.05f;
  int rattled = 0, quiet = 0;
  const auto rattle = [&](float speed, float half_way, int wait) {
    Field field;
    field.parameters.gravity = vec3(0);
    field.parameters.damping = 0;
    const size_t grain = field.add({0, 0, 0}, kRadius, kHard, {speed, 0, 0});
    for (int n = 0; n < 60; ++n)  // so that the mean motion, which margins follow, is none
      field.add({50, 0, 0.2f * static_cast<float>(n)}, kRadius);
    const float wall = kRadius + half_way;
    field.addBox({-wall - 0.1f, 0, 0}, {0.1f, 1, 1}, 0).restitution = 1;
    field.addBox({wall + 0.1f, 0, 0}, {0.1f, 1, 1}, 0).restitution = 1;
    Collider& blade = field.addBox({0, 9, 0}, {0.0005f, 1, 1}, 0);
    blade.restitution = 1;
    field.step(wait);
    if (!(field.grain[grain].position.x < -0.5f * half_way)) return;
    ++rattled;
    const float at = kRadius + 0.15f * half_way;
    blade.position0 = blade.position1 = {at, 0, 0};
    uint32_t searches = 0;
    for (int tick = 0; tick < 12; ++tick) {
      field.step();
      searches += field.solver.stats().rebuilds;
      ASSERT_LT(field.grain[grain].position.x, at)
          << speed << " m/s, half way " << half_way << " m, put down after " << wait << " ticks";
    }
    quiet += searches < 6 ? 1 : 0;
  };
  for (const float speed : {0.5f, 1.0f, 2.0f, 4.0f, 8.0f})
    for (int k = 0; k < 40; ++k)
      for (int wait = 20; wait < 36; ++wait) rattle(speed, 0.02f + 0.005f * static_cast<float>(k), wait);
  EXPECT_GT(rattled, 100);
  EXPECT_GT(quiet, rattled / 4);  // it is the lists that are tested, not searches in every tick
}

}  // namespace
}  // namespace scree::grains::test
