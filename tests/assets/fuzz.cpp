// Damaged files, by the thousand: nothing crashes, and what still loads is sound.
//
// SCREE_FUZZ_SECONDS (default 2 a test) and SCREE_FUZZ_SEED (default 1) change the run. Run under
// ASan and UBSan to see what a release build forgives.
#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "engine/assets/gltf.h"
#include "engine/core/log.h"
#include "engine/core/random.h"
#include "tests/assets/gltf_builder.h"

namespace scree::test {
namespace {

double seconds() {
  const char* set = std::getenv("SCREE_FUZZ_SECONDS");
  return set != nullptr ? std::atof(set) : 2.0;
}
uint64_t firstSeed() {
  const char* set = std::getenv("SCREE_FUZZ_SEED");
  return set != nullptr ? std::strtoull(set, nullptr, 10) : 1;
}

class Dice {
 public:
  explicit Dice(uint64_t seed) : seed_(seed) {}
  size_t below(size_t bound) { return bound == 0 ? 0 : randomBits(seed_, 0, 0, draw_++) % bound; }

 private:
  uint64_t seed_;
  uint64_t draw_ = 0;
};

const uint32_t kNastyWords[] = {0,          1,          2,          3,          4,
                                0x7f,       0x80,       0xff,       0xffff,     0x7fffffff,
                                0x80000000, 0xffffffff, 0xfffffff0, 0x7f800000, 0x7fc00000,
                                0x00010000, 0x40000000};

// Bit flips, nasty words, truncation, removal, and splices of the file into itself.
void mutate(Bytes& bytes, Dice& dice) {
  for (size_t times = 1 + dice.below(4); times > 0 && !bytes.empty(); --times) {
    const size_t at = dice.below(bytes.size());
    switch (dice.below(6)) {
      case 0:
        bytes[at] ^= static_cast<uint8_t>(1u << dice.below(8));
        break;
      case 1:
        bytes[at] = static_cast<uint8_t>(dice.below(256));
        break;
      case 2: {
        const uint32_t word = kNastyWords[dice.below(std::size(kNastyWords))];
        std::memcpy(bytes.data() + at, &word, std::min<size_t>(4, bytes.size() - at));
        break;
      }
      case 3:
        bytes.resize(at);
        break;
      case 4: {
        const size_t count = dice.below(std::min<size_t>(64, bytes.size() - at));
        bytes.erase(bytes.begin() + static_cast<ptrdiff_t>(at),
                    bytes.begin() + static_cast<ptrdiff_t>(at + count));
        break;
      }
      default: {
        const size_t from = dice.below(bytes.size());
        const size_t count = dice.below(std::min<size_t>(256, bytes.size() - from));
        const Bytes piece(bytes.begin() + static_cast<ptrdiff_t>(from),
                          bytes.begin() + static_cast<ptrdiff_t>(from + count));
        bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(at), piece.begin(), piece.end());
      }
    }
  }
}

// Makes the checksums of a damaged PNG right, so that the damage reaches the decoder.
void repairChecksums(Bytes& png) {
  for (size_t at = 8; at + 12 <= png.size();) {
    size_t length = 0;
    for (size_t i = 0; i < 4; ++i) length = length << 8 | png[at + i];
    if (length > png.size() - at - 12) return;
    uint32_t crc = 0xffffffffu;
    for (size_t i = at + 4; i < at + 8 + length; ++i) {
      crc ^= png[i];
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    for (size_t i = 0; i < 4; ++i)
      png[at + 8 + length + i] = static_cast<uint8_t>(~crc >> (24 - 8 * i));
    at += 12 + length;
  }
}

// Every value of a document, by pointer.
void collect(json& value, std::vector<json*>& all) {
  all.push_back(&value);
  if (value.is_structured())
    for (json& child : value) collect(child, all);
}

void mutate(json& doc, Dice& dice) {
  static const json values =
      json::parse(R"([-1, 0, 1, 2, 3, 5, 7, 1000, 65535, 2147483647, 2147483648,
    4294967295, 9007199254740992, 18446744073709551615, -9223372036854775808, 0.5, 1e30, -1e30, 1e300,
    "", "POSITION", "../x", "VEC3", "MAT4", null, true, [], {}, [[]], [0, 0, 0], 5120, 5125, 5126])");
  for (size_t times = 1 + dice.below(3); times > 0; --times) {
    std::vector<json*> all;
    collect(doc, all);
    json& victim = *all[dice.below(all.size())];
    switch (dice.below(5)) {
      case 0:
        if (victim.is_object() && !victim.empty()) {
          auto at = victim.begin();
          std::advance(at, static_cast<ptrdiff_t>(dice.below(victim.size())));
          victim.erase(at.key());
        }
        break;
      case 1:
        if (victim.is_array() && !victim.empty())
          victim.push_back(victim[dice.below(victim.size())]);
        break;
      case 2: {
        const json copy = *all[dice.below(all.size())];
        victim = copy;
        break;
      }
      default:
        victim = values[dice.below(values.size())];
    }
  }
}

// What loadGltf promises about a scene.
void expectSound(const SceneData& scene) {
  const auto within = [](int index, size_t count) {
    return index >= -1 && index < static_cast<int>(count);
  };
  for (const MeshData& mesh : scene.meshes) {
    ASSERT_TRUE(within(mesh.material, scene.materials.size()));
    ASSERT_EQ(mesh.indices.size() % 3, 0u);
    for (uint32_t index : mesh.indices) ASSERT_LT(index, mesh.vertices.size());
    for (const Vertex& v : mesh.vertices)
      for (int c = 0; c < 3; ++c) {
        ASSERT_TRUE(std::isfinite(v.position[c]) && std::isfinite(v.normal[c]));
        ASSERT_TRUE(std::isfinite(v.tangent[c]) && std::isfinite(v.uv[c % 2]));
      }
  }
  for (const MaterialData& material : scene.materials)
    for (const TextureUse* use : {&material.base_color_map, &material.metallic_roughness_map,
                                  &material.normal_map, &material.emissive_map})
      ASSERT_TRUE(within(use->image, scene.images.size()));
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const NodeData& node = scene.nodes[i];
    ASSERT_LT(node.parent, static_cast<int>(i));
    ASSERT_TRUE(within(node.camera, scene.cameras.size()) &&
                within(node.light, scene.lights.size()));
    ASSERT_LE(node.first_mesh + node.mesh_count, static_cast<int>(scene.meshes.size()));
    for (int c = 0; c < 3; ++c)
      ASSERT_TRUE(std::isfinite(node.position[c]) && std::isfinite(node.scale[c]) &&
                  node.scale[c] != 0);
    ASSERT_NEAR(node.rotation.x * node.rotation.x + node.rotation.y * node.rotation.y +
                    node.rotation.z * node.rotation.z + node.rotation.w * node.rotation.w,
                1, 1e-4);
  }
}

void expectMessage(const std::string& message, const std::string& file) {
  ASSERT_EQ(message.find('\n'), std::string::npos) << message;
  ASSERT_NE(message.find(file), std::string::npos) << message;
  ASSERT_LT(message.size(), 1000u);
}

// Calls body(seed) with growing seeds until the time is over; body tells whether the file loaded.
void repeat(const char* what, const std::function<bool(uint64_t)>& body) {
  setLogLevel(LogLevel::Error);
  const auto begin = std::chrono::steady_clock::now();
  const uint64_t first = firstSeed();
  uint64_t seed = first;
  size_t loaded = 0;
  do {
    loaded += body(seed);
    if (::testing::Test::HasFailure()) {
      ADD_FAILURE() << what << ": SCREE_FUZZ_SEED=" << seed;
      break;
    }
    ++seed;
  } while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() <
           seconds());
  std::printf("%s: seeds %llu to %llu, %zu still loaded\n", what,
              static_cast<unsigned long long>(first), static_cast<unsigned long long>(seed - 1),
              loaded);
  setLogLevel(LogLevel::Info);
}

bool loads(const std::filesystem::path& path) {
  Result<SceneData> scene = loadGltf(path);
  if (scene.ok())
    expectSound(*scene);
  else
    expectMessage(scene.error(), path.filename().string());
  return scene.ok();
}

TEST(Fuzz, GltfFields) {
  const TemporaryFolder folder;
  const GltfBuilder good = [&] {
    GltfBuilder b = fullFile(folder);
    b.setBuffer(json::object());
    return b;
  }();
  repeat("glTF fields", [&](uint64_t seed) {
    Dice dice(seed);
    json doc = good.doc;
    mutate(doc, dice);
    saveBytes(folder / "fields.glb", glbOf(doc.dump(), good.bin));
    return loads(folder / "fields.glb");
  });
}

TEST(Fuzz, GlbBytes) {
  const TemporaryFolder folder;
  const Bytes good = fullFile(folder).glb();
  repeat("glb bytes", [&](uint64_t seed) {
    Dice dice(seed);
    Bytes bytes = good;
    mutate(bytes, dice);
    // Half of them with a length that fits, or none would get past the header.
    if (bytes.size() >= 20 && dice.below(2) == 0) {
      const auto size = static_cast<uint32_t>(bytes.size());
      std::memcpy(bytes.data() + 8, &size, 4);
    }
    saveBytes(folder / "bytes.glb", bytes);
    return loads(folder / "bytes.glb");
  });
}

TEST(Fuzz, GltfText) {
  const TemporaryFolder folder;
  fullFile(folder).saveGltf(folder / "good.gltf");
  const Bytes good = readAll(folder / "good.gltf");
  repeat("glTF text", [&](uint64_t seed) {
    Dice dice(seed);
    Bytes bytes = good;
    mutate(bytes, dice);
    saveBytes(folder / "text.gltf", bytes);
    return loads(folder / "text.gltf");
  });
}

TEST(Fuzz, Images) {
  const TemporaryFolder folder;
  Bytes pixels;
  std::vector<float> values;
  for (size_t i = 0; i < 33 * 17 * 3; ++i) {
    pixels.push_back(static_cast<uint8_t>(randomBits(5, i, 0, 0) & 63));
    values.push_back(randomUnit(5, i, 0, 0));
  }
  std::vector<Bytes> good;
  ASSERT_TRUE(writePng(folder / "a.png", 33, 17, 3, pixels).ok());
  good.push_back(readAll(folder / "a.png"));
  ASSERT_TRUE(
      writeExr(folder / "a.exr", 33, 17, std::vector<std::string>{"R", "G", "B"}, values).ok());
  good.push_back(readAll(folder / "a.exr"));
  auto output = OIIO::ImageOutput::create("a.jpg");
  ASSERT_TRUE(
      output->open((folder / "a.jpg").string(), OIIO::ImageSpec(33, 17, 3, OIIO::TypeDesc::UINT8)));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  output->close();
  good.push_back(readAll(folder / "a.jpg"));
  repeat("images", [&](uint64_t seed) {
    Dice dice(seed);
    Bytes bytes = good[seed % good.size()];
    mutate(bytes, dice);
    // Half of the PNGs with right checksums, or none would reach the decoder.
    if (seed % good.size() == 0 && dice.below(2) == 0) repairChecksums(bytes);
    Result<ImageData> image = decodeImage(bytes, "fuzz.img", ColorEncoding::Srgb);
    if (!image.ok()) {
      expectMessage(image.error(), "fuzz.img");
      return false;
    }
    EXPECT_EQ((image->isFloat() ? image->floats.size() : image->bytes.size()),
              static_cast<size_t>(image->width) * static_cast<size_t>(image->height) *
                  static_cast<size_t>(image->channels));
    return true;
  });
}

}  // namespace
}  // namespace scree::test
