// Ways to draw a heap of spheres: the module's exact impostors beside instanced icospheres, time
// against the error of silhouettes and of normals.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <unordered_map>

#include "engine/app/app.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"
#include "shaders/shared/octahedral.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

constexpr ivec2 kSize{640, 360};
constexpr float kFovY = 0.8f;

struct Ball {
  vec3 position;
  float radius;
};

// 5,000 grains that have fallen into a heap on a plane.
std::vector<Ball> heap() {
  App app{AppOptions{}};
  addScene(app);
  addDeferred(app);
  addGrains(app);
  World& world = app.world();
  grainField(world).placed = true;
  GrainBlock block;
  block.count = {20, 25, 10};
  block.radius_jitter = 0.2f;
  block.rolling_friction = 0.05f;
  world.spawn(Transform{.position = {0, 1.6, 0}}, block);
  world.spawn(Transform{}, PlaneCollider{});
  for (int tick = 0; tick < 90; ++tick) app.tick();
  std::vector<Ball> balls;
  world.query<const Grain>().each([&](const Grain& grain) {
    balls.push_back({grain.position, grain.radius});
  });
  return balls;
}

// An icosahedron whose triangles were split in four `splits` times, corners on the unit sphere.
MeshData icosphere(int splits) {
  const float g = std::numbers::phi_v<float>;
  std::vector<vec3> corners{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  std::vector<uint32_t> faces{0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11,
                              1, 5,  9,  5, 11, 4, 11, 10, 2, 10, 7, 6, 7, 1, 8,
                              3, 9,  4,  3, 4,  2, 3, 2, 6, 3, 6,  8,  3, 8,  9,
                              4, 9,  5,  2, 4,  11, 6, 2, 10, 8, 6, 7, 9, 8, 1};
  for (vec3& corner : corners) corner = glm::normalize(corner);
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [found, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(corners.size()));
      if (fresh) corners.push_back(glm::normalize(corners[a] + corners[b]));
      return found->second;
    };
    std::vector<uint32_t> finer;
    for (size_t k = 0; k < faces.size(); k += 3) {
      const uint32_t a = faces[k], b = faces[k + 1], c = faces[k + 2];
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca});
    }
    faces = std::move(finer);
  }
  MeshData mesh;
  mesh.name = "icosphere";
  for (const vec3 corner : corners) {
    const vec3 side = std::abs(corner.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
    mesh.vertices.push_back({corner, corner, vec4(glm::normalize(glm::cross(side, corner)), 1), vec2(0)});
  }
  mesh.indices = std::move(faces);
  computeBounds(mesh);
  return mesh;
}

// The nearest sphere in each pixel, by rays in double precision.
struct Truth {
  std::vector<int> ball;  // -1: none; rows from the bottom
  std::vector<dvec3> normal;
};

struct Eye {
  dvec3 position;
  glm::dmat3 world_from_view;
};

Eye eyeAt(dvec3 from, dvec3 at) {
  const dvec3 z = glm::normalize(from - at), x = glm::normalize(glm::cross(dvec3(0, 1, 0), z));
  return {from, glm::dmat3(x, glm::cross(z, x), z)};
}

Truth truthOf(const std::vector<Ball>& balls, const Eye& eye) {
  const size_t pixels = static_cast<size_t>(kSize.x) * static_cast<size_t>(kSize.y);
  Truth truth{std::vector<int>(pixels, -1), std::vector<dvec3>(pixels)};
  std::vector<double> nearest(pixels, 1e30);
  const double tan_y = std::tan(0.5 * static_cast<double>(kFovY));
  const double scale = 2 * tan_y / kSize.y;  // view units a pixel at distance 1
  for (size_t k = 0; k < balls.size(); ++k) {
    const double r = balls[k].radius;
    const dvec3 to = dvec3(balls[k].position) - eye.position;
    const dvec3 view = glm::transpose(eye.world_from_view) * to;
    const double away = -view.z;
    if (away < 2 * r) continue;
    // Bounds that hold the perspective outline with room to spare.
    const double reach = 1.5 * r / (away - r) / scale + 1;
    const double cx = view.x / away / scale + 0.5 * kSize.x, cy = view.y / away / scale + 0.5 * kSize.y;
    const int x0 = std::max(0, static_cast<int>(cx - reach)), x1 = std::min(kSize.x - 1, static_cast<int>(cx + reach));
    const int y0 = std::max(0, static_cast<int>(cy - reach)), y1 = std::min(kSize.y - 1, static_cast<int>(cy + reach));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const dvec3 ray = glm::normalize(eye.world_from_view *
                                         dvec3((x + 0.5 - 0.5 * kSize.x) * scale, (y + 0.5 - 0.5 * kSize.y) * scale, -1));
        const double along = glm::dot(to, ray), room = r * r - glm::dot(to, to) + along * along;
        if (room < 0) continue;
        const double t = along - std::sqrt(room);
        const size_t at = static_cast<size_t>(y) * static_cast<size_t>(kSize.x) + static_cast<size_t>(x);
        if (t >= nearest[at]) continue;
        nearest[at] = t;
        truth.ball[at] = static_cast<int>(k);
        truth.normal[at] = (t * ray - to) / r;
      }
  }
  return truth;
}

// One way to draw the heap, in an app of its own.
struct Picture {
  App app{AppOptions{}};
  std::unordered_map<uint32_t, int> ball_of_id;

  explicit Picture(const Eye& eye) {
    addScene(app);
    addDeferred(app);
    addGrains(app);
    app.frame().keep(kGbufferId, true);  // errorsOf reads it
    const Transform at{eye.position, quat(glm::quat_cast(eye.world_from_view)), vec3(1)};
    app.world().singleton<ActiveCamera>().entity =
        app.world().spawn(at, previousOf(at), Camera{.fov_y_rad = kFovY});
  }
  void name(Entity entity) {
    ball_of_id[entity.index + 1] = static_cast<int>(ball_of_id.size());
  }
  void showGrains(const std::vector<Ball>& balls) {
    std::vector<GrainSpec> specs(balls.size());
    for (size_t k = 0; k < balls.size(); ++k) specs[k].grain = {balls[k].position, balls[k].radius};
    spawnGrains(app.world(), specs);
    app.world().query<const Grain>().each([&](Entity entity, const Grain&) { name(entity); });
  }
  void showMeshes(const std::vector<Ball>& balls, int splits) {
    const uint32_t mesh = app.world().singleton<MeshStore>().add(icosphere(splits));
    for (const Ball& ball : balls) {
      const Transform at{dvec3(ball.position), quat(1, 0, 0, 0), vec3(ball.radius)};
      name(app.world().spawn(at, previousOf(at), MeshInstance{mesh, 0}));
    }
  }
  void render() {
    app.render(kSize);
    glFinish();
  }
};

struct Errors {
  double silhouette = 0;  // share of the heap's pixels that show another ball, or none
  double normal_deg = 0;  // mean, where the ball is right
  uint64_t hash = 0;
};

Errors errorsOf(Picture& picture, const Truth& truth) {
  picture.render();
  const auto id = gpu::readUints(picture.app.frame().texture(kGbufferId), 1);
  const auto normal = gpu::readFloats(picture.app.frame().texture(kGbufferNormal), 4);
  double covered = 0, wrong = 0, angle = 0, right = 0;
  for (size_t at = 0; at < id.size(); ++at) {
    const auto found = picture.ball_of_id.find(id[at]);
    const int shown = found == picture.ball_of_id.end() ? -1 : found->second;
    covered += truth.ball[at] >= 0;
    wrong += shown != truth.ball[at];
    if (shown < 0 || shown != truth.ball[at]) continue;
    const dvec3 n(rules::octDecode(
        rules::octUnpack24(vec3(normal[4 * at], normal[4 * at + 1], normal[4 * at + 2]))));
    angle += std::atan2(glm::length(glm::cross(n, truth.normal[at])), glm::dot(n, truth.normal[at]));
    ++right;
  }
  return {wrong / covered, angle / right * 180 / std::numbers::pi,
          hashCombine(hashBytes(id.data(), id.size() * sizeof(uint32_t)),
                      hashBytes(normal.data(), normal.size() * sizeof(float)))};
}

}  // namespace

SCREE_BENCH(grain_draw, "a heap of 5,000 spheres: exact impostors beside icospheres") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  const std::vector<Ball> balls = heap();
  struct View {
    const char* name;
    Eye eye;
  };
  for (const View& view : {View{"near", eyeAt({0.4, 1.1, 3.0}, {0, 0.3, 0})},
                           View{"far", eyeAt({1.5, 3.5, 11.0}, {0, 0.3, 0})}}) {
    const Truth truth = truthOf(balls, view.eye);
    Picture impostors(view.eye), coarse(view.eye), fine(view.eye);
    impostors.showGrains(balls);
    coarse.showMeshes(balls, 1);
    fine.showMeshes(balls, 2);
    struct Way {
      const char* label;
      Picture* picture;
      int triangles;
    };
    const std::vector<Way> ways{{"impostors", &impostors, 1},
                                {"icosphere, 80 triangles", &coarse, 80},
                                {"icosphere, 320 triangles", &fine, 320}};
    std::vector<Variant> variants;
    for (const Way& way : ways) variants.push_back({way.label, [&way] { way.picture->render(); }});
    const Paired timed = bench.paired(variants);
    std::vector<Errors> errors;
    for (const Way& way : ways) errors.push_back(errorsOf(*way.picture, truth));
    for (const bool silhouette : {true, false})
      for (size_t k = 0; k < ways.size(); ++k)
        bench.row({.scenario = fmt::format("{}, {}", view.name, silhouette ? "silhouettes" : "normals"),
                   .label = ways[k].label,
                   .knobs = {{"triangles", ways[k].triangles}},
                   .time_ms = timed.variants[k].median_ms,
                   .error = silhouette ? errors[k].silhouette : errors[k].normal_deg,
                   .error_kind = silhouette ? "share of the heap's pixels with a wrong ball"
                                            : "mean angle of the normal, degrees",
                   .hash = errors[k].hash,
                   .baseline = k > 0});
    const std::string where = std::string(", ") + view.name;
    bench.claimAtMost("frame time of impostors / 80 triangles" + where, timed.ratio(0, 1).median, 0.5);
    bench.claimAtMost("frame time of impostors / 320 triangles" + where, timed.ratio(0, 2).median, 0.25);
    bench.claimAtMost("wrong pixels of impostors / 320 triangles" + where,
                      errors[0].silhouette / errors[2].silhouette, 0.05);
    bench.claimAtMost("angle of normals of impostors / 320 triangles" + where,
                      errors[0].normal_deg / errors[2].normal_deg, 0.1);
  }
}

}  // namespace scree::bench
