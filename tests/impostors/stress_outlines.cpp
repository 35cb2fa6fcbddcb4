// What the router predicts bounds what is measured: 10,000 random views, none of which the tables were made from.
#include "tests/impostors/outlines.h"

#include "engine/ecs/world.h"

namespace scree::test {
namespace {

TEST(StressOutlines, PredictedErrorBoundsMeasuredError) {
  World world;
  const std::vector<RoutedShape> shapes = routedShapes(world);
  ASSERT_EQ(shapes.size(), 3u);
  const std::vector<GrainView> views = expectBounded(shapes, 100'000, 10'000);
  for (const uint32_t r : {rules::kPoint, rules::kSmallImpostor, rules::kImpostor, rules::kMesh, rules::kMesh + 1, rules::kMesh + 2})
    EXPECT_GE(std::ranges::count(views, r, &GrainView::drawn_as), 100) << "too few to say anything of " << r;
}

}  // namespace
}  // namespace scree::test
