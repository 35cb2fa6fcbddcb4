// The CPU copy of what the impostor programs do for a pixel.
#include "modules/impostors/look.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "shaders/shared/brdf.h"
#include "shaders/shared/gbuffer.h"
#include "shaders/shared/spread.h"

namespace scree::impostors {
namespace {

constexpr float kBackground = 0.2f;  // linear
constexpr float kOpaque = 0.5f;

class Look {
 public:
  Look(const ImpostorAtlas& atlas, ImpostorScheme scheme, const Scene& scene)
      : atlas_(atlas),
        scheme_(scheme),
        scene_(scene),
        extent_(rules::impostorExtent(atlas.texels)) {
    const rules::ImpostorViews views = rules::impostorViews(scene.axis, atlas.edge);
    const uint32_t layers[3] = {views.layer0, views.layer1, views.layer2};
    const vec3 axes[3] = {views.axis0, views.axis1, views.axis2};
    for (int k = 0; k < 3; ++k) {
      layer_[k] = static_cast<int>(layers[k]);
      axis_[k] = axes[k];
      weight_[k] = views.weight[k];
    }
    nearest_ = static_cast<int>(std::max_element(weight_, weight_ + 3) - weight_);
    const int last = atlas.levels() - 1;
    shape_level_ = std::min(
        rules::impostorLevel(atlas.texels, scene.diameter_px, rules::kImpostorShapeBias), last);
    color_level_ = std::min(
        rules::impostorLevel(atlas.texels, scene.diameter_px, rules::kImpostorColorBias), last);
    radius_ = 0.5f * (1 + atlas.inner);
  }

  // Share of the views that count which see the grain at a point of the picture, in outer radii from its
  // middle.
  float coverage(vec2 at) {
    const rules::ImpostorRay ray{scene_.right * at.x + scene_.up * at.y, -scene_.axis};
    if (rules::missesEllipsoid(atlas_.bound, ray.foot, ray.direction)) return 0;
    float sum = 0;
    vec3 shared(0);
    if (scheme_ == ImpostorScheme::Spherical) shared = rules::impostorOnSphere(ray, radius_);
    if (scheme_ >= ImpostorScheme::Proxy) shared = rules::impostorOnProxy(ray, atlas_.proxy);
    for (int k = 0; k < 3; ++k) {
      vec3 point = shared;
      if (scheme_ == ImpostorScheme::Planar) point = rules::impostorOnPlane(ray, axis_[k]);
      if (scheme_ == ImpostorScheme::Mixed) point = rules::impostorMixed(ray, axis_[k], radius_);
      if (scheme_ == ImpostorScheme::Parallax) {
        const vec2 first = sampleShape(atlas_, shape_level_, layer_[k],
                                       rules::impostorUv(point, axis_[k], extent_));
        point = rules::impostorStep(ray, point, axis_[k], rules::impostorHeightFromCode(first.y));
      }
      uv_[k] = rules::impostorUv(point, axis_[k], extent_);
      share_[k] = weight_[k] * sampleShape(atlas_, shape_level_, layer_[k], uv_[k]).x;
      if (scheme_ == ImpostorScheme::Nearest) share_[k] = k == nearest_ ? 1 : 0;
      sum += share_[k];
    }
    if (scheme_ == ImpostorScheme::Nearest)
      return sampleShape(atlas_, shape_level_, layer_[nearest_], rules::impostorUv(ray.foot, axis_[nearest_], extent_)).x;
    return sum;
  }

  // Of the point that coverage() was last asked for, where it was not 0.
  Surface surface() const {
    Surface s{.albedo = vec3(0), .normal = vec3(0), .roughness = 0};
    float sum = 0;
    for (int k = 0; k < 3; ++k) {
      if (!(share_[k] > 0)) continue;
      const vec4 color = sampleColor(atlas_, color_level_, layer_[k], uv_[k]);
      const vec4 normal = sampleNormal(atlas_, color_level_, layer_[k], uv_[k]);
      sum += share_[k];
      s.albedo += rules::albedoFromCode(vec3(color)) * share_[k];
      s.metallic += color.w * share_[k];
      s.normal += rules::impostorNormalFromCode(vec3(normal)) * share_[k];
      s.roughness += normal.w * share_[k];
    }
    const float inverse = 1 / sum;
    s.albedo *= inverse;
    s.metallic *= inverse;
    s.roughness *= inverse;
    const float length = glm::length(s.normal) * inverse;
    s.spread = std::clamp(1 - length, 0.0f, rules::kMostSpread);
    s.normal = length > 1e-6f ? s.normal * (inverse / length) : scene_.axis;
    return s;
  }

 private:
  const ImpostorAtlas& atlas_;
  ImpostorScheme scheme_;
  Scene scene_;
  float extent_;
  float radius_ = 1;
  int shape_level_ = 0, color_level_ = 0;
  int layer_[3], nearest_ = 0;
  vec3 axis_[3];
  float weight_[3], share_[3];
  vec2 uv_[3];
};

images::Image blank(int side) {
  return {side,
          side,
          std::vector<float>(static_cast<size_t>(side) * static_cast<size_t>(side) * 3),
          {}};
}

// Pictures have their first row on top.
void set(images::Image& image, int x, int y_up, vec3 linear) {
  const size_t at =
      (static_cast<size_t>(image.height - 1 - y_up) * static_cast<size_t>(image.width) +
       static_cast<size_t>(x)) *
      3;
  for (size_t c = 0; c < 3; ++c)
    image.rgb[at + c] = static_cast<float>(
        images::srgbFromLinear(std::clamp(linear[static_cast<int>(c)], 0.0f, 1.0f)));
}

vec2 pointOf(const Scene& scene, int x, int y, int samples_a_pixel) {
  const float scale = 2 / (scene.diameter_px * static_cast<float>(samples_a_pixel));
  const float middle = 0.5f * static_cast<float>(scene.side_px * samples_a_pixel);
  return vec2(static_cast<float>(x) + 0.5f - middle, static_cast<float>(y) + 0.5f - middle) * scale;
}

}  // namespace

vec3 litSurface(const Surface& s, const Scene& scene) {
  constexpr float kLamp = 0.8f, kAmbient = 0.25f;
  static const vec3 at = glm::normalize(vec3(-0.45f, 0.55f, 0.7f));
  const vec3 lamp = scene.right * at.x + scene.up * at.y + scene.axis * at.z;
  const float n_v = std::clamp(glm::dot(s.normal, scene.axis), 1e-2f, 1.0f);
  rules::Reflectance r{};
  r.f0 = glm::mix(vec3(rules::kDielectricF0), s.albedo, s.metallic);
  r.diffuse = s.albedo * (1 - s.metallic);
  const rules::SpreadLook look = rules::spreadLook(s.normal, lamp, std::max(s.roughness, rules::kMinRoughness), s.spread);
  const vec3 out = (r.diffuse + r.f0) * kAmbient +
                   rules::reflectSpreadBeam(r, s.normal, scene.axis, lamp, n_v, look) * (kLamp * rules::kPi);
  return glm::min(out, vec3(1));
}

images::Image drawImpostor(const ImpostorAtlas& atlas, ImpostorScheme scheme, const Scene& scene) {
  images::Image image = blank(scene.side_px);
  Look look(atlas, scheme, scene);
  for (int y = 0; y < scene.side_px; ++y)
    for (int x = 0; x < scene.side_px; ++x)
      set(image, x, y,
          look.coverage(pointOf(scene, x, y, 1)) >= kOpaque ? litSurface(look.surface(), scene)
                                                            : vec3(kBackground));
  return image;
}

images::Image drawMesh(const UnitGrain& grain, const Scene& scene, int samples) {
  std::vector<Seen> seen;
  cast(grain, scene.shot(samples), seen);
  images::Image image = blank(scene.side_px);
  const auto stride = static_cast<size_t>(scene.side_px) * static_cast<size_t>(samples);
  for (int y = 0; y < scene.side_px; ++y) {
    for (int x = 0; x < scene.side_px; ++x) {
      vec3 sum(0);
      for (int k = 0; k < samples * samples; ++k) {
        const Seen& s = seen[static_cast<size_t>(y * samples + k / samples) * stride +
                             static_cast<size_t>(x * samples + k % samples)];
        sum += s.triangle < 0
                   ? vec3(kBackground)
                   : litSurface(surfaceAt(grain, grain.triangles[static_cast<size_t>(s.triangle)],
                                          s.b, s.c, s.flipped),
                                scene);
      }
      set(image, x, y, sum / static_cast<float>(samples * samples));
    }
  }
  return image;
}

std::vector<uint8_t> impostorMask(const ImpostorAtlas& atlas, ImpostorScheme scheme,
                                  const Scene& scene, int samples) {
  const int side = scene.side_px * samples;
  std::vector<uint8_t> mask(static_cast<size_t>(side) * static_cast<size_t>(side));
  Look look(atlas, scheme, scene);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      mask[static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x)] =
          look.coverage(pointOf(scene, x, y, samples)) >= kOpaque;
  return mask;
}

std::vector<uint8_t> meshMask(const UnitGrain& grain, const Scene& scene, int samples) {
  std::vector<Seen> seen;
  cast(grain, scene.shot(samples), seen);
  std::vector<uint8_t> mask(seen.size());
  for (size_t i = 0; i < seen.size(); ++i) mask[i] = seen[i].triangle >= 0;
  return mask;
}

}  // namespace scree::impostors
