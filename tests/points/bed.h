// A scene of points, beds of balls to draw in it, and what many exact rays a pixel see of them, by the CPU.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "modules/deferred/lobe_table.h"
#include "modules/points/points.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {

struct PointScene : SwarmScene {
  explicit PointScene(ivec2 output = {96, 64}) : SwarmScene(output) {
    addPoints(app);
    drawAs(rules::kPoint);
  }
  void drawAs(uint32_t representation) { world.singleton<LodSettings>().only = representation; }
  uint32_t addBall(vec3 color = vec3(1), float roughness = 1, float metallic = 0) {
    GrainShape shape;
    shape.name = "ball";
    shape.inner_radius = 0.97f;
    MeshData mesh = sphereMesh(8, 12);
    mesh.material = static_cast<int>(material(plainMaterial(color, metallic, roughness)));
    EXPECT_TRUE(addLevels(world.singleton<MeshStore>(), shape, std::span(&mesh, 1)).ok());
    setMeanLook(world.singleton<MaterialStore>(), shape, std::span(&mesh, 1));
    shape.cast_share = shape.facing = 1;  // of the ball, not of the mesh inside it
    return world.singleton<SwarmStore>().addShape(shape);
  }
};

inline double luminanceOf(dvec3 r) { return r.x * 0.2126 + r.y * 0.7152 + r.z * 0.0722; }

// Balls that fell to the lowest of a few random places each, in a box with this half extent in x and z, until the
// bed is this deep; its surface at y = 0.
inline std::vector<SwarmGrain> pouredBed(float radius, glm::vec2 half, float depth, uint64_t seed = 1) {
  const double cell = 2 * static_cast<double>(radius);
  const int columns = static_cast<int>(2 * half.x / cell) + 1, rows = static_cast<int>(2 * half.y / cell) + 1;
  std::vector<std::vector<dvec3>> cells(static_cast<size_t>(columns * rows));
  const auto cellAt = [&](double v, float extent, int count) {
    return std::clamp(static_cast<int>((v + static_cast<double>(extent)) / cell), 0, count - 1);
  };
  constexpr double kPacking = 0.55;
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(static_cast<double>(radius), 3);
  const auto count = static_cast<uint64_t>(kPacking * 4 * static_cast<double>(half.x * half.y * depth) / ball);
  std::vector<SwarmGrain> grains(count);
  for (uint64_t k = 0; k < count; ++k) {
    dvec3 best(0, 1e30, 0);
    for (uint32_t attempt = 0; attempt < 60; ++attempt) {
      const double x = (2 * static_cast<double>(randomUnit(seed, k, attempt, 0)) - 1) * static_cast<double>(half.x);
      const double z = (2 * static_cast<double>(randomUnit(seed, k, attempt, 1)) - 1) * static_cast<double>(half.y);
      double y = 0;
      const int i = cellAt(x, half.x, columns), j = cellAt(z, half.y, rows);
      for (int b = std::max(j - 1, 0); b <= std::min(j + 1, rows - 1); ++b)
        for (int a = std::max(i - 1, 0); a <= std::min(i + 1, columns - 1); ++a)
          for (const dvec3& other : cells[static_cast<size_t>(b * columns + a)]) {
            const double room = cell * cell - (x - other.x) * (x - other.x) - (z - other.z) * (z - other.z);
            if (room > 0) y = std::max(y, other.y + std::sqrt(room));
          }
      if (y < best.y) best = {x, y, z};
    }
    cells[static_cast<size_t>(cellAt(best.z, half.y, rows) * columns + cellAt(best.x, half.x, columns))].push_back(best);
    grains[k].position = vec3(best);
    grains[k].radius = radius;
    const float tint = 0.3f + 0.4f * randomUnit(seed, k, 0, 3);
    grains[k].tint = vec3(tint, 0.8f * tint, 0.6f * tint);
  }
  std::vector<float> heights;
  for (const SwarmGrain& grain : grains) heights.push_back(grain.position.y);
  const auto top = heights.end() - static_cast<long>(heights.size() / 20);
  std::nth_element(heights.begin(), top, heights.end());
  for (SwarmGrain& grain : grains) grain.position.y -= *top;
  return grains;
}

// What kRays x kRays exact rays a pixel see of balls.
struct SeenByRays {
  static constexpr int kRays = 6;
  struct Hit {
    int ball = -1;
    vec3 normal, to_eye, tint;
  };
  ivec2 rays;
  std::vector<Hit> hits;  // rows from the bottom

  SeenByRays(const Studio& scene, const std::vector<SwarmGrain>& balls) : rays(scene.size * kRays) {
    const Transform& eye = *scene.world.peek<Transform>(scene.camera);
    const double tangent = std::tan(0.5 * static_cast<double>(scene.world.peek<Camera>(scene.camera)->fov_y_rad));
    const double scale = 2 * tangent / rays.y;  // of one ray to the next, at distance 1
    const auto from_world = glm::dmat3(glm::mat3_cast(glm::conjugate(eye.rotation)));
    const auto pixels = static_cast<size_t>(rays.x) * static_cast<size_t>(rays.y);
    hits.resize(pixels);
    std::vector<double> nearest(pixels, 1e30);
    for (size_t k = 0; k < balls.size(); ++k) {
      const double radius = static_cast<double>(balls[k].radius);
      const dvec3 to = from_world * (dvec3(balls[k].position) - eye.position);
      if (-to.z < 2 * radius) continue;
      const double reach = 1.5 * radius / (-to.z - radius) / scale + 1;
      const double cx = to.x / -to.z / scale + 0.5 * rays.x, cy = to.y / -to.z / scale + 0.5 * rays.y;
      const int x0 = std::max(0, static_cast<int>(cx - reach)), x1 = std::min(rays.x - 1, static_cast<int>(cx + reach));
      const int y0 = std::max(0, static_cast<int>(cy - reach)), y1 = std::min(rays.y - 1, static_cast<int>(cy + reach));
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
          const dvec3 ray = glm::normalize(dvec3((x + 0.5 - 0.5 * rays.x) * scale, (y + 0.5 - 0.5 * rays.y) * scale, -1));
          const double along = glm::dot(to, ray), room = radius * radius - glm::dot(to, to) + along * along;
          if (room < 0 || along - std::sqrt(room) >= nearest[static_cast<size_t>(y * rays.x + x)]) continue;
          const auto at = static_cast<size_t>(y * rays.x + x);
          nearest[at] = along - std::sqrt(room);
          hits[at] = {static_cast<int>(k), vec3(glm::transpose(from_world) * ((nearest[at] * ray - to) / radius)),
                      vec3(glm::transpose(from_world) * -ray), balls[k].tint};
        }
    }
  }

  // Mean luminance of those that hit a ball, without shadows, and their share.
  struct Light {
    double mean = 0, share = 0;
  };
  Light lit(const Sky& sky, vec3 to_sun, float lux, float roughness, float metallic) const {
    static const std::vector<vec4> table = makeLobeTable();
    const rules::SkyPolynomial polynomial = rules::skyPolynomial(sky.zenith, sky.horizon, sky.ground);
    roughness = std::max(roughness, rules::kMinRoughness);
    double sum = 0, count = 0;
    for (const Hit& hit : hits) {
      if (hit.ball < 0) continue;
      const float n_v = glm::clamp(glm::dot(hit.normal, hit.to_eye), 1e-4f, 1.0f);
      const rules::LobeTerms lobe = sampleLobeTable(table, n_v, roughness);
      const rules::Reflectance r = rules::reflectance(hit.tint, metallic, lobe.a, lobe.b);
      vec3 light = rules::reflectSky(polynomial, r, lobe, hit.normal, hit.to_eye, n_v, roughness, vec2(hit.normal.y, hit.normal.y * hit.normal.y));
      if (lux > 0) light += lux * rules::reflectBeam(r, hit.normal, hit.to_eye, to_sun, glm::dot(hit.normal, to_sun), n_v, rules::alphaFromRoughness(roughness));
      sum += luminanceOf(light);
      ++count;
    }
    return {sum / count, count / static_cast<double>(hits.size())};
  }
};

}  // namespace scree::test
