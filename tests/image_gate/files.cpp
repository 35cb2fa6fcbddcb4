// Tests of golden files: reading, writing, updating, and what a failure leaves behind.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "engine/core/file.h"
#include "tests/image_gate/pictures.h"
#include "tests/support/image_expect.h"

namespace scree::images {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(SCREE_BINARY_DIR) / "image_gate_files" /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    setenv("SCREE_FAILURES", (folder_ / "failures").c_str(), 1);
    unsetenv("SCREE_UPDATE_GOLDENS");
  }
  void TearDown() override {
    unsetenv("SCREE_FAILURES");
    unsetenv("SCREE_UPDATE_GOLDENS");
  }
  fs::path golden() const { return folder_ / "heap" / "golden" / "far.png"; }
  fs::path failure(const char* suffix) const {
    return folder_ / "failures" / (std::string("heap_far") + suffix);
  }
  GateResult update(const Image& image) const {
    setenv("SCREE_UPDATE_GOLDENS", "1", 1);
    GateResult result = gate(image, golden());
    unsetenv("SCREE_UPDATE_GOLDENS");
    return result;
  }
  fs::path folder_;
};

Image picture() {
  Image image = quantised(discScene(48, 32, {{20, 12, 7}, {33, 20, 6}}));
  const uint32_t hard[] = {0xffffffffu, 0x80000001u, 0x00ffffffu, 0xff000000u, 0x01020304u, 1u};
  std::copy(std::begin(hard), std::end(hard), image.ids.begin());
  return image;
}

TEST_F(Files, RoundTripIsLossless) {
  const Image image = picture();
  ASSERT_TRUE(writeImage(golden(), image).ok());
  auto back = readImage(golden());
  ASSERT_TRUE(back.ok()) << back.error();
  EXPECT_EQ(back->rgb, image.rgb);
  EXPECT_EQ(back->ids, image.ids) << "all 32 bits, also where the alpha byte is 0";
  Image plain = withoutIds(image);
  ASSERT_TRUE(writeImage(golden(), plain).ok());
  EXPECT_FALSE(fs::exists(idPath(golden()))) << "no ids: no stale id file";
}

TEST_F(Files, AllByteValuesSurvive) {
  Image ramp = flatImage(256, 16, 0, 0, 0);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 256; ++x)
      setPixel(ramp, x, y, x / 255.0f, (255 - x) / 255.0f, (x ^ 0x55) / 255.0f);
  }
  ASSERT_TRUE(writeImage(golden(), ramp).ok());
  EXPECT_EQ(readImage(golden()).value().rgb, ramp.rgb);
}

TEST_F(Files, MissingGoldenFailsAndIsNotWritten) {
  const GateResult result = gate(picture(), golden());
  EXPECT_FALSE(result.passed);
  EXPECT_EQ(result.check, "golden");
  EXPECT_NE(result.message.find("--update-goldens"), std::string::npos) << result.message;
  EXPECT_FALSE(fs::exists(golden()));
  EXPECT_TRUE(fs::exists(failure(".actual.png")));
}

TEST_F(Files, OnlyTheExplicitCommandWrites) {
  ASSERT_TRUE(update(picture()).passed);
  auto before = readBytes(golden());
  ASSERT_TRUE(before.ok());
  EXPECT_TRUE(gate(picture(), golden(), exactBounds()).passed);
  Image other = picture();
  setPixel(other, 5, 25, 1, 1, 1);
  EXPECT_FALSE(gate(other, golden()).passed);
  for (const char* value : {"0", "", "true", "yes"}) {
    setenv("SCREE_UPDATE_GOLDENS", value, 1);
    EXPECT_FALSE(gate(other, golden()).passed) << value;
  }
  unsetenv("SCREE_UPDATE_GOLDENS");
  EXPECT_EQ(readBytes(golden()).value(), before.value()) << "failing runs leave the golden alone";
  ASSERT_TRUE(update(other).passed);
  EXPECT_TRUE(gate(other, golden(), exactBounds()).passed);
  EXPECT_FALSE(gate(picture(), golden()).passed);
}

TEST_F(Files, SpoiledImagesNeverBecomeGoldens) {
  Image bad = picture();
  bad.rgb[100] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(update(bad).check, "finite");
  EXPECT_EQ(update(flatImage(48, 32, 0, 0, 0)).check, "content");
  EXPECT_FALSE(fs::exists(golden()));
}

TEST_F(Files, BlackGoldenFails) {
  ASSERT_TRUE(writeImage(golden(), flatImage(48, 32, 0, 0, 0)).ok());
  EXPECT_EQ(gate(flatImage(48, 32, 0, 0, 0), golden()).check, "content");
  EXPECT_EQ(gate(withoutIds(picture()), golden()).check, "content");
}

TEST_F(Files, DamagedGoldenFails) {
  ASSERT_TRUE(update(picture()).passed);
  auto bytes = readBytes(golden());
  ASSERT_TRUE(bytes.ok());
  ASSERT_TRUE(writeFile(golden(), std::string_view(reinterpret_cast<const char*>(bytes->data()),
                                                   bytes->size() / 2))
                  .ok());
  EXPECT_EQ(gate(picture(), golden()).check, "golden");
}

TEST_F(Files, FailureLeavesThreePicturesAndSuccessRemovesThem) {
  ASSERT_TRUE(update(picture()).passed);
  Image other = picture();
  setPixel(other, 40, 5, 0, 0, 0);
  const GateResult result = gate(other, golden());
  EXPECT_FALSE(result.passed);
  EXPECT_EQ(result.picture, failure(".difference.png"));
  EXPECT_NE(result.message.find(result.picture.string()), std::string::npos);
  EXPECT_EQ(readImage(failure(".actual.png")).value().rgb, other.rgb);
  EXPECT_EQ(readImage(failure(".golden.png")).value().rgb, picture().rgb);
  auto strip = readImage(result.picture);
  ASSERT_TRUE(strip.ok());
  EXPECT_EQ(strip->width, 3 * 48 + 8);
  // The third panel is black but for the pixel that differs.
  int lit = 0;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 48; ++x) {
      const float* rgb = &strip->rgb[(static_cast<size_t>(y) * strip->width + 2 * 48 + 8 + x) * 3];
      if (rgb[0] + rgb[1] + rgb[2] > 0) {
        ++lit;
        EXPECT_EQ(std::pair(x, y), std::pair(40, 5));
      }
    }
  }
  EXPECT_EQ(lit, 1);
  EXPECT_TRUE(gate(picture(), golden()).passed);
  for (const char* suffix :
       {".actual.png", ".actual.id.png", ".golden.png", ".golden.id.png", ".difference.png"}) {
    EXPECT_FALSE(fs::exists(failure(suffix))) << suffix;
  }
}

TEST_F(Files, PictureMarksPixelsWhoseIdDiffers) {
  Image other = picture();
  other.ids[5 * 48 + 40] = 9;
  const Image seen = differencePicture(other, picture());
  const float* rgb = &seen.rgb[(5 * static_cast<size_t>(seen.width) + 2 * 48 + 8 + 40) * 3];
  EXPECT_EQ((std::array{rgb[0], rgb[1], rgb[2]}), (std::array{1.0f, 0.0f, 1.0f}));
}

TEST_F(Files, NotFiniteImageIsWrittenWithItsPixelsMarked) {
  ASSERT_TRUE(update(picture()).passed);
  Image bad = picture();
  bad.rgb[(5 * 48 + 40) * 3] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(gate(bad, golden()).check, "finite");
  const Image seen = readImage(failure(".actual.png")).value();
  EXPECT_EQ(seen.rgb[(5 * 48 + 40) * 3], 1);
  EXPECT_EQ(seen.rgb[(5 * 48 + 40) * 3 + 1], 0);
}

TEST_F(Files, ActualIsRoundedToTheGoldensBits) {
  Image image = picture();
  ASSERT_TRUE(update(image).passed);
  for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] += (i % 2 ? 0.4f : -0.4f) / 255;
  EXPECT_TRUE(gate(image, golden(), exactBounds()).passed);
  EXPECT_FALSE(compareImages(image, picture(), exactBounds()).passed)
      << "without a file, floats are compared";
}

TEST_F(Files, ExpectationsReport) {
  EXPECT_SAME_IMAGE(picture(), picture());
  Image other = picture();
  setPixel(other, 40, 5, 0, 0, 0);
  EXPECT_FALSE(asAssertion(compareImages(other, picture())));
  EXPECT_SAME_IMAGE(withNoise(picture(), 1), picture(), crossMachineBounds());
}

TEST(Convert, RowsAndCurve) {
  const uint8_t bytes[] = {255, 0, 0, 9, 0, 255, 0, 9};  // two rows of one pixel, RGBA
  const Image up = imageFromBytes(1, 2, 4, bytes, RowOrder::BottomUp);
  EXPECT_EQ(up.rgb, (std::vector<float>{0, 1, 0, 1, 0, 0}));
  const Image down = imageFromBytes(1, 2, 4, bytes);
  EXPECT_EQ(down.rgb, (std::vector<float>{1, 0, 0, 0, 1, 0}));
  const float inf = std::numeric_limits<float>::infinity();
  const float linear[] = {0.2158605f, 4.0f, inf};
  const Image encoded = imageFromLinear(1, 1, 3, linear);
  EXPECT_NEAR(encoded.rgb[0], 128 / 255.0, 1e-3) << "middle grey";
  EXPECT_EQ(encoded.rgb[1], 1);
  EXPECT_EQ(encoded.rgb[2], inf) << "clamping must not hide it";
  for (double v = 0; v <= 1; v += 0.01) EXPECT_NEAR(linearFromSrgb(srgbFromLinear(v)), v, 1e-7);
  Image with_ids = up;
  setIds(with_ids, std::vector<uint32_t>{5, 6}, RowOrder::BottomUp);
  EXPECT_EQ(with_ids.ids, (std::vector<uint32_t>{6, 5}));
}

}  // namespace
}  // namespace scree::images
