// A scene for the tests of deferred: an App with scene and deferred, meshes made by code, and reads
// of what was drawn.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/app/app.h"
#include "engine/assets/image_pixels.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "modules/scene/scene.h"
#include "tests/support/gl_fixture.h"

namespace scree::test {

// A sheet of side 2 in the xz plane, normal +Y, uv 0 to 1.
inline MeshData sheetMesh(int cells = 1) {
  MeshData m;
  m.name = "sheet";
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const vec2 uv(static_cast<float>(i) / cells, static_cast<float>(j) / cells);
      m.vertices.push_back({vec3(2 * uv.x - 1, 0, 2 * uv.y - 1), vec3(0, 1, 0), vec4(1, 0, 0, 1), uv});
    }
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto a = static_cast<uint32_t>(j * (cells + 1) + i), b = a + 1;
      const auto c = a + static_cast<uint32_t>(cells) + 1, d = c + 1;
      m.indices.insert(m.indices.end(), {a, c, b, b, c, d});
    }
  computeBounds(m);
  return m;
}

// Radius 1.
inline MeshData sphereMesh(int rings = 48, int sectors = 96) {
  MeshData m;
  m.name = "sphere";
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i <= sectors; ++i) {
      const double theta = std::numbers::pi * j / rings, phi = 2 * std::numbers::pi * (i % sectors) / sectors;
      const dvec3 p(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      m.vertices.push_back({vec3(p), vec3(p), vec4(-std::sin(phi), 0, -std::cos(phi), 1),
                            vec2(static_cast<float>(i) / sectors, static_cast<float>(j) / rings)});
    }
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < sectors; ++i) {
      const auto a = static_cast<uint32_t>(j * (sectors + 1) + i), b = a + 1;
      const auto c = a + static_cast<uint32_t>(sectors) + 1, d = c + 1;
      m.indices.insert(m.indices.end(), {a, c, b, b, c, d});
    }
  computeBounds(m);
  return m;
}

// Half side 1.
inline MeshData boxMesh() {
  MeshData m;
  m.name = "box";
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      vec3 n(0), u(0), v(0);
      n[axis] = side;
      u[(axis + 1) % 3] = 1;
      v[(axis + 2) % 3] = side;
      const auto first = static_cast<uint32_t>(m.vertices.size());
      for (const vec2 c : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)})
        m.vertices.push_back({n + c.x * u + c.y * v, n, vec4(u, 1), c * 0.5f + 0.5f});
      m.indices.insert(m.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
    }
  computeBounds(m);
  return m;
}

inline MaterialData plainMaterial(vec3 color, float metallic, float roughness) {
  MaterialData m;
  m.name = "plain";
  m.base_color = vec4(color, 1);
  m.metallic = metallic;
  m.roughness = roughness;
  return m;
}

// Rotation that turns -Z to `direction`.
inline quat lookAlong(dvec3 direction) {
  const dvec3 z = -glm::normalize(direction);
  const dvec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.99 ? dvec3(0, 1, 0) : dvec3(0, 0, -1), z));
  return quat(glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)));
}

struct Studio {
  App app{AppOptions{}};
  World& world = app.world();
  ivec2 size{160, 120};
  Entity camera;

  explicit Studio(ivec2 output = {160, 120}) : size(output) {
    addScene(app);
    addDeferred(app);
    for (const std::string_view read_by_tests : {kGbufferMotion, kGbufferId, kRadiance})
      app.frame().keep(read_by_tests, true);
  }
  uint32_t mesh(const MeshData& data) { return world.singleton<MeshStore>().add(data); }
  uint32_t material(const MaterialData& data) { return world.singleton<MaterialStore>().add(data); }
  int image(int width, int height, int channels, std::vector<uint8_t> bytes, ColorEncoding encoding) {
    ImageData image;
    image.width = width;
    image.height = height;
    image.channels = channels;
    image.encoding = encoding;
    image.bytes = std::move(bytes);
    return world.singleton<MaterialStore>().addImage(std::move(image));
  }
  // A mesh instance that casts shadows.
  Entity put(uint32_t mesh_handle, uint32_t material_handle, dvec3 position, vec3 scale = vec3(1),
             quat rotation = quat(1, 0, 0, 0)) {
    const Transform t{position, rotation, scale};
    return world.spawn(t, previousOf(t), MeshInstance{mesh_handle, material_handle}, CastsShadow{});
  }
  void look(dvec3 from, dvec3 at, float fov_y_rad = 0.8f, float near_m = 0.1f) {
    const Transform t{from, lookAlong(at - from), vec3(1)};
    if (!world.alive(camera)) {
      camera = world.spawn(t, previousOf(t), Camera{fov_y_rad, near_m});
      world.singleton<ActiveCamera>().entity = camera;
      return;
    }
    *world.find<Transform>(camera) = t;
    *world.find<PreviousTransform>(camera) = previousOf(t);
    *world.find<Camera>(camera) = {fov_y_rad, near_m};
  }
  Entity sun(dvec3 to_sun, vec3 color = vec3(1), float lux = 3) {
    const Transform t{dvec3(0), lookAlong(-to_sun), vec3(1)};
    Light light;
    light.color = color;
    light.intensity = lux;
    return world.spawn(t, previousOf(t), light);
  }
  void uniformSky(vec3 radiance) { world.singleton<Sky>() = {radiance, radiance, radiance}; }

  void render(int samples = 1, float alpha = 1, float motion_scale = 1) {
    app.render(size, alpha, motion_scale, samples);
  }
  std::vector<float> floats(std::string_view target, int channels) {
    return gpu::readFloats(app.frame().texture(target), channels);
  }
  std::vector<vec3> radiance(std::string_view target = kRadiance) {
    const std::vector<float> values = floats(target, 4);
    std::vector<vec3> result(values.size() / 4);
    for (size_t i = 0; i < result.size(); ++i) result[i] = vec3(values[4 * i], values[4 * i + 1], values[4 * i + 2]);
    return result;
  }
  std::vector<uint32_t> ids() { return gpu::readUints(app.frame().texture(kGbufferId), 1); }
  images::Image image() {
    auto shown = images::imageFromBytes(size.x, size.y, 4, gpu::readBytes(app.frame().texture(Frame::kOutput), 4),
                                        RowOrder::BottomUp);
    if (app.frame().hasTexture(kGbufferId)) images::setIds(shown, ids(), RowOrder::BottomUp);
    return shown;
  }
  size_t at(int x, int y) const { return static_cast<size_t>(y) * static_cast<size_t>(size.x) + static_cast<size_t>(x); }
  // Names of the passes that ran in the last frame.
  std::vector<std::string> passes() {
    std::vector<std::string> names;
    for (const PassReport& r : app.frame().report())
      if (r.on) names.push_back(r.name);
    return names;
  }
};

// Where a world point appears, pixels from the bottom left, by a camera placement; in double.
inline glm::dvec2 pixelOf(const Studio& s, const Transform& eye, dvec3 point) {
  const Camera& c = *s.world.peek<Camera>(s.camera);
  const dvec3 v = glm::conjugate(glm::normalize(glm::dquat(eye.rotation))) * (point - eye.position);
  const double f = 1 / std::tan(0.5 * c.fov_y_rad), aspect = static_cast<double>(s.size.x) / s.size.y;
  return {(v.x * f / (aspect * -v.z) + 1) * 0.5 * s.size.x, (v.y * f / -v.z + 1) * 0.5 * s.size.y};
}

struct Ray {
  dvec3 origin;
  dvec3 direction;    // unit
  double along_axis;  // cosine to the view axis
};
inline Ray rayThrough(const Studio& s, const Transform& eye, glm::dvec2 pixel) {
  const Camera& c = *s.world.peek<Camera>(s.camera);
  const double t = std::tan(0.5 * c.fov_y_rad), aspect = static_cast<double>(s.size.x) / s.size.y;
  const dvec3 v((2 * pixel.x / s.size.x - 1) * t * aspect, (2 * pixel.y / s.size.y - 1) * t, -1);
  return {eye.position, glm::normalize(glm::dquat(eye.rotation)) * glm::normalize(v), 1 / glm::length(v)};
}
inline Ray rayThrough(const Studio& s, glm::dvec2 pixel) {
  return rayThrough(s, *s.world.peek<Transform>(s.camera), pixel);
}

}  // namespace scree::test
