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

// The eye looks at the bed's middle from this angle above it; one pixel there is 1 m, and all of the picture is bed.
struct BedScene : PointScene {
  std::vector<SwarmGrain> grains;
  BedScene(float radius, double elevation_deg, float roughness = 1, float metallic = 0) : PointScene({32, 24}) {
    const double e = elevation_deg * std::numbers::pi / 180, distance = 200;
    look(dvec3(0, std::sin(e), std::cos(e)) * distance, {0, 0, 0}, static_cast<float>(2 * std::atan(0.5 * size.y / distance)));
    const float half_z = static_cast<float>(0.5 * size.y / std::sin(e)) * 1.5f + 2;
    grains = pouredBed(radius, {0.5f * static_cast<float>(size.x) * 1.3f + 2, half_z}, 6 * radius);
    show(addBall(vec3(1), roughness, metallic), grains);
  }
};

TEST_F(PointLight, OfABedIsThatOfManyRays) {
  for (const float radius : {0.5f, 0.3f, 0.15f})
    for (const double elevation : {12.0, 22.0, 45.0, 80.0})
      for (const float roughness : {1.0f, 0.5f}) {
        BedScene scene(radius, elevation, roughness);
        const SeenByRays seen(scene, scene.grains);
        std::printf("%.2f m %.0f deg roughness %.1f, %zu grains, share %.3f\n", static_cast<double>(radius), elevation, static_cast<double>(roughness),
                    scene.grains.size(), seen.lit(Sky{}, vec3(0), 0, 1, 0).share);
        Entity sun{};
        for (const Weather& weather : kWeathers) {
          scene.world.singleton<Sky>() = weather.sky;
          std::printf("  %-12s", weather.name);
          for (const dvec3& to_sun : kSuns) {
            if (scene.world.alive(sun)) scene.world.destroy(sun);
            sun = weather.lux > 0 ? scene.sun(to_sun, vec3(1), weather.lux) : Entity{};
            scene.render();
            const double points = meanLuminance(scene.radiance());
            const double wanted = seen.lit(weather.sky, vec3(glm::normalize(to_sun)), weather.lux, roughness, 0).mean;
            std::printf(" %.4f %+5.1f%%", wanted, 100 * (points / wanted - 1));
            if (weather.lux == 0) break;
          }
          std::printf("\n");
        }
        if (scene.world.alive(sun)) scene.world.destroy(sun);
      }
}

}  // namespace
}  // namespace scree::test
