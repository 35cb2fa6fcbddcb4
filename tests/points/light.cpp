// The light of a bed of balls drawn as points, against many exact rays a pixel.
#include "tests/points/bed.h"

namespace scree::test {
namespace {

class PointLight : public GlTest {};

double meanLuminance(const std::vector<vec3>& radiance) {
  double sum = 0;
  for (const vec3& r : radiance) sum += luminanceOf(dvec3(r));
  return sum / static_cast<double>(radiance.size());
}

struct Weather {
  const char* name;
  float lux;
  Sky sky;
};
const Weather kWeathers[] = {{"sun", 3, {vec3(0), vec3(0), vec3(0)}}, {"sky", 0, Sky{}}, {"sun and sky", 3, Sky{}}};
const dvec3 kSuns[] = {{0.2, 1, 0.8}, {0.1, 0.4, 1}, {1, 0.8, 0}, {-1, 0.4, 0.1}, {0.3, 1, -0.8}, {0.1, 0.4, -1}, {0, 1, 0}};
constexpr size_t kAhead = 5;

// The eye looks at the bed's middle from this angle above it; one pixel there is 1 m, and all of the picture is bed.
struct BedScene : PointScene {
  std::vector<SwarmGrain> grains;
  BedScene(float radius, double elevation_deg, float roughness = 1, float metallic = 0, float shade = 1) : PointScene({32, 24}) {
    const double e = elevation_deg * std::numbers::pi / 180, distance = 200;
    look(dvec3(0, std::sin(e), std::cos(e)) * distance, {0, 0, 0}, static_cast<float>(2 * std::atan(0.5 * size.y / distance)));
    const float half_z = static_cast<float>(0.5 * size.y / std::sin(e)) * 1.5f + 2;
    grains = pouredBed(radius, {0.5f * static_cast<float>(size.x) * 1.3f + 2, half_z}, 6 * radius);
    for (SwarmGrain& grain : grains) grain.tint *= shade;
    show(addBall(vec3(1), roughness, metallic), grains);
  }
};

// Least and most of a bed's luminance / that of many rays, over suns.
struct Range {
  double least = 1e9, most = 0;
  void add(double ratio) { least = std::min(least, ratio), most = std::max(most, ratio); }
  void print() const { std::printf("  %+5.1f to %+5.1f", 100 * (least - 1), 100 * (most - 1)); }
};

// By how much the mean luminance may be off, with sun and sky, sun alone or sky alone. From 22 degrees one sun, low and
// straight ahead, of which little light comes back, is a third too bright: README.md.
TEST_F(PointLight, OfABedIsThatOfManyRays) {
  struct Case {
    float radius;
    double elevation, most, most_sun, most_sky;
  };
  for (const Case& view : {Case{0.5f, 45, 0.012, 0.036, 0.01}, Case{0.5f, 80, 0.012, 0.025, 0.01}, Case{0.3f, 45, 0.012, 0.036, 0.01}, Case{0.5f, 22, 0.04, 0.1, 0.012}}) {
    BedScene scene(view.radius, view.elevation);
    const SeenByRays seen(scene, scene.grains);
    std::printf("%% off, radius %.1f px, from %.0f degrees:", static_cast<double>(view.radius), view.elevation);
    Entity sun{};
    for (const Weather& weather : kWeathers) {
      const bool both = weather.lux > 0 && weather.sky.zenith != vec3(0);
      Range range;
      scene.world.singleton<Sky>() = weather.sky;
      for (const dvec3& to_sun : kSuns) {
        if (scene.world.alive(sun)) scene.world.destroy(sun);
        sun = weather.lux > 0 ? scene.sun(to_sun, vec3(1), weather.lux) : Entity{};
        scene.render();
        const double points = meanLuminance(scene.radiance());
        const double wanted = seen.lit(weather.sky, vec3(glm::normalize(to_sun)), weather.lux, 1, 0).mean;
        range.add(points / wanted);
        const bool ahead = view.elevation < 30 && &to_sun == &kSuns[kAhead];
        const double most_sun = ahead ? 0.37 : view.most_sun;
        EXPECT_NEAR(points / wanted, 1, both ? view.most : weather.lux > 0 ? most_sun : view.most_sky)
            << weather.name << ", radius " << view.radius << " px, from " << view.elevation << " degrees, sun at " << to_sun.x << " " << to_sun.y << " " << to_sun.z;
        if (!(weather.lux > 0)) break;
      }
      std::printf("  %s", weather.name);
      range.print();
    }
    std::printf("\n");
  }
}

// Of glossy balls; dark ones, of whose light half is gloss, too.
TEST_F(PointLight, OfAGlossyBedIsThatOfManyRays) {
  struct Case {
    float roughness, shade;
    double most, most_low;  // README.md has the figures; from 22 degrees
  };
  for (const Case& bed : {Case{0.7f, 1, 0.012, 0.012}, Case{0.45f, 1, 0.012, 0.04}, Case{0.2f, 1, 0.03, 0.042}, Case{0.7f, 0.15f, 0.055, 0.072}, Case{0.45f, 0.15f, 0.08, 0.182}})
    for (const double elevation : {80.0, 45.0, 22.0}) {
      BedScene scene(0.3f, elevation, bed.roughness, 0, bed.shade);
      const SeenByRays seen(scene, scene.grains);
      Range range;
      for (const dvec3& to_sun : kSuns) {
        const Entity sun = scene.sun(to_sun);
        scene.render();
        const double wanted = seen.lit(Sky{}, vec3(glm::normalize(to_sun)), 3, bed.roughness, 0).mean;
        const double ratio = meanLuminance(scene.radiance()) / wanted;
        range.add(ratio);
        EXPECT_NEAR(ratio, 1, elevation > 30 ? bed.most : bed.most_low)
            << "roughness " << bed.roughness << ", shade " << bed.shade << ", from " << elevation << " degrees, sun at " << to_sun.x << " " << to_sun.y << " " << to_sun.z;
        scene.world.destroy(sun);
      }
      std::printf("%% off, roughness %.2f, albedo %.2f, from %.0f degrees:", static_cast<double>(bed.roughness), 0.4 * static_cast<double>(bed.shade), elevation);
      range.print();
      std::printf("\n");
    }
}

}  // namespace
}  // namespace scree::test
