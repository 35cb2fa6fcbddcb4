// Grains below a pixel: a bed of a million by the module beside GL_POINTS of one pixel, time against the error of
// the picture, and the module's error by radius.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/app/app.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/core/random.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "modules/lod/lod.h"
#include "modules/occlusion/occlusion.h"
#include "modules/points/points.h"
#include "modules/scene/scene.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

constexpr ivec2 kSize{640, 360};
constexpr int kTruthSamples = 16;

// An octahedron whose triangles were split in four twice, corners on the unit sphere.
MeshData ballMesh() {
  MeshData m;
  m.name = "ball";
  constexpr int kSide = 4;
  for (int face = 0; face < 8; ++face) {
    const vec3 sign((face & 1) != 0 ? -1.0f : 1.0f, (face & 2) != 0 ? -1.0f : 1.0f, (face & 4) != 0 ? -1.0f : 1.0f);
    const bool flipped = sign.x * sign.y * sign.z < 0;
    const auto corner = [&](int i, int j) {
      const vec3 n = glm::normalize(sign * vec3(i, j, kSide - i - j));
      const vec3 side = std::abs(n.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
      m.vertices.push_back({n, n, vec4(glm::normalize(glm::cross(side, n)), 1), vec2(0)});
    };
    const auto triangle = [&](std::array<ivec2, 3> at) {
      const auto first = static_cast<uint32_t>(m.vertices.size());
      for (const ivec2 p : at) corner(p.x, p.y);
      m.indices.insert(m.indices.end(), {first, first + (flipped ? 2u : 1u), first + (flipped ? 1u : 2u)});
    };
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i + j < kSide; ++i) {
        triangle({ivec2(i, j), ivec2(i + 1, j), ivec2(i, j + 1)});
        if (i + j + 1 < kSide) triangle({ivec2(i + 1, j), ivec2(i + 1, j + 1), ivec2(i, j + 1)});
      }
  }
  computeBounds(m);
  return m;
}

constexpr const char* kVertex = R"(#version 450 core
struct Record { float x, y, z; uint rotation, look, size; };
layout(std430, binding = 3) readonly buffer Records { Record records[]; };
layout(location = 0) uniform mat4 clip_from_relative;
layout(location = 1) uniform vec3 origin;
flat out vec3 tint;
void main() {
  Record r = records[gl_VertexID];
  vec3 c = vec3(uvec3(r.look, r.look >> 8u, r.look >> 16u) & 255u) / 255.0;
  tint = c;
  gl_Position = clip_from_relative * vec4(origin + vec3(r.x, r.y, r.z), 1.0);
})";
constexpr const char* kFragment = R"(#version 450 core
flat in vec3 tint;
layout(location = 0) out vec4 albedo;
layout(location = 1) out vec4 normal;
layout(location = 2) uniform vec4 facing;
void main() { albedo = vec4(tint, 0.0); normal = facing; })";

// What a user would write first.
struct GlPoints {
  unsigned program = 0, vertices = 0;
  GlPoints() {
    program = glCreateProgram();
    for (const auto& [kind, text] : {std::pair{GL_VERTEX_SHADER, kVertex}, std::pair{GL_FRAGMENT_SHADER, kFragment}}) {
      const unsigned shader = glCreateShader(static_cast<unsigned>(kind));
      glShaderSource(shader, 1, &text, nullptr);
      glCompileShader(shader);
      glAttachShader(program, shader);
      glDeleteShader(shader);
    }
    glLinkProgram(program);
    int linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked == 0) fail("bench points: the program of GL_POINTS does not link");
    glGenVertexArrays(1, &vertices);
  }
  void draw(const rules::ViewBlock& view, vec3 origin, vec4 facing, uint32_t count) const {
    int program_before = 0, vertices_before = 0;
    glGetIntegerv(GL_CURRENT_PROGRAM, &program_before);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertices_before);
    glUseProgram(program);
    glBindVertexArray(vertices);
    glUniformMatrix4fv(0, 1, GL_FALSE, &view.clip_from_relative[0][0]);
    glUniform3f(1, origin.x, origin.y, origin.z);
    glUniform4f(2, facing.x, facing.y, facing.z, facing.w);
    glDrawArrays(GL_POINTS, 0, static_cast<int>(count));
    glBindVertexArray(static_cast<unsigned>(vertices_before));
    glUseProgram(static_cast<unsigned>(program_before));
  }
};

enum class Way { Grains, GlPoints };

// A bed of balls of this radius in pixels, seen from 30 degrees above it.
struct Picture {
  App app{AppOptions{}};
  World& world = app.world();
  GlPoints gl_points;
  gpu::Buffer records;  // of GL_POINTS
  uint64_t count;
  dvec3 eye;

  Picture(Way way, float radius, uint64_t grains) : count(grains) {
    addScene(app);
    addDeferred(app);
    addOcclusion(app);
    addLod(app);
    addPoints(app);
    app.frame().keep(kRadiance, true);
    app.addPass({.name = "bench.gl_points",
                 .stage = Stage::GeometryLate,
                 .needs_text = "the way of the bench",
                 .needs = [way] { return way == Way::GlPoints; },
                 .uses = gbufferUses(),
                 .run = [this](PassContext&) { drawGlPoints(); }});
    GrainShape shape;
    shape.name = "ball";
    const MeshData mesh = ballMesh();
    if (!addLevels(world.singleton<MeshStore>(), shape, std::span(&mesh, 1)).ok()) fail("bench points: no mesh");
    setMeanLook(world.singleton<MaterialStore>(), shape, std::span(&mesh, 1));
    shape.cast_share = 1;
    const double distance = 600, sine = 0.5, width = 1.15 * kSize.x, length = 1.3 * kSize.y / sine;
    const double depth = static_cast<double>(count) * 4 / 3 * std::numbers::pi * std::pow(static_cast<double>(radius), 3) / (0.56 * width * length);
    const auto fill = [&](uint64_t first, std::span<rules::SwarmRecord> made) {
      for (size_t k = 0; k < made.size(); ++k) {
        const auto unit = [&](uint32_t at) { return randomUnit(1, first + k, 0, at); };
        const float tint = 0.3f + 0.4f * unit(3);
        made[k] = packed({.position = vec3((unit(0) - 0.5f) * static_cast<float>(width), -unit(1) * static_cast<float>(depth),
                                              (unit(2) - 0.5f) * static_cast<float>(length)),
                             .radius = radius,
                             .tint = vec3(tint, 0.8f * tint, 0.6f * tint)},
                         radius);
      }
    };
    if (way == Way::GlPoints) {
      std::vector<rules::SwarmRecord> all(count);
      fill(0, all);
      records = gpu::Buffer("bench.records", all.size() * sizeof(all[0]), all.data());
    } else {
      world.spawn(Transform{}, Swarm{world.singleton<SwarmStore>().add("bed", world.singleton<SwarmStore>().addShape(shape), count, radius, fill)});
    }
    eye = dvec3(0, sine, std::sqrt(1 - sine * sine)) * distance;
    const auto turned = [](dvec3 z) {
      const dvec3 x = glm::normalize(glm::cross(dvec3(0, 1, 0), z));
      return quat(glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)));
    };
    const Transform at{eye, turned(glm::normalize(eye)), vec3(1)};
    world.singleton<ActiveCamera>().entity = world.spawn(
        at, previousOf(at), Camera{.fov_y_rad = static_cast<float>(2 * std::atan(0.5 * kSize.y / distance)), .near_m = 1});
    const Transform sun{dvec3(0), turned(glm::normalize(dvec3(0.5, 1, 0.7))), vec3(1)};
    world.spawn(sun, previousOf(sun), Light{.intensity = 3});
  }
  void drawGlPoints() {
    records.bindStorage(rules::kSwarmRecordsBinding);
    gl_points.draw(world.singleton<const View>().block, vec3(-eye), vec4(0.5f, 0.5f, 0.5f, 1), static_cast<uint32_t>(count));
  }
  void render(uint32_t representation = rules::kPoint, int samples = 1) {
    world.singleton<LodSettings>().only = representation;
    app.render(kSize, 1, 1, samples);
    glFinish();
  }
  std::vector<float> radiance(std::string_view target = kRadiance) { return gpu::readFloats(app.frame().texture(target), 4); }
};

struct Error {
  double mean = 0;   // of the luminance's mean, relative
  double pixel = 0;  // root mean square over the pixels, relative to the mean
};
Error errorOf(const std::vector<float>& drawn, const std::vector<float>& truth) {
  double sum = 0, wanted = 0, square = 0;
  const auto luminance = [](const float* p) {
    return 0.2126 * static_cast<double>(p[0]) + 0.7152 * static_cast<double>(p[1]) + 0.0722 * static_cast<double>(p[2]);
  };
  for (size_t k = 0; k < drawn.size(); k += 4) {
    const double a = luminance(&drawn[k]), b = luminance(&truth[k]);
    sum += a, wanted += b, square += (a - b) * (a - b);
  }
  const double pixels = static_cast<double>(drawn.size()) / 4;
  return {std::abs(sum / wanted - 1), std::sqrt(square / pixels) / (wanted / pixels)};
}

}  // namespace

SCREE_BENCH(points, "grains below a pixel: splatted and summed, beside GL_POINTS") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  constexpr uint64_t kMillion = 1000000;
  const auto row = [&](const char* scenario, Picture& picture, const char* label, double time_ms, const std::vector<float>& truth, bool baseline) {
    picture.render();
    const std::vector<float> drawn = picture.radiance();
    const Error error = errorOf(drawn, truth);
    bench.row({.scenario = scenario,
               .label = label,
               .time_ms = time_ms,
               .error = error.pixel,
               .error_kind = "root mean square of the luminance against 16 samples a pixel of meshes / its mean",
               .hash = hashBytes(drawn.data(), drawn.size() * sizeof(float)),
               .baseline = baseline,
               .measured = {{"mean luminance, %", 100 * error.mean}}});
    return error;
  };
  {
    Picture points(Way::Grains, 0.4f, kMillion), gl_points(Way::GlPoints, 0.4f, kMillion), empty(Way::GlPoints, 0.4f, 1);
    const Paired timed = bench.paired({{"points", [&] { points.render(); }}, {"GL_POINTS", [&] { gl_points.render(); }}, {"an empty frame", [&] { empty.render(); }}});
    points.render(rules::kMesh + 3, bench.quick() ? 4 : kTruthSamples);
    const std::vector<float> truth = points.radiance(kTruth);
    const Error ours = row("a million of 0.4 px", points, "points", timed.variants[0].median_ms, truth, false);
    const Error theirs = row("a million of 0.4 px", gl_points, "GL_POINTS", timed.variants[1].median_ms, truth, true);
    const double frame = timed.variants[2].median_ms;
    bench.claimAtLeast("time of GL_POINTS / points, without an empty frame's",
                       (timed.variants[1].median_ms - frame) / (timed.variants[0].median_ms - frame), 15);
    bench.claimAtMost("error of points / GL_POINTS", ours.pixel / theirs.pixel, 0.5);
    bench.claimAtMost("error of the mean luminance, %", 100 * ours.mean, 3);
  }
}

}  // namespace scree::bench
