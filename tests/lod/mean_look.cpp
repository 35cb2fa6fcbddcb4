// The mean look of shapes, against what their materials say.
#include <gtest/gtest.h>

#include "modules/lod/lod.h"
#include "tests/deferred/studio.h"

namespace scree::test {
namespace {

ImageData imageOf(int width, int channels, std::vector<uint8_t> bytes, ColorEncoding encoding) {
  ImageData image;
  image.width = width;
  image.height = 1;
  image.channels = channels;
  image.encoding = encoding;
  image.bytes = std::move(bytes);
  return image;
}

GrainShape lookOf(MaterialStore& materials, const MaterialData& material, vec2 uv_scale = vec2(1)) {
  MeshData sheet = sheetMesh(8);
  sheet.material = static_cast<int>(materials.add(material));
  for (Vertex& vertex : sheet.vertices) vertex.uv *= uv_scale;
  GrainShape shape;
  setMeanLook(materials, shape, std::span(&sheet, 1));
  return shape;
}

// Grey with alpha: its alpha is no color, and no roughness.
TEST(MeanLook, OfGreyImagesIsTheirGrey) {
  MaterialStore materials;
  MaterialData material = plainMaterial(vec3(1, 0.5f, 0.25f), 0.5f, 0.75f);
  material.base_color_map.image = materials.addImage(imageOf(1, 2, {188, 9}, ColorEncoding::Srgb));
  material.metallic_roughness_map.image = materials.addImage(imageOf(1, 2, {102, 255}, ColorEncoding::Linear));
  const GrainShape shape = lookOf(materials, material);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(shape.albedo[c], 0.50289f * material.base_color[c], 1e-4f);  // IEC 61966-2-1 of 188
  EXPECT_NEAR(shape.roughness, 0.4f * 0.75f, 1e-5f);
  EXPECT_NEAR(shape.metallic, 0.4f * 0.5f, 1e-5f);
}

// Black on the left, white on the right, twice across the sheet.
TEST(MeanLook, FollowsTheWrapMode) {
  for (const TextureWrap wrap : {TextureWrap::Repeat, TextureWrap::MirroredRepeat, TextureWrap::ClampToEdge}) {
    MaterialStore materials;
    MaterialData material = plainMaterial(vec3(1), 0, 1);
    material.base_color_map = {.image = materials.addImage(imageOf(2, 3, {0, 0, 0, 255, 255, 255}, ColorEncoding::Linear)), .wrap_u = wrap};
    // Clamped, all but the first half of the first is white.
    EXPECT_NEAR(lookOf(materials, material, {2, 1}).albedo.x, wrap == TextureWrap::ClampToEdge ? 0.75f : 0.5f, 1e-5f);
  }
}

}  // namespace
}  // namespace scree::test
