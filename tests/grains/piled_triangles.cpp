// Many triangles of a mesh in one place: repetitions count once, and what is left must not make searches long.
#include <gtest/gtest.h>

#include <cmath>

#include "modules/grains/surface_field.h"
#include "modules/grains/triangle_surface.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

// A point on the unit circle, by an angle in turns.
vec3 onCircle(double turns, float y = 0) {
  return {static_cast<float>(std::cos(2 * kPi * turns)), y, static_cast<float>(std::sin(2 * kPi * turns))};
}

// Slices around a middle, seen from above.
Soup disc(int slices) {
  Soup soup;
  for (int k = 0; k < slices; ++k) addTriangle(soup, vec3(0), onCircle((k + 1.0) / slices), onCircle(1.0 * k / slices));
  return soup;
}

TEST(PiledTriangles, RepeatedOnesCountOnce) {
  const Soup once = bumpySoup(2, 5);
  Soup many = once;
  for (size_t round = 0; round < 40; ++round)
    for (size_t k = 0; k < once.size(); k += 3)  // any corner may come first
      for (size_t c = 0; c < 3; ++c) many.push_back(once[k + (c + round) % 3]);
  TriangleSurface single, piled;
  ASSERT_EQ(single.build(once), "");
  ASSERT_EQ(piled.build(many), "");
  EXPECT_EQ(piled.triangles(), once.size() / 3);
  EXPECT_TRUE(piled.closed());
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec3 p = 3.0f * unitCube(7, k) - 1.5f;
    const TriangleSurface::Nearest a = single.nearest(p, 1e9), b = piled.nearest(p, 1e9);
    ASSERT_EQ(a.square, b.square) << k;
    ASSERT_EQ(a.outward, b.outward) << k;
  }
}

// What turns the other way is another triangle; so is one that has no area, which closes cracks.
TEST(PiledTriangles, BothSidesOfASheetStay) {
  Soup soup;
  addTriangle(soup, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  addTriangle(soup, {0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  addTriangle(soup, {-0.0f, 0, 0}, {0, -0.0f, 1}, {1, 0, 0});  // the first, by other zeros
  TriangleSurface surface;
  ASSERT_EQ(surface.build(soup), "");
  EXPECT_EQ(surface.triangles(), 2u);
  EXPECT_TRUE(surface.closed());
}

TEST(PiledTriangles, TooManyInOnePlaceAreRefused) {
  // Among 20,000 that lie apart, some that are almost the same.
  const auto heap = [](int count) {
    Soup soup;
    for (uint64_t k = 0; k < 20000; ++k) {
      const vec3 at = 100.0f * unitCube(21, k);
      addTriangle(soup, at, at + vec3(0.1f, 0, 0), at + vec3(0, 0, 0.1f));
    }
    for (int k = 0; k < count; ++k) {
      const vec3 at = vec3(50) + 1e-3f * unitCube(22, static_cast<uint64_t>(k));
      addTriangle(soup, at, at + vec3(1, 0, 0), at + vec3(0, 1, 1));
    }
    return soup;
  };
  const Result<SharedField> few = makeMesh(heap(kMostInOnePlace - 10), false, 0);
  EXPECT_TRUE(few.ok()) << few.error();
  const Soup many = heap(2 * kMostInOnePlace);
  for (const Result<SharedField>& refused : {makeMesh(many, false, 0), makeMesh(many, true, 0), bakeMesh(many, 8)}) {
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().find("more than 1024 of its triangles are around (50."), std::string::npos) << refused.error();
    EXPECT_NE(refused.error().find("allowed are 1024"), std::string::npos) << refused.error();
  }
}

// Slices of a disc, and the caps of a finely divided rod, are not piles.
TEST(PiledTriangles, FansAreTaken) {
  const Result<SharedField> slices = makeMesh(disc(4096), false, 0);
  EXPECT_TRUE(slices.ok()) << slices.error();
  Soup rod;
  constexpr int kSides = 20000;
  for (int k = 0; k < kSides; ++k)
    addTriangle(rod, onCircle(1.0 * k / kSides, -1), onCircle(1.0 * k / kSides, 1), onCircle((k + 0.5) / kSides, 1));
  const Result<SharedField> hull = makeHull(rod);
  EXPECT_TRUE(hull.ok()) << hull.error();
}

}  // namespace
}  // namespace scree::grains::test
