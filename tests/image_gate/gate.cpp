// Tests of the gate: what must fail fails, at the right check, and what must pass passes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/image_gate/pictures.h"
#include "tests/support/image_gate.h"

namespace scree::images {
namespace {

constexpr int kWidth = 1280, kHeight = 720;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

const std::vector<Disc>& discs() {
  static const std::vector<Disc> strewn = strewnDiscs(kWidth, kHeight, 400, 12, 11);
  return strewn;
}
// 400 discs of 24 px and one of 6 px.
const Image& scene() {
  static const Image image = [] {
    std::vector<Disc> all = discs();
    all.push_back({640.5, 300.5, 3});
    return quantised(discScene(kWidth, kHeight, all));
  }();
  return image;
}
// The middle of the scene, for comparisons that differ everywhere.
Image middle() {
  Image part{480, 270, std::vector<float>(480 * 270 * 3), {}};
  for (int y = 0; y < 270; ++y) {
    std::copy_n(&scene().rgb[((y + 225) * static_cast<size_t>(kWidth) + 400) * 3], 480 * 3,
                &part.rgb[static_cast<size_t>(y) * 480 * 3]);
  }
  return part;
}

Image small() {
  return quantised(discScene(64, 48, strewnDiscs(64, 48, 5, 5, 3)));
}

// Fails at `check` under the loosest bounds that the project uses by default.
void expectFails(const Image& actual, const Image& golden, const std::string& check) {
  const GateResult result = compareImages(actual, golden, crossMachineBounds());
  EXPECT_FALSE(result.passed) << result.message;
  EXPECT_EQ(result.check, check) << result.message;
  EXPECT_FALSE(result.message.empty());
}

TEST(Finite, OneNanOneInfinityAndAllNanFail) {
  const Image good = small();
  for (float bad : {kNan, kInf, -kInf}) {
    for (size_t at : {size_t{0}, good.rgb.size() / 2, good.rgb.size() - 1}) {
      Image spoiled = good;
      spoiled.rgb[at] = bad;
      expectFails(spoiled, good, "finite");
      expectFails(good, spoiled, "finite");
      expectFails(spoiled, spoiled, "finite");
    }
    Image all = good;
    all.rgb.assign(all.rgb.size(), bad);
    expectFails(all, all, "finite");
    expectFails(all, good, "finite");
  }
  Image one = good;
  one.rgb[(5 * 64 + 7) * 3 + 1] = kNan;
  EXPECT_NE(compareImages(one, good).message.find("channel 1 of pixel (7, 5)"), std::string::npos);
}

TEST(Content, BlackAndUniformPicturesFailEvenWhenEqual) {
  for (float grey : {0.0f, 0.5f, 1.0f}) {
    const Image flat = flatImage(320, 200, grey, grey, grey);
    expectFails(flat, flat, "content");
    expectFails(small(), flatImage(64, 48, grey, grey, grey), "content");
    expectFails(flatImage(64, 48, grey, grey, grey), small(), "content");
  }
  // Noise of one step is no content; one lit pixel is not either.
  Image noise = withNoise(flatImage(320, 200, 0.5f, 0.5f, 0.5f), 1);
  expectFails(noise, noise, "content");
  Image one = flatImage(320, 200, 0, 0, 0);
  setPixel(one, 100, 100, 1, 1, 1);
  expectFails(one, one, "content");
  Image lit = flatImage(320, 200, 0, 0, 0);
  for (int y = 50; y < 60; ++y) {
    for (int x = 50; x < 60; ++x) setPixel(lit, x, y, 1, 1, 1);
  }
  EXPECT_TRUE(compareImages(lit, lit).passed) << "a hundred lit pixels are content";
  EXPECT_NE(compareImages(one, one).message.find("uniform"), std::string::npos);
  const Image black = flatImage(320, 200, 0, 0, 0);
  EXPECT_NE(compareImages(black, black).message.find("black"), std::string::npos);
}

TEST(Size, OtherSizesFail) {
  expectFails(discScene(64, 47, {{20, 20, 8}}), small(), "size");
  expectFails(Image{}, small(), "size");
  expectFails(discScene(10, 48, {{5, 20, 4}}), discScene(10, 48, {{5, 20, 4}}), "size");
  Image torn = small();
  torn.rgb.pop_back();
  expectFails(torn, small(), "size");
}

TEST(Equal, PassesExactly) {
  const GateResult result = compareImages(scene(), scene(), exactBounds());
  EXPECT_TRUE(result.passed) << result.message;
  EXPECT_EQ(result.max_difference, 0);
  EXPECT_EQ(result.similarity.mean, 1);
  EXPECT_EQ(result.mean_flip, 0);
}

TEST(Exact, OneStepOfOneChannelOfOnePixelFails) {
  Image moved = scene();
  moved.rgb[12345] += moved.rgb[12345] > 0.5f ? -1 / 255.0f : 1 / 255.0f;
  const GateResult result = compareImages(moved, scene(), exactBounds());
  EXPECT_FALSE(result.passed);
  EXPECT_EQ(result.check, "max");
  EXPECT_TRUE(compareImages(moved, scene(), crossMachineBounds()).passed);
}

TEST(LostGrain, OneDeletedDiscOfSixPixelsFails) {
  const Image without = quantised(discScene(kWidth, kHeight, discs()));
  size_t changed = 0;
  for (size_t i = 0; i < without.ids.size(); ++i) changed += without.ids[i] != scene().ids[i];
  EXPECT_GE(changed, 24u);
  EXPECT_LE(changed, 32u) << "6 px across, 0.003 % of the picture";
  expectFails(without, scene(), "id");
  expectFails(withoutIds(without), withoutIds(scene()), "max");
  // Nor do allowances for silhouettes hide it: its pixels hang together.
  for (const bool ids : {true, false}) {
    const GateResult result =
        compareImages(ids ? without : withoutIds(without), ids ? scene() : withoutIds(scene()),
                      crossMachineBounds(200));
    EXPECT_FALSE(result.passed) << result.message;
    EXPECT_GE(result.largest_stray_group, 24);
  }
}

// Each later check on its own catches the lost grain or the slip, when those before are loose.
TEST(Checks, EachCatchesWhenThoseBeforeAreLoose) {
  const Image golden = withoutIds(scene());
  const Image lost = withoutIds(quantised(discScene(kWidth, kHeight, discs())));
  GateBounds bounds = crossMachineBounds();
  bounds.max_difference = 1;
  EXPECT_EQ(compareImages(lost, golden, bounds).check, "ssim");
  bounds.min_local_ssim = -1;
  EXPECT_EQ(compareImages(lost, golden, bounds).check, "flip") << "the mean SSIM forgives it";
  bounds.max_local_flip = 1;
  const GateResult forgiven = compareImages(lost, golden, bounds);
  EXPECT_TRUE(forgiven.passed) << "percentile and means forgive a lost grain: " << forgiven.message;
  EXPECT_LT(forgiven.p999, 1e-6);

  const Image plain = middle();
  const Image brighter = quantised(recoloured(plain, [](int c, float r, float g, float b) {
    return std::min(1.0f, (c == 0 ? r : c == 1 ? g : b) + 1 / 255.0f);
  }));
  bounds = crossMachineBounds();
  EXPECT_EQ(compareImages(brighter, plain, bounds).check, "flip");
  bounds.max_flip = 1;
  EXPECT_EQ(compareImages(brighter, plain, bounds).check, "mean");
  bounds.max_mean_difference = 1;
  EXPECT_EQ(compareImages(brighter, plain, bounds).check, "mean") << "the bias";
  bounds.max_bias = 1;
  EXPECT_TRUE(compareImages(brighter, plain, bounds).passed);
}

TEST(Checks, PercentileSeesTwoPixelsInAThousand) {
  const Image golden = middle();
  const auto spoiled = [&](int every) {
    Image image = golden;
    for (size_t i = 0; i < image.pixels(); i += every) {
      float& green = image.rgb[i * 3 + 1];
      green += green < 0.5f ? 2 / 255.0f : -2 / 255.0f;
    }
    return image;
  };
  EXPECT_EQ(compareImages(spoiled(500), golden, crossMachineBounds()).check, "p999");
  EXPECT_TRUE(compareImages(spoiled(2000), golden, crossMachineBounds()).passed);
}

// The gate measures only around what differs; the figures are those of the whole pictures.
TEST(Checks, FiguresAreOfTheWholePicture) {
  GateBounds loose = crossMachineBounds(1000);
  loose.max_difference = loose.max_p999 = 1;
  const Image golden = withoutIds(quantised(discScene(200, 120, strewnDiscs(200, 120, 20, 6, 5))));
  for (const auto& [x, y] : {std::pair{0, 0}, {199, 119}, {100, 60}, {3, 100}, {199, 50}}) {
    Image other = golden;
    setPixel(other, x, y, 1, 0, 1);
    setPixel(other, std::min(x + 4, 199), y, 0, 1, 0);
    const GateResult result = compareImages(other, golden, loose);
    const Similarity similarity = ssim(other, golden);
    const Flip seen = flip(other, golden);
    EXPECT_NEAR(result.similarity.mean, similarity.mean, 1e-9) << x << ", " << y;
    EXPECT_NEAR(result.similarity.local, similarity.local, 1e-9);
    EXPECT_NEAR(result.mean_flip, seen.mean, 1e-9) << x << ", " << y;
    EXPECT_NEAR(result.local_flip, seen.local, 1e-9);
  }
}

// A disc of 6 px that differs from the ground by 3 steps of 8 bits.
TEST(LostGrain, FaintDiscFails) {
  Image golden = withoutIds(quantised(discScene(320, 200, {{100, 150, 20}})));
  const Image without = golden;
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 6; ++x) {
      if (std::hypot(x - 2.5, y - 2.5) >= 3) continue;
      float* rgb = &golden.rgb[((150 + static_cast<size_t>(y)) * 320 + 200 + x) * 3];
      for (int c = 0; c < 3; ++c) rgb[c] += 3 / 255.0f;
    }
  }
  expectFails(without, golden, "max");
}

TEST(Wrong, ChannelSwapShiftGammaFlipFail) {
  const Image golden = quantised(discScene(480, 270, strewnDiscs(480, 270, 60, 10, 13)));
  const Image plain = withoutIds(golden);
  const auto pick = [](int c, float r, float g, float b) { return c == 0 ? r : c == 1 ? g : b; };
  expectFails(
      recoloured(golden, [&](int c, float r, float g, float b) { return pick(c, b, g, r); }),
      golden, "max");
  expectFails(
      recoloured(golden, [&](int c, float r, float g, float b) { return pick(c, r, b, g); }),
      golden, "max");
  for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    const auto shift = [&](int x, int y) { return std::pair{x + dx, y + dy}; };
    expectFails(remapped(golden, shift), golden, "id");
    expectFails(remapped(plain, shift), plain, "max");
  }
  expectFails(remapped(plain, [](int x, int y) { return std::pair{x, 269 - y}; }), plain, "max");
  expectFails(remapped(plain, [](int x, int y) { return std::pair{479 - x, y}; }), plain, "max");
  // 2.2 instead of the sRGB curve; encoded twice; not encoded.
  const auto gamma = [&](auto&& curve) {
    return quantised(recoloured(plain, [&](int c, float r, float g, float b) {
      return static_cast<float>(curve(pick(c, r, g, b)));
    }));
  };
  expectFails(gamma([](double s) { return std::pow(linearFromSrgb(s), 1 / 2.2); }), plain, "max");
  expectFails(gamma([](double s) { return srgbFromLinear(s); }), plain, "max");
  expectFails(gamma([](double s) { return linearFromSrgb(s); }), plain, "max");
}

TEST(Noise, OneStepPassesAcrossMachines) {
  for (uint64_t seed : {1, 2, 3}) {
    const GateResult result =
        compareImages(withNoise(middle(), seed), middle(), crossMachineBounds());
    EXPECT_TRUE(result.passed) << result.message;
    std::printf("seed %d: %s\n", static_cast<int>(seed), result.message.c_str());
  }
  // In the dark, where FLIP is most sensitive, too.
  const Image dark = quantised(recoloured(middle(), [](int c, float r, float g, float b) {
    return 0.15f * (c == 0 ? r : c == 1 ? g : b);
  }));
  const GateResult result = compareImages(withNoise(dark, 4), dark, crossMachineBounds());
  EXPECT_TRUE(result.passed) << result.message;
  std::printf("dark: %s\n", result.message.c_str());
}

TEST(Noise, StrongNoiseFails) {
  Image noisy = withoutIds(scene());
  for (size_t i = 0; i < noisy.rgb.size(); ++i) {
    noisy.rgb[i] = std::clamp(noisy.rgb[i] + (std::floor(randomUnit(9, i, 0, 0) * 5) - 2) / 255.0f,
                              0.0f, 1.0f);
  }
  expectFails(noisy, withoutIds(scene()), "p999");
}

TEST(Stray, AllowedOnlyInNumberAndInSmallGroups) {
  const auto spoil = [](std::initializer_list<std::pair<int, int>> pixels, bool id_only) {
    Image image = scene();
    for (const auto& [x, y] : pixels) {
      if (!id_only) setPixel(image, x, y, 1, 0, 1);
      image.ids[static_cast<size_t>(y) * kWidth + x] = 77777;
    }
    return image;
  };
  for (bool id_only : {false, true}) {
    const Image three = spoil({{10, 10}, {11, 11}, {500, 400}}, id_only);
    EXPECT_EQ(compareImages(three, scene(), crossMachineBounds()).check, "id") << "default: none";
    EXPECT_EQ(compareImages(three, scene(), crossMachineBounds(2)).check, "id");
    const GateResult allowed = compareImages(three, scene(), crossMachineBounds(3));
    EXPECT_TRUE(allowed.passed) << allowed.message;
    EXPECT_EQ(allowed.stray_pixels, 3);
    EXPECT_EQ(allowed.different_ids, 3);
    EXPECT_EQ(allowed.largest_stray_group, 2) << "corners touch";
    const Image row = spoil({{10, 10}, {11, 10}, {12, 10}}, id_only);
    EXPECT_EQ(compareImages(row, scene(), crossMachineBounds(3)).check, "id") << "a group of three";
  }
  Image colour_only = withoutIds(scene());
  setPixel(colour_only, 10, 10, 1, 0, 1);
  EXPECT_EQ(compareImages(colour_only, withoutIds(scene()), crossMachineBounds()).check, "max");
  EXPECT_TRUE(compareImages(colour_only, withoutIds(scene()), crossMachineBounds(1)).passed);
}

TEST(Ids, OneImageWithoutIdsFails) {
  expectFails(withoutIds(scene()), scene(), "id");
  expectFails(scene(), withoutIds(scene()), "id");
}

TEST(Ids, TwoSwappedGrainsOfTheSameColourFail) {
  Image swapped = scene();
  for (uint32_t& id : swapped.ids) id = id == 1 ? 2 : id == 2 ? 1 : id;
  expectFails(swapped, scene(), "id");
}

}  // namespace
}  // namespace scree::images
