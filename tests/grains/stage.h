// A scene of grains for the GPU tests, and what each pixel of it must show, in double precision.
#pragma once

#include <optional>
#include <vector>

#include "modules/grains/grains.h"
#include "tests/deferred/studio.h"

namespace scree::test {

struct Stage : Studio {
  explicit Stage(ivec2 output = {320, 240}) : Studio(output) { addGrains(app); }

  std::vector<GrainSpec> specs;
  // Returns the index in `specs`; show() makes them grains.
  size_t add(vec3 position, float radius, vec3 color = vec3(0.5f)) {
    GrainSpec spec;
    spec.grain = {position, radius};
    spec.look.color = color;
    specs.push_back(spec);
    return specs.size() - 1;
  }
  std::vector<Entity> entities;  // of specs
  void show() {
    spawnGrains(world, specs);
    entities.clear();
    world.query<With<Grain>>().each([&](Entity e) { entities.push_back(e); });
  }
  uint64_t runs(std::string_view pass) { return app.frame().runCount(pass); }
};

struct ExactRay {
  dvec3 origin, direction;  // 1 m along the view axis
};
// The camera in double precision, from its placement alone.
struct ExactCamera {
  dvec3 position;
  glm::dmat3 world_from_view;
  double fov_y, near_m;
  ivec2 size;

  ExactCamera(Stage& stage)
      : position(stage.world.peek<Transform>(stage.camera)->position),
        world_from_view(glm::mat3_cast(glm::normalize(
            glm::dquat(stage.world.peek<Transform>(stage.camera)->rotation)))),
        fov_y(stage.world.peek<Camera>(stage.camera)->fov_y_rad),
        near_m(stage.world.peek<Camera>(stage.camera)->near_m),
        size(stage.size) {}
  ExactRay through(double x_px, double y_px) const {
    const double tan_y = std::tan(0.5 * fov_y), aspect = static_cast<double>(size.x) / size.y;
    const dvec3 view((2 * x_px / size.x - 1) * tan_y * aspect, (2 * y_px / size.y - 1) * tan_y, -1);
    return {position, world_from_view * view};
  }
  // Pixels, and the distance along the view axis in z.
  dvec3 project(dvec3 p) const {
    const dvec3 v = glm::transpose(world_from_view) * (p - position);
    const double tan_y = std::tan(0.5 * fov_y), aspect = static_cast<double>(size.x) / size.y;
    const double w = -v.z;
    return {(v.x / (w * tan_y * aspect) + 1) * 0.5 * size.x, (v.y / (w * tan_y) + 1) * 0.5 * size.y, w};
  }
};

// First intersection of a ray with a sphere seen from outside, in front of the near plane.
struct ExactHit {
  double t = 0;
  dvec3 normal{0};
};
inline std::optional<ExactHit> exactHit(const ExactRay& ray, dvec3 center, double radius, double near_m) {
  const dvec3 o = ray.origin - center;
  const double a = glm::dot(ray.direction, ray.direction), b = glm::dot(o, ray.direction),
               c = glm::dot(o, o) - radius * radius, disc = b * b - a * c;
  if (c <= 0 || disc < 0) return std::nullopt;
  const double t = (-b - std::sqrt(disc)) / a;
  if (t < near_m) return std::nullopt;
  return ExactHit{t, (o + t * ray.direction) / radius};
}

struct Difference {
  int covered = 0;         // pixels that show a grain
  int wrong_id = 0;        // against the oracle, silhouettes and ties left out
  int ambiguous = 0;       // within 0.01 px of a silhouette or a tie
  double off_surface = 0;  // worst distance of the drawn point to the sphere / its distance to the eye
  double normal = 0;       // worst angle of the normal / what is allowed, see compare()
};

// Compares the G-buffer with the oracle, pixel by pixel. Normals may be off by their 12-bit form and
// by what a ray in single precision (1e-6 of the distance) does to them.
inline Difference compare(Stage& stage) {
  const ExactCamera camera(stage);
  const std::vector<uint32_t> id = gpu::readUints(stage.app.frame().texture(kGbufferId), 1);
  const std::vector<float> depth = stage.floats(kGbufferDepth, 1);
  const std::vector<float> normal = stage.floats(kGbufferNormal, 4);
  const dvec3 origin = grainField(stage.world).origin;
  Difference difference;
  const auto nearest = [&](double x, double y, ExactHit& hit) {
    const ExactRay ray = camera.through(x, y);
    int found = -1;
    for (size_t k = 0; k < stage.specs.size(); ++k) {
      const auto h = exactHit(ray, origin + dvec3(stage.specs[k].grain.position),
                              stage.specs[k].grain.radius, camera.near_m);
      if (h && (found < 0 || h->t < hit.t)) {
        hit = *h;
        found = static_cast<int>(k);
      }
    }
    return found;
  };
  for (int y = 0; y < stage.size.y; ++y)
    for (int x = 0; x < stage.size.x; ++x) {
      const size_t at = static_cast<size_t>(y) * static_cast<size_t>(stage.size.x) + static_cast<size_t>(x);
      ExactHit hit;
      const int found = nearest(x + 0.5, y + 0.5, hit);
      const uint32_t want = found < 0 ? 0 : stage.entities[static_cast<size_t>(found)].index + 1;
      difference.covered += id[at] != 0;
      if (id[at] != want) {
        bool edge = false;
        for (const dvec3 d : {dvec3(0.01, 0, 0), dvec3(-0.01, 0, 0), dvec3(0, 0.01, 0), dvec3(0, -0.01, 0)}) {
          ExactHit other;
          edge = edge || nearest(x + 0.5 + d.x, y + 0.5 + d.y, other) != found;
        }
        difference.ambiguous += edge;
        difference.wrong_id += !edge;
        continue;
      }
      if (found < 0) continue;
      const GrainSpec& spec = stage.specs[static_cast<size_t>(found)];
      const ExactRay ray = camera.through(x + 0.5, y + 0.5);
      const dvec3 way = ray.direction * (camera.near_m / static_cast<double>(depth[at]));
      const dvec3 center = origin + dvec3(spec.grain.position);
      const double radius = spec.grain.radius;
      difference.off_surface =
          std::max(difference.off_surface,
                   std::abs(glm::length(ray.origin + way - center) - radius) / glm::length(way));
      const vec3 n = rules::octDecode(
          rules::octUnpack24(vec3(normal[4 * at], normal[4 * at + 1], normal[4 * at + 2])));
      const double cosine = glm::dot(dvec3(n), hit.normal), sine = glm::length(glm::cross(dvec3(n), hit.normal));
      // A ray that is off by `slip` meets a slanted surface elsewhere, by sqrt(2 slip / r) at most.
      const double slip = 1e-6 * glm::length(way);
      const double slant =
          std::max(-glm::dot(hit.normal, glm::normalize(ray.direction)), std::sqrt(2 * slip / radius));
      const double allowed =
          static_cast<double>(rules::kOct24MaxErrorRad) + 2e-4 + slip / (radius * slant);
      difference.normal = std::max(difference.normal, std::atan2(sine, cosine) / allowed);
    }
  return difference;
}

}  // namespace scree::test
