// Views side by side, over a chequered ground that shows their squares.
#include "modules/impostors/sheet.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "modules/impostors/look.h"
#include "shaders/shared/gbuffer.h"

namespace scree {
namespace {

constexpr int kMostPixels = 4096;
constexpr float kGround[2] = {0.10f, 0.14f};  // linear

vec3 texelColor(const ImpostorAtlas& atlas, const impostors::Scene& scene, uint64_t at,
                float ground) {
  const auto code = [](const std::vector<uint8_t>& data, uint64_t i) {
    return static_cast<float>(data[i]) * (1.0f / 255.0f);
  };
  impostors::Surface s;
  s.albedo = rules::albedoFromCode(
      {code(atlas.color, at * 4), code(atlas.color, at * 4 + 1), code(atlas.color, at * 4 + 2)});
  s.metallic = code(atlas.color, at * 4 + 3);
  s.normal = rules::impostorNormalFromCode(
      {code(atlas.normal, at * 4), code(atlas.normal, at * 4 + 1), code(atlas.normal, at * 4 + 2)});
  s.normal = glm::normalize(s.normal);
  s.roughness = code(atlas.normal, at * 4 + 3);
  return glm::mix(vec3(ground), impostors::litSurface(s, scene), code(atlas.shape, at * 2));
}

}  // namespace

images::Image contactSheet(const ImpostorAtlas& atlas) {
  int columns = 1;
  while (columns * columns < atlas.views()) ++columns;
  int level = 0;
  while (level + 1 < atlas.levels() && columns * atlas.side(level) > kMostPixels) ++level;
  const int side = atlas.side(level), rows = (atlas.views() + columns - 1) / columns;
  images::Image sheet{columns * side, rows * side, {}, {}};
  sheet.rgb.resize(sheet.pixels() * 3);
  for (int layer = 0; layer < columns * rows; ++layer) {
    const int left = layer % columns * side, top = layer / columns * side;
    const bool used = layer < atlas.views();
    const vec3 axis =
        rules::impostorViewDirection(static_cast<uint32_t>(used ? layer : 0), atlas.edge);
    const rules::ImpostorBasis basis = rules::impostorBasis(axis);
    const impostors::Scene scene{axis, basis.right, basis.up};
    const float ground = kGround[(layer % columns + layer / columns) % 2];
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const uint64_t texel = static_cast<uint64_t>((side - 1 - y) * side + x);
        const vec3 color =
            used ? texelColor(atlas, scene, atlas.offset(level, layer) + texel, ground) : vec3(0);
        float* to = &sheet.rgb[(static_cast<size_t>(top + y) * static_cast<size_t>(sheet.width) +
                                static_cast<size_t>(left + x)) *
                               3];
        for (int c = 0; c < 3; ++c)
          to[c] = static_cast<float>(images::srgbFromLinear(std::clamp(color[c], 0.0f, 1.0f)));
      }
    }
  }
  return sheet;
}

Status writeContactSheet(const std::filesystem::path& path, const ImpostorAtlas& atlas) {
  return images::writeImage(path, contactSheet(atlas));
}

}  // namespace scree
