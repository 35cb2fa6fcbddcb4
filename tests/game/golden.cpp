// The moments of the committed win against golden pictures, and proof at each of them that the gate
// sees one lost grain of about 6 px, a flipped sun and swapped channels.
#include <algorithm>
#include <cmath>
#include <map>

#include "modules/grains/grains.h"
#include "modules/scene/scene.h"
#include "tests/game/support/moments.h"

namespace scree::hourglass {
namespace {

using images::Image;

constexpr double kWantedDiameter = 6;  // px
// A grain that shows fewer pixels between others is none that must be missed: momentBounds() allows
// two strays side by side.
constexpr int kLeastPixels = 5;
constexpr size_t kVictims = 8;  // a moment

struct Seen {
  Entity entity;
  double diameter_px;
  int pixels;
};

// The grains that show, the nearest to kWantedDiameter first.
std::vector<Seen> seenGrains(World& world, const Image& image) {
  std::map<uint32_t, int> pixels;
  for (const uint32_t id : image.ids) ++pixels[id];
  const View view = world.singleton<const View>();
  const dvec3 origin = grainField(world).origin;
  std::vector<Seen> seen;
  world.query<const Grain>().each([&](Entity entity, const Grain& grain) {
    const auto found = pixels.find(entity.index + 1);
    if (found == pixels.end() || found->second < kLeastPixels) return;
    const vec3 relative(origin + dvec3(grain.position) - view.position);
    const double distance = -(glm::conjugate(view.rotation) * relative).z;
    seen.push_back({entity, 2.0 * grain.radius * view.block.pixels_at_1m / distance, found->second});
  });
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) {
    const double a_off = std::abs(a.diameter_px - kWantedDiameter),
                 b_off = std::abs(b.diameter_px - kWantedDiameter);
    return a_off != b_off ? a_off < b_off : a.entity.index < b.entity.index;
  });
  return seen;
}

class Golden : public MomentTest {
 protected:
  // What is drawn after `spoil` must not pass for the golden; then all is as before.
  template <class Spoil>
  void expectCaught(const std::string& what, const Image& golden, Spoil&& spoil) {
    World& world = app_->world();
    const std::string state = world.saveBytes();
    spoil(world);
    const images::GateResult result =
        images::compareImages(images::quantised(draw()), golden, momentBounds());
    EXPECT_FALSE(result.passed) << what << ": " << result.message;
    ASSERT_TRUE(world.loadBytes(state, "the moment").ok());
  }

  void expectGrainsAreMissed(const Image& golden) {
    const std::vector<Seen> seen = seenGrains(app_->world(), golden);
    ASSERT_GE(seen.size(), kVictims);
    ASSERT_LT(seen[0].diameter_px, kWantedDiameter + 1) << "a larger one is easy to miss";
    for (size_t i = 0; i < kVictims; ++i) {
      expectCaught(fmt::format("one grain of {:.1f} px that shows {} pixels deleted", seen[i].diameter_px,
                               seen[i].pixels),
                   golden, [&](World& world) { world.destroy(seen[i].entity); });
    }
  }

  void expectTheSunIsMissed(const Image& golden) {
    expectCaught("sun turned by half a turn about +Y", golden, [](World& world) {
      world.query<const Light, Transform>().each([](const Light& light, Transform& transform) {
        if (light.kind == LightKind::Directional)
          transform.rotation = quat(0, 0, 1, 0) * transform.rotation;
      });
    });
  }
};

void expectSwapsAreSeen(const Image& right, const Image& golden) {
  for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    Image swapped = right;
    for (size_t i = 0; i < swapped.pixels(); ++i) std::swap(swapped.rgb[i * 3 + a], swapped.rgb[i * 3 + b]);
    const images::GateResult result = images::compareImages(swapped, golden, momentBounds());
    EXPECT_FALSE(result.passed) << "channels " << a << " and " << b << " swapped: " << result.message;
  }
}

TEST_F(Golden, EachMomentOfTheWinAndWhatWouldBeWrongInIt) {
  for (const uint64_t moment : kMoments) {
    playTo(moment);
    SCOPED_TRACE(fmt::format("tick {}", moment));
    const Image right = draw();
    EXPECT_GOLDEN(right, momentName(moment), momentBounds());
    const Result<Image> golden = images::readImage(images::goldenPath(momentName(moment)));
    ASSERT_TRUE(golden.ok()) << golden.error();
    expectSwapsAreSeen(images::quantised(right), golden.value());
    expectTheSunIsMissed(golden.value());
    expectGrainsAreMissed(golden.value());
    EXPECT_SAME_IMAGE(draw(), right);  // what was spoiled is whole again
  }
}

}  // namespace
}  // namespace scree::hourglass
