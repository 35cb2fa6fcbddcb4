// Grains below a pixel: a heap of balls from afar, by the module beside GL_POINTS of one pixel: time, light and
// flicker against many samples a pixel of exact spheres.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "engine/app/app.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/core/random.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/grains.h"
#include "modules/lod/lod.h"
#include "modules/occlusion/occlusion.h"
#include "modules/points/points.h"
#include "modules/scene/scene.h"
#include "shaders/shared/octahedral.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

// What --quick changes.
struct Plan {
  size_t balls;
  ivec2 size;
  int samples;  // of the reference
  std::vector<double> distances_m;
};
Plan planOf(bool quick) {
  if (quick) return {100'000, {640, 360}, 16, {5, 6.5, 8, 12, 20, 50}};
  return {1'600'000, {1280, 720}, 64, {5, 6.5, 8, 12, 20, 50}};
}
// The light is measured of fewer and larger ones: what matters is how many pixels they are.
constexpr size_t kLitBalls = 100'000;
constexpr ivec2 kLitSize{640, 360};
constexpr double kFovY = 0.8, kElevation = 0.5236;  // rad: 30 degrees
constexpr float kHeapHeight = 0.6f;                 // m; the cone's radius is 1

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
void main() { albedo = vec4(sqrt(tint), 0.0); normal = facing; })";

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

// Spheres: exact ones, as modules/grains draws them.
enum class Way { Points, GlPoints, Spheres };

// A cone of balls.
struct Heap {
  std::string name;
  std::vector<SwarmGrain> balls;
  float radius = 0;  // m

  void add(vec3 position) {
    const float tint = 0.3f + 0.4f * randomUnit(2, balls.size(), 0, 0);
    balls.push_back({.position = position, .radius = radius, .tint = vec3(tint, 0.8f * tint, 0.6f * tint), .seed = static_cast<uint16_t>(balls.size())});
  }
};
float coneHeight(float x, float z) { return kHeapHeight * (1 - std::hypot(x, z)); }
// Radius of so many balls that fill this share of the cone.
float radiusOf(size_t about, float packing) { return std::cbrt(packing * 0.25f * kHeapHeight / static_cast<float>(about)); }

// At the places of densely packed ones, shaken: layers, and steps where the cone cuts them.
Heap lattice(size_t about) {
  Heap heap{"lattice", {}, radiusOf(about, 0.7405f)};
  const float step = std::sqrt(2.0f) * heap.radius;
  const int across = static_cast<int>(1 / step) + 1;
  for (int y = 0; y <= across; ++y)
    for (int z = -across; z <= across; ++z)
      for (int x = -across; x <= across; ++x) {
        if (((x + y + z) & 1) != 0) continue;
        const auto unit = [&](uint32_t at) { return randomUnit(1, heap.balls.size(), static_cast<uint64_t>(y), at); };
        const vec3 p = vec3(x, y, z) * step + (vec3(unit(0), unit(1), unit(2)) - 0.5f) * (0.3f * heap.radius);
        if (p.y >= 0 && p.y < coneHeight(p.x, p.z)) heap.add(p);
      }
  return heap;
}

// Each fell to that of a few places at random that lies the deepest below the cone's side.
Heap poured(size_t about) {
  Heap heap{"poured", {}, radiusOf(about, 0.55f)};
  const float cell = 2 * heap.radius;
  const int across = static_cast<int>(2 / cell) + 1;
  std::vector<std::array<vec3, 4>> top(static_cast<size_t>(across * across), {vec3(0, -1, 0), vec3(0, -1, 0), vec3(0, -1, 0), vec3(0, -1, 0)});  // the latest in each cell
  std::vector<uint32_t> count(top.size());
  const auto cellAt = [&](float v) { return std::clamp(static_cast<int>((v + 1) / cell), 0, across - 1); };
  uint64_t failed = 0;
  for (uint64_t ball = 0; failed < 200; ++ball) {
    vec3 best(0);
    float most_room = 0;
    for (uint32_t attempt = 0; attempt < 60; ++attempt) {
      const float x = 2 * randomUnit(1, ball, attempt, 0) - 1, z = 2 * randomUnit(1, ball, attempt, 1) - 1;
      const float side = coneHeight(x, z);
      if (side < most_room) continue;
      float y = 0;
      const int i = cellAt(x), j = cellAt(z);
      for (int b = std::max(j - 1, 0); b <= std::min(j + 1, across - 1); ++b)
        for (int a = std::max(i - 1, 0); a <= std::min(i + 1, across - 1); ++a)
          for (const vec3& other : top[static_cast<size_t>(b * across + a)]) {
            const float room = cell * cell - (x - other.x) * (x - other.x) - (z - other.z) * (z - other.z);
            if (room > 0) y = std::max(y, other.y + std::sqrt(room));
          }
      if (side - y > most_room) most_room = side - y, best = {x, y, z};
    }
    failed = most_room > 0 ? 0 : failed + 1;
    if (most_room == 0) continue;
    const auto at = static_cast<size_t>(cellAt(best.z) * across + cellAt(best.x));
    top[at][count[at]++ % 4] = best;
    heap.add(best);
  }
  return heap;
}

// The heap from a distance, 30 degrees above the ground.
struct Picture {
  App app{AppOptions{}};
  World& world = app.world();
  Way way;
  ivec2 size;
  GlPoints gl_points;
  gpu::Buffer records;  // of GL_POINTS
  size_t count;
  Entity heap, camera;
  dvec3 eye;
  bool shadows = false;

  Picture(Way way_in, ivec2 output, const Heap& balls)
      : way(way_in), size(output), count(balls.balls.size()) {
    addScene(app);
    addDeferred(app);
    addOcclusion(app);
    addLod(app);
    addPoints(app);
    addGrains(app);
    app.addSystem({.name = "bench.shadows", .phase = Phase::Prepare, .needs = [this] { return way == Way::Spheres && !shadows; }, .run = [](World& w) { w.singleton<ShadowCasters>() = {}; }});
    app.frame().keep(kRadiance, true);
    app.frame().keep(kGbufferId, true);
    app.addPass({.name = "bench.gl_points",
                 .stage = Stage::GeometryLate,
                 .needs_text = "the way of the bench",
                 .needs = [this] { return way == Way::GlPoints; },
                 .uses = gbufferUses(),
                 .run = [this](PassContext&) { drawGlPoints(); }});
    GrainShape shape;
    shape.name = "ball";
    const MeshData mesh = ballMesh();
    if (!addLevels(world.singleton<MeshStore>(), shape, std::span(&mesh, 1)).ok()) fail("bench points: no mesh");
    setMeanLook(world.singleton<MaterialStore>(), shape, std::span(&mesh, 1));
    if (way == Way::GlPoints) {
      std::vector<rules::SwarmRecord> all(count);
      for (size_t k = 0; k < count; ++k) all[k] = packed(balls.balls[k], balls.radius);
      records = gpu::Buffer("bench.records", all.size() * sizeof(all[0]), all.data());
    } else if (way == Way::Spheres) {
      grainField(world).placed = true;
      std::vector<GrainSpec> specs(count);
      for (size_t k = 0; k < count; ++k) {
        specs[k].grain = {balls.balls[k].position, balls.radius};
        specs[k].look = {balls.balls[k].tint, 1};
      }
      spawnGrains(world, specs);
    } else {
      SwarmStore& store = world.singleton<SwarmStore>();
      heap = world.spawn(Transform{}, Swarm{store.add("heap", store.addShape(shape), balls.balls)});
    }
    world.singleton<LodSettings>().only = rules::kPoint;
    camera = world.spawn(Transform{}, PreviousTransform{}, Camera{});
    world.singleton<ActiveCamera>().entity = camera;
    const Transform sun{dvec3(0), turned(glm::normalize(dvec3(0.5, 1, 0.7))), vec3(1)};
    world.spawn(sun, previousOf(sun), Light{.intensity = 3});
    look(8);
  }
  static quat turned(dvec3 z) {
    const dvec3 x = glm::normalize(glm::cross(dvec3(0, 1, 0), z));
    return quat(glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)));
  }
  // `aside`: pixels by which the picture slides.
  void look(double distance, double aside = 0) {
    const dvec3 out(0, std::sin(kElevation), std::cos(kElevation));
    const double pixel_m = distance * 2 * std::tan(0.5 * kFovY) / size.y;
    eye = dvec3(aside * pixel_m, 0.2, 0) + out * distance;
    const Transform at{eye, turned(out), vec3(1)};
    *world.find<Transform>(camera) = at;
    *world.find<PreviousTransform>(camera) = previousOf(at);
    *world.find<Camera>(camera) = {static_cast<float>(kFovY), 0.1f};
  }
  void castShadows(bool cast) {
    shadows = cast;
    if (way != Way::Points) return;
    if (cast) world.add(heap, CastsShadow{});
    if (!cast) world.remove<CastsShadow>(heap);
  }
  void drawGlPoints() {
    records.bindStorage(rules::kSwarmRecordsBinding);
    gl_points.draw(world.singleton<const View>().block, vec3(-eye), vec4(rules::octPack24(rules::octEncode(vec3(glm::normalize(eye)))), 1), static_cast<uint32_t>(count));
  }
  void render(int samples = 1) {
    app.render(size, 1, 1, samples);
    glFinish();
  }
  std::vector<double> luminance(std::string_view target = kRadiance) {
    const std::vector<float> p = gpu::readFloats(app.frame().texture(target), 4);
    std::vector<double> all(p.size() / 4);
    for (size_t k = 0; k < all.size(); ++k)
      all[k] = 0.2126 * static_cast<double>(p[4 * k]) + 0.7152 * static_cast<double>(p[4 * k + 1]) + 0.0722 * static_cast<double>(p[4 * k + 2]);
    return all;
  }
  std::vector<double> truth(int samples) {
    render(samples);
    return luminance(samples > 1 ? kTruth : kRadiance);
  }
  // Pixels around which there are grains on all sides.
  std::vector<bool> inside() {
    const std::vector<uint32_t> ids = gpu::readUints(app.frame().texture(kGbufferId), 1);
    std::vector<bool> all(ids.size());
    for (int y = 1; y + 1 < size.y; ++y)
      for (int x = 1; x + 1 < size.x; ++x) {
        bool every = true;
        for (int k = 0; k < 9; ++k) every = every && ids[static_cast<size_t>((y + k / 3 - 1) * size.x + x + k % 3 - 1)] != 0;
        all[static_cast<size_t>(y * size.x + x)] = every;
      }
    return all;
  }
};

struct Error {
  double mean = 0;   // of the luminance's mean, relative
  double pixel = 0;  // root mean square over the pixels, relative to the mean
  size_t pixels = 0;
};
Error errorOf(const std::vector<double>& drawn, const std::vector<double>& truth, const std::vector<bool>& where) {
  double sum = 0, wanted = 0, square = 0;
  size_t pixels = 0;
  for (size_t k = 0; k < drawn.size(); ++k)
    if (where[k]) sum += drawn[k], wanted += truth[k], square += (drawn[k] - truth[k]) * (drawn[k] - truth[k]), ++pixels;
  const auto n = static_cast<double>(pixels);
  return {sum / wanted - 1, std::sqrt(square / n) / (wanted / n), pixels};
}

double deviation(const std::vector<double>& values) {
  double sum = 0, sum2 = 0;
  for (const double v : values) sum += v, sum2 += v * v;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(std::max(sum2 / n - sum * sum / n / n, 0.0));
}

// Mean over the heap's pixels of how much each changes while the picture slides by a pixel: points / 16 samples.
double flicker(Picture& points, Picture& spheres, double distance) {
  constexpr int kSteps = 8;
  std::vector<std::vector<double>> of_points, of_samples;
  std::vector<bool> where;
  for (int step = 0; step < kSteps; ++step) {
    for (Picture* picture : {&points, &spheres}) picture->look(distance, static_cast<double>(step) / kSteps);
    points.render();
    of_points.push_back(points.luminance());
    const std::vector<bool> inside = points.inside();
    where.resize(inside.size(), true);
    for (size_t k = 0; k < inside.size(); ++k) where[k] = where[k] && inside[k];
    of_samples.push_back(spheres.truth(16));
  }
  double change = 0, change_of_samples = 0;
  for (size_t k = 0; k < where.size(); ++k) {
    if (!where[k]) continue;
    std::vector<double> a, b;
    for (int step = 0; step < kSteps; ++step) a.push_back(of_points[static_cast<size_t>(step)][k]), b.push_back(of_samples[static_cast<size_t>(step)][k]);
    change += deviation(a), change_of_samples += deviation(b);
  }
  return change / change_of_samples;
}

// Times, and the least gain over GL_POINTS at any distance.
double measureTime(Bench& bench, const Plan& plan, const Heap& heap) {
  Picture points(Way::Points, plan.size, heap), gl_points(Way::GlPoints, plan.size, heap), empty(Way::Points, plan.size, Heap());
  double least_gain = 1e30;
  for (const double distance : plan.distances_m) {
    for (Picture* picture : {&points, &gl_points, &empty}) picture->look(distance);
    const Paired timed = bench.paired({{"points", [&] { points.render(); }}, {"GL_POINTS", [&] { gl_points.render(); }}, {"an empty frame", [&] { empty.render(); }}});
    const auto ms = [&](size_t way) { return timed.variants[way].median_ms; };
    const double gain = (ms(1) - ms(2)) / std::max(ms(0) - ms(2), 1e-3);
    bench.progress("points: {} m: points {:.1f} ms, GL_POINTS {:.1f} ms, an empty frame {:.1f} ms, {:.1f} times", distance, ms(0), ms(1), ms(2), gain);
    least_gain = std::min(least_gain, gain);
    bench.fact(fmt::format("{} balls from {} m, ms: points, GL_POINTS, an empty frame, gain", heap.balls.size(), distance), fmt::format("{:.1f}, {:.1f}, {:.1f}, {:.1f}", ms(0), ms(1), ms(2), gain));
  }
  return least_gain;
}

struct Worst {
  double mean = 0, shadowed = 0, pixel = 0;
};
// Light of a heap, and what was off at most.
Worst measureLight(Bench& bench, int samples, const std::vector<double>& distances_m, const Heap& heap) {
  Picture points(Way::Points, kLitSize, heap), gl_points(Way::GlPoints, kLitSize, heap), spheres(Way::Spheres, kLitSize, heap);
  Worst worst;
  for (const double distance : distances_m) {
    const double radius_px = static_cast<double>(heap.radius) * kLitSize.y / (2 * std::tan(0.5 * kFovY) * distance);
    for (Picture* picture : {&points, &gl_points, &spheres}) picture->look(distance);
    std::vector<bool> inside;
    const auto errors = [&](bool shadows) {
      for (Picture* picture : {&points, &spheres}) picture->castShadows(shadows);
      points.render();
      gl_points.render();
      inside = points.inside();
      const std::vector<double> truth = spheres.truth(samples);
      return std::array{errorOf(points.luminance(), truth, inside), errorOf(gl_points.luminance(), truth, inside)};
    };
    const auto with = errors(true), without = errors(false);
    const Paired timed = bench.paired({{"points", [&] { points.render(); }}, {"GL_POINTS", [&] { gl_points.render(); }}});
    bench.progress("points: {} heap, {} m, {:.2f} px: {:+.1f} %, with shadows {:+.1f} %", heap.name, distance, radius_px, 100 * without[0].mean, 100 * with[0].mean);
    for (const size_t way : {0, 1})
      bench.row({.scenario = fmt::format("{} heap of {} balls, from {} m, radius {:.2f} px", heap.name, heap.balls.size(), distance, radius_px),
                 .label = way == 0 ? "points" : "GL_POINTS",
                 .knobs = {{"distance, m", distance}},
                 .time_ms = timed.variants[way].median_ms,
                 .error = without[way].pixel,
                 .error_kind = fmt::format("root mean square of the luminance against {} samples a pixel of exact spheres / its mean", samples),
                 .baseline = way == 1,
                 .measured = {{"mean luminance, %", 100 * without[way].mean}, {"with shadows, %", 100 * with[way].mean}, {"pixels", without[way].pixels}}});
    worst.mean = std::max(worst.mean, std::abs(without[0].mean));
    worst.shadowed = std::max(worst.shadowed, std::abs(with[0].mean));
    worst.pixel = std::max(worst.pixel, without[0].pixel / without[1].pixel);
  }
  return worst;
}

}  // namespace

SCREE_BENCH(points, "grains below a pixel: splatted and summed, beside GL_POINTS") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  bench.sweeps("distance, m");
  const Plan plan = planOf(bench.quick());
  const double least_gain = measureTime(bench, plan, lattice(plan.balls));
  bench.claimAtLeast("time of GL_POINTS / points, without an empty frame's, least of the distances", least_gain, 15);
  for (const Heap& heap : {poured(kLitBalls), lattice(kLitBalls)}) {
    const Worst worst = measureLight(bench, plan.samples, plan.distances_m, heap);
    bench.claimAtMost(fmt::format("{} heap: error of the mean luminance, %, worst of the distances", heap.name), 100 * worst.mean, 2);
    bench.claimAtMost(fmt::format("{} heap: the same with shadows", heap.name), 100 * worst.shadowed, 2);
    bench.claimAtMost(fmt::format("{} heap: error of a pixel, points / GL_POINTS", heap.name), worst.pixel, 0.5);
  }
  const Heap small = poured(20'000);
  constexpr ivec2 kSlidSize{160, 90};
  Picture points(Way::Points, kSlidSize, small), spheres(Way::Spheres, kSlidSize, small);
  bench.claimAtMost("flicker over a slide of a pixel, points / 16 samples", flicker(points, spheres, 4), 1);
  for (Picture* picture : {&points, &spheres}) picture->castShadows(true);
  for (const double distance : {2.5, 4.0, 12.0})
    bench.claimAtMost(fmt::format("flicker over a slide of a pixel with shadows, {:.2f} px, points / 16 samples", static_cast<double>(small.radius) * kSlidSize.y / (2 * std::tan(0.5 * kFovY) * distance)),
                      flicker(points, spheres, distance), 1);
}

}  // namespace scree::bench
