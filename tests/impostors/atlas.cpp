// Atlases as files, their table of errors, the choice of their size, and how good they look.
//
// SCREE_FUZZ_SECONDS (default 2) and SCREE_FUZZ_SEED (default 1) change the fuzz run.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "engine/core/random.h"
#include "modules/impostors/look.h"
#include "modules/impostors/measure.h"
#include "modules/impostors/sheet.h"
#include "tests/impostors/shapes.h"

namespace scree {
namespace {

namespace fs = std::filesystem;
using test::model;

class Folder {
 public:
  Folder()
      : path_(fs::path(SCREE_BINARY_DIR) / "impostor_tests" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name()) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

ImpostorAtlas smallAtlas() {
  Result<ImpostorAtlas> atlas =
      bake(test::grainOf(test::globe(8)), {.edge = 2, .texels = 16, .directions = 1});
  if (!atlas.ok()) std::abort();
  return std::move(atlas).value();
}

// ---- Files ----------------------------------------------------------------------------------

TEST(ImpostorFile, ComesBackAsItWas) {
  const ImpostorAtlas atlas = smallAtlas();
  const Folder folder;
  ASSERT_TRUE(writeAtlas(folder / "a.impostor", atlas).ok());
  Result<ImpostorAtlas> read = readAtlas(folder / "a.impostor");
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_TRUE(encodeAtlas(*read) == encodeAtlas(atlas));
  EXPECT_EQ(read->key, atlas.key);
  EXPECT_EQ(read->errors.of[3][5].ssim, atlas.errors.of[3][5].ssim);
  EXPECT_EQ(read->errors.outlines.full, atlas.errors.outlines.full);
  EXPECT_EQ(read->errors.outlines.small, atlas.errors.outlines.small);
  EXPECT_EQ(read->errors.outlines.full_near, atlas.errors.outlines.full_near);
  EXPECT_LT(read->errors.outlines.full[0], 1);
  EXPECT_EQ(read->bytes(), 10u * 6 * (256 + 64 + 16 + 4 + 1));
}

TEST(ImpostorFile, IsBakedOnceAndAgainWhenMeshOrParametersChange) {
  const Folder folder;
  const fs::path mesh = folder / "grain.glb", cache = folder / "grain.impostor";
  fs::copy_file(fs::path(SCREE_SOURCE_DIR) / "content/models/coffee_bean.glb", mesh);
  BakeParameters parameters{.edge = 2, .texels = 16, .directions = 0};
  int reports = 0;
  const auto load = [&] {
    reports = 0;
    Result<ImpostorAtlas> atlas = impostorOf(mesh, parameters, cache, [&](double) { ++reports; });
    return atlas.ok() ? atlas->key : 0;
  };
  const uint64_t first = load();
  EXPECT_NE(first, 0u);
  EXPECT_GT(reports, 0);
  EXPECT_EQ(load(), first);
  EXPECT_EQ(reports, 0);
  parameters.supersample = 2;
  EXPECT_NE(load(), first);
  EXPECT_GT(reports, 0);
  fs::copy_file(fs::path(SCREE_SOURCE_DIR) / "content/models/bolt.glb", mesh,
                fs::copy_options::overwrite_existing);
  load();
  EXPECT_GT(reports, 0);
  // A damaged atlas is replaced, anything else is not.
  Result<std::string> whole = readText(cache);
  ASSERT_TRUE(whole.ok());
  ASSERT_TRUE(writeFile(cache, whole->substr(0, whole->size() / 2)).ok());
  load();
  EXPECT_GT(reports, 0);
  EXPECT_EQ(readText(cache).value(), *whole);
  const fs::path notes = folder / "notes.txt";
  ASSERT_TRUE(writeFile(notes, "notes").ok());
  for (const fs::path& other : {mesh, notes}) {
    const std::string before = readText(other).value();
    EXPECT_TRUE(impostorOf(mesh, parameters, other).ok());
    EXPECT_EQ(readText(other).value(), before) << other;
  }
  load();
  EXPECT_EQ(reports, 0);
}

// The bytes with the hash made right, so that the damage is found by the other checks.
std::string rehashed(std::string bytes) {
  if (bytes.size() < 16) return bytes;
  uint64_t magic;
  std::memcpy(&magic, bytes.data(), 8);
  const uint64_t hash = hashBytes(bytes.data() + 16, bytes.size() - 16, magic);
  std::memcpy(bytes.data() + 8, &hash, 8);
  return bytes;
}

TEST(ImpostorFile, RefusesEachDamageWithOneLine) {
  const std::string good = encodeAtlas(smallAtlas());
  ASSERT_TRUE(decodeAtlas(good, "x").ok());
  const auto refusal = [](const std::string& bytes) {
    Result<ImpostorAtlas> atlas = decodeAtlas(bytes, "x");
    return atlas.ok() ? std::string("accepted") : atlas.error();
  };
  const auto with = [&](size_t at, auto value) {
    std::string bytes = good;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return rehashed(bytes);
  };
  EXPECT_EQ(refusal(""), "x: is no impostor atlas");
  EXPECT_EQ(refusal("glTF2 and some more bytes"), "x: is no impostor atlas");
  EXPECT_EQ(refusal(with(16, 99u)), "x: is of version 99, this program reads 5");
  EXPECT_EQ(refusal(with(20, 1000000u)), "x: has 1000000 views an edge, allowed are 2 to 23");
  EXPECT_EQ(refusal(with(24, 48u)), "x: has 48 texels a side, allowed are 16, 32, 64, 128, 256");
  EXPECT_NE(refusal(with(24, 256u)).find("bytes of texels"), std::string::npos);
  for (size_t at = 36; at < 156; at += 4)
    EXPECT_NE(refusal(with(at, std::nanf(""))), "accepted") << at;
  EXPECT_EQ(refusal(with(108, 0.0f)), "x: its bounding ellipsoid is no ellipsoid");
  EXPECT_EQ(refusal(with(52, 1.5f)), "x: its inner radius is not between 0 and the outer one");
  EXPECT_NE(refusal(with(156, 5000u)), "accepted");
  EXPECT_EQ(refusal(with(160, std::nanf(""))), "x: an error in its table is out of range");
  EXPECT_NE(refusal(rehashed(good.substr(0, 60))), "accepted");
  EXPECT_NE(refusal(rehashed(good + "x")), "accepted");
  std::string flipped = good;
  flipped[good.size() - 5] = static_cast<char>(flipped[good.size() - 5] ^ 1);
  EXPECT_EQ(refusal(flipped), "x: is damaged: its hash differs");
  const Folder folder;
  EXPECT_NE(readAtlas(folder / "none.impostor").error().find("no such file"), std::string::npos);
}

TEST(ImpostorFile, FuzzedFilesAreRefusedOrSound) {
  const char* seconds = std::getenv("SCREE_FUZZ_SECONDS");
  const char* seed = std::getenv("SCREE_FUZZ_SEED");
  const double limit = seconds != nullptr ? std::atof(seconds) : 2;
  const uint64_t first = seed != nullptr ? std::strtoull(seed, nullptr, 10) : 1;
  const std::string good = encodeAtlas(smallAtlas());
  const auto start = std::chrono::steady_clock::now();
  size_t tried = 0, sound = 0;
  for (uint64_t k = first;
       std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < limit;
       ++k, ++tried) {
    std::string bytes = good;
    for (uint64_t d = 0; d < 1 + k % 3; ++d) {
      const uint64_t dice = randomBits(k, d, 0, 0);
      // Half of the damage hits the header.
      const size_t at = dice % (d % 2 == 0 ? std::min<size_t>(bytes.size(), 1200) : bytes.size());
      switch (dice >> 32 & 3) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << (dice >> 40 & 7)));
          break;
        case 1:
          bytes[at] = static_cast<char>(dice >> 48);
          break;
        case 2:
          bytes.resize(std::max<size_t>(at, 1));
          break;
        default:
          bytes.insert(at, bytes, bytes.size() / 2, dice >> 50 & 63);
      }
    }
    Result<ImpostorAtlas> atlas = decodeAtlas(k % 4 == 0 ? bytes : rehashed(bytes), "fuzz");
    if (!atlas.ok()) {
      ASSERT_FALSE(atlas.error().empty());
      ASSERT_EQ(atlas.error().find('\n'), std::string::npos);
      continue;
    }
    ++sound;
    ASSERT_EQ(atlas->shape.size(), atlas->texelCount() * 2);
    ASSERT_EQ(atlas->normal.size(), atlas->texelCount() * 4);
    const images::Image image = impostors::drawImpostor(*atlas, ImpostorScheme::Parallax,
                                                        {.diameter_px = 8, .side_px = 12});
    for (float x : image.rgb) ASSERT_TRUE(std::isfinite(x));
  }
  EXPECT_GT(tried, 100u);
  EXPECT_GT(sound, 0u);
}

// ---- Errors ---------------------------------------------------------------------------------

TEST(ImpostorErrors, LieBetweenTheMeasuredSizesByTheLogarithm) {
  ImpostorErrors errors;
  for (size_t k = 0; k < kImpostorSizes; ++k)
    errors.of[3][k] = {std::log(kImpostorSizesPx[k]), 0, 0, static_cast<float>(k)};
  for (float px : {4.0f, 5.0f, 16.0f, 77.0f, 160.0f})
    EXPECT_NEAR(errors.at(ImpostorScheme::Proxy, px).ssim, std::log(px), 1e-5f);
  EXPECT_EQ(errors.at(ImpostorScheme::Proxy, 1).worst_silhouette_px, 0);
  EXPECT_EQ(errors.at(ImpostorScheme::Proxy, 1e9f).worst_silhouette_px, 10);
  EXPECT_EQ(errors.at(ImpostorScheme::Proxy, std::nanf("")).worst_silhouette_px, 0);
}

TEST(ImpostorErrors, SilhouetteErrorOfAGrownDiscIsItsGrowth) {
  constexpr int kSide = 400, kSamples = 4;
  const auto disc = [](double radius) {
    std::vector<uint8_t> mask;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        mask.push_back(std::hypot(x + 0.5 - 200, y + 0.5 - 200) < radius);
    return mask;
  };
  EXPECT_NEAR(impostors::silhouetteError(disc(104), disc(100), kSide, kSamples), 1.02, 0.03);
  EXPECT_EQ(impostors::silhouetteError(disc(100), disc(100), kSide, kSamples), 0);
  EXPECT_TRUE(std::isfinite(impostors::silhouetteError(disc(100), disc(0), kSide, kSamples)));
}

// The table must be that of the pictures: a ball is a ball from everywhere, so that its impostor is
// nearly perfect, and only the ellipsoid knows where its surface is.
TEST(ImpostorErrors, OfABallAreSmall) {
  Result<ImpostorAtlas> atlas =
      bake(test::grainOf(test::globe(40)), {.edge = 4, .texels = 128, .directions = 6});
  ASSERT_TRUE(atlas.ok());
  const ImpostorError ball = atlas->errors.at(ImpostorScheme::Proxy, 100);
  EXPECT_GT(ball.ssim, 0.98f);
  EXPECT_LT(ball.silhouette_px, 0.15f);
  EXPECT_LE(ball.silhouette_px, ball.worst_silhouette_px);
}

// ---- How the schemes compare, at equal memory ------------------------------------------------

double meanOver(const ImpostorErrors& errors, ImpostorScheme scheme, size_t from,
                float ImpostorError::*member) {
  double sum = 0;
  for (size_t k = from; k < kImpostorSizes; ++k)
    sum += errors.of[static_cast<size_t>(scheme)][k].*member;
  return sum / static_cast<double>(kImpostorSizes - from);
}

TEST(ImpostorSchemes, TheEllipsoidBeatsPlaneSphereAndMixedOnEveryShape) {
  for (const char* name : {"coffee_bean.glb", "pebble.glb", "bolt.glb"}) {
    Result<ImpostorAtlas> atlas = bake(model(name), {.edge = 5, .texels = 64, .directions = 6});
    ASSERT_TRUE(atlas.ok()) << atlas.error();
    const auto of = [&](ImpostorScheme scheme, float ImpostorError::*member) {
      constexpr size_t kFrom = 5;  // 24 px: below, a pixel hides what the schemes differ in
      return meanOver(atlas->errors, scheme, kFrom, member);
    };
    for (ImpostorScheme other :
         {ImpostorScheme::Planar, ImpostorScheme::Spherical, ImpostorScheme::Mixed}) {
      EXPECT_GT(of(ImpostorScheme::Proxy, &ImpostorError::ssim),
                of(other, &ImpostorError::ssim) + 0.003)
          << name;
      EXPECT_LT(of(ImpostorScheme::Proxy, &ImpostorError::flip), of(other, &ImpostorError::flip))
          << name;
      EXPECT_LT(of(ImpostorScheme::Proxy, &ImpostorError::silhouette_px),
                of(other, &ImpostorError::silhouette_px))
          << name;
    }
    EXPECT_GT(of(ImpostorScheme::Parallax, &ImpostorError::ssim),
              of(ImpostorScheme::Proxy, &ImpostorError::ssim))
        << name;
  }
}

// The image of a grain that turns across the equator of its views steps by no more than it does
// elsewhere.
TEST(ImpostorSchemes, ImagesDoNotJumpWhereViewsChange) {
  Result<ImpostorAtlas> atlas =
      bake(model("coffee_bean.glb"), {.edge = 5, .texels = 32, .directions = 0});
  ASSERT_TRUE(atlas.ok());
  const auto image = [&](vec3 axis) {
    axis = glm::normalize(axis);
    const vec3 right = glm::normalize(glm::cross(vec3(0.1f, 0.9f, 0.3f), axis));
    return impostors::drawImpostor(*atlas, ImpostorScheme::Proxy,
                                   {axis, right, glm::cross(axis, right), 40, 44});
  };
  for (int k = 0; k < 48; ++k) {
    const float a = static_cast<float>(k) * 0.1309f;
    const vec3 on(std::cos(a), std::sin(a), 0),
        lattice = rules::impostorViewDirection(static_cast<uint32_t>(k), 5);
    for (const auto& [here, there] : {std::pair{vec3(on.x, on.y, -1e-7f), vec3(on.x, on.y, 1e-7f)},
                                      std::pair{vec3(-1e-7f, on.x, on.y), vec3(1e-7f, on.x, on.y)},
                                      std::pair{lattice, lattice + vec3(1e-6f, -1e-6f, 1e-6f)}}) {
      const images::Image before = image(here), after = image(there);
      size_t differing = 0;
      for (size_t i = 0; i < before.rgb.size(); i += 3)
        differing += std::abs(before.rgb[i] - after.rgb[i]) > 0.02f;
      ASSERT_LE(differing, 2u) << k;  // a pixel whose coverage is one half may flip
    }
  }
}

// ---- Choice ---------------------------------------------------------------------------------

TEST(ImpostorChoice, TakesTheLeastMemoryThatIsGood) {
  const std::vector<std::pair<int, int>> sizes = {{12, 128}, {3, 16}, {6, 64}, {6, 32}, {10, 32}};
  std::vector<std::pair<int, int>> asked;
  const auto flip = [&](int edge, int texels) -> Result<float> {
    asked.emplace_back(edge, texels);
    return 1.0f / static_cast<float>(edge * texels);
  };
  Result<ImpostorChoice> choice =
      chooseImpostor({.max_flip = 1.0f / 192, .max_bytes = uint64_t{1} << 30}, sizes, flip);
  ASSERT_TRUE(choice.ok());
  EXPECT_TRUE(choice->good);
  EXPECT_EQ(std::pair(choice->edge, choice->texels), std::pair(6, 32));
  EXPECT_EQ(asked.size(), 2u);
  // Not good enough within the memory: the best that fits.
  choice = chooseImpostor({.max_flip = 0, .max_bytes = impostorBytes(10, 32)}, sizes, flip);
  ASSERT_TRUE(choice.ok());
  EXPECT_FALSE(choice->good);
  EXPECT_EQ(std::pair(choice->edge, choice->texels), std::pair(10, 32));
  EXPECT_FALSE(chooseImpostor({.max_bytes = 10}, sizes, flip).ok());
  EXPECT_FALSE(chooseImpostor({.diameter_px = std::nanf("")}, sizes, flip).ok());
  EXPECT_FALSE(chooseImpostor({.max_flip = std::nanf("")}, sizes, flip).ok());
}

TEST(ImpostorChoice, AsksForMoreWhereLessErrorIsAllowed) {
  const GrainMesh bean = model("coffee_bean.glb");
  Result<ImpostorChoice> rough = chooseImpostor(bean, {.diameter_px = 16, .max_flip = 0.03f}, 4);
  Result<ImpostorChoice> fine = chooseImpostor(bean, {.diameter_px = 16, .max_flip = 0.016f}, 4);
  ASSERT_TRUE(rough.ok() && fine.ok());
  EXPECT_TRUE(rough->good && fine->good);
  EXPECT_LE(fine->flip, 0.016f);
  EXPECT_LT(rough->bytes, fine->bytes);
}

TEST(ImpostorChoice, IsMeasuredAsItWillBeBaked) {
  const GrainMesh bean = test::model("coffee_bean.glb");
  const auto flipOf = [&](int supersample) {
    Result<ImpostorChoice> choice =
        chooseImpostor(bean, {.diameter_px = 16, .max_flip = 0, .max_bytes = impostorBytes(3, 16), .supersample = supersample}, 2);
    return choice.ok() ? choice->flip : -1;
  };
  EXPECT_GT(flipOf(1), 0);
  EXPECT_NE(flipOf(1), flipOf(4));
}

TEST(ImpostorSheet, ShowsEveryViewAndFits) {
  const ImpostorAtlas atlas = smallAtlas();
  const images::Image sheet = contactSheet(atlas);
  EXPECT_EQ(sheet.width, 3 * 16);
  EXPECT_EQ(sheet.height, 2 * 16);
  for (float x : sheet.rgb) EXPECT_TRUE(x >= 0 && x <= 1);
}

}  // namespace
}  // namespace scree
