// Broken images: each ends in one line that names the file and what is wrong with it.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "engine/assets/image.h"
#include "engine/core/random.h"
#include "tests/assets/gltf_builder.h"

namespace scree::test {
namespace {

// One line, the file's name first, then what is wrong.
void expectLine(const std::string& message, const std::string& file, const std::string& expected) {
  EXPECT_NE(message.find(file), std::string::npos) << message;
  EXPECT_NE(message.find(expected), std::string::npos)
      << "expected: " << expected << "\n  got: " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_LT(message.size(), 600u) << message;
}

void setWord(Bytes& bytes, size_t at, uint32_t value) {
  std::memcpy(bytes.data() + at, &value, 4);
}

void expectImageError(const Bytes& bytes, const std::string& name, const std::string& expected) {
  const TemporaryFolder folder;
  saveBytes(folder / name, bytes);
  const Result<ImageData> image = loadImage(folder / name, ColorEncoding::Srgb);
  ASSERT_FALSE(image.ok()) << name << ": " << expected;
  expectLine(image.error(), name, expected);
}

Bytes noise(size_t count) {
  Bytes bytes;
  for (size_t i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(i * i * 31 >> 3));
  return bytes;
}

Bytes makeJpeg(const TemporaryFolder& folder) {
  const Bytes pixels = noise(64 * 48 * 3);
  auto output = OIIO::ImageOutput::create("x.jpg");
  EXPECT_TRUE(
      output->open((folder / "x.jpg").string(), OIIO::ImageSpec(64, 48, 3, OIIO::TypeDesc::UINT8)));
  EXPECT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  output->close();
  return readAll(folder / "x.jpg");
}

// Bit by bit, unlike the loader's table.
uint32_t crc32(const uint8_t* bytes, size_t count) {
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < count; ++i)
    for (int bit = 0; bit < 8; ++bit) {
      const bool carry = ((crc ^ bytes[i] >> bit) & 1) != 0;
      crc = (crc >> 1) ^ (carry ? 0xedb88320u : 0u);
    }
  return ~crc;
}

TEST(MalformedImage, Png) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writePng(folder / "good.png", 64, 48, 3, noise(64 * 48 * 3)).ok());
  const Bytes good = readAll(folder / "good.png");
  const auto broken = [&](const std::function<void(Bytes&)>& break_it, const char* expected) {
    Bytes bytes = good;
    break_it(bytes);
    expectImageError(bytes, "bad.png", expected);
  };
  broken([](Bytes& b) { b.clear(); }, "content: empty");
  broken([](Bytes& b) { b.resize(8); }, "PNG: header");
  broken([](Bytes& b) { b.resize(30); }, "PNG");
  broken([](Bytes& b) { b.resize(b.size() / 2); }, "PNG: pixels");
  broken([](Bytes& b) { b.resize(b.size() - 12); }, "PNG: pixels: cut off at byte");
  broken([](Bytes& b) { b[12] = 'X'; }, "PNG: header: the IHDR chunk is missing");
  broken([](Bytes& b) { b[33] = 0x80; }, "PNG: pixels: the chunk at byte 33 has length = 2147");
  broken([](Bytes& b) { b[16] = 0x7f; }, "the chunk at byte 8 is damaged (CRC)");
  broken(
      [](Bytes& b) {
        for (size_t i = b.size() / 2; i < b.size() - 40; ++i) b[i] ^= 0x55;
      },
      "PNG: pixels");
  // Claims with a right checksum.
  const auto claimed = [&](size_t at, uint8_t value, const char* expected) {
    broken(
        [&](Bytes& b) {
          b[at] = value;
          const uint32_t crc = crc32(b.data() + 12, 17);
          for (size_t i = 0; i < 4; ++i) b[29 + i] = static_cast<uint8_t>(crc >> (24 - 8 * i));
        },
        expected);
  };
  claimed(16, 0x7f, "size = 2130706496x48; at most 16384 a side");
  claimed(22, 0x40, "size = 64x16432; at most 16384 a side");
  claimed(19, 0, "size = 0x48");
  claimed(19, 65, "PNG: pixels");  // a pixel more a row than there are
  claimed(24, 3, "PNG");           // bit depth
  claimed(25, 9, "PNG");           // color type
  broken([](Bytes& b) { std::memcpy(b.data(), "GIF89a", 6); },
         "content: neither PNG, JPEG nor EXR");
}

TEST(MalformedImage, Jpeg) {
  const TemporaryFolder folder;
  const Bytes good = makeJpeg(folder);
  ASSERT_TRUE(loadImage(folder / "x.jpg", ColorEncoding::Srgb).ok());
  size_t frame = 2;  // of the SOF0 marker
  while (frame + 4 < good.size() && good[frame + 1] != 0xc0)
    frame += 2 + (size_t{good[frame + 2]} << 8 | good[frame + 3]);
  const auto broken = [&](const std::function<void(Bytes&)>& break_it, const char* expected) {
    Bytes bytes = good;
    break_it(bytes);
    expectImageError(bytes, "bad.jpg", expected);
  };
  broken([](Bytes& b) { b.resize(3); }, "JPEG: header");
  broken([](Bytes& b) { b.resize(40); }, "JPEG");
  broken([](Bytes& b) { b.resize(b.size() / 2); }, "JPEG: pixels");
  broken([](Bytes& b) { b[2] = 0; }, "content: neither");
  broken([](Bytes& b) { b[4] = b[5] = 0; }, "JPEG: segment length = 0");
  broken([&](Bytes& b) { b[frame + 5] = b[frame + 6] = 0; }, "size = 64x0");
  broken([&](Bytes& b) { b[frame + 5] = b[frame + 7] = 0xff; }, "at most 16384 a side");
  broken([&](Bytes& b) { b[frame + 9] = 77; }, "JPEG");
}

TEST(MalformedImage, Exr) {
  const TemporaryFolder folder;
  std::vector<float> values(64 * 48 * 3, 0.25f);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i * 7919 % 1009);
  ASSERT_TRUE(
      writeExr(folder / "good.exr", 64, 48, std::vector<std::string>{"R", "G", "B"}, values).ok());
  const Bytes good = readAll(folder / "good.exr");
  const std::string text(good.begin(), good.end());
  const size_t window = text.find("dataWindow") + 11 + 6 + 4;
  const size_t compression = text.find("compression", 0) + 12 + 12 + 4;
  const auto broken = [&](const std::function<void(Bytes&)>& break_it, const char* expected) {
    Bytes bytes = good;
    break_it(bytes);
    expectImageError(bytes, "bad.exr", expected);
  };
  broken([](Bytes& b) { b.resize(5); }, "EXR: header: cut off");
  broken([](Bytes& b) { b.resize(60); }, "EXR: header");
  broken([](Bytes& b) { b.resize(b.size() / 2); }, "EXR");
  broken([](Bytes& b) { b[5] |= 0x10; }, "EXR: header: multi-part");
  broken([](Bytes& b) { b[5] |= 0x08; }, "EXR: header: deep");
  broken([](Bytes& b) { b[4] = 9; }, "EXR");
  broken([&](Bytes& b) { setWord(b, window + 12, 0x7ffffff0u); }, "size = 64x2147483633");
  broken([&](Bytes& b) { setWord(b, window, 0x80000000u); }, "at most 16384 a side");
  broken([&](Bytes& b) { setWord(b, window + 8, 0xfffffff0u); }, "size = -15x48");
  broken([&](Bytes& b) { b[text.find("dataWindow")] = 'X'; }, "EXR: header: dataWindow is missing");
  broken([&](Bytes& b) { setWord(b, window - 4, 0x7fffffff); },
         "EXR: header: size of an attribute");
  broken([&](Bytes& b) { b[compression] = 99; }, "EXR");
  broken(
      [](Bytes& b) {
        for (size_t i = b.size() / 2; i < b.size(); ++i) b[i] = 0xee;
      },
      "EXR: pixels");
}

}  // namespace
}  // namespace scree::test
